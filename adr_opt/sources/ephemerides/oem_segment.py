"""Segments of CCSDS Orbit Ephemeris Messages: their metadata and states."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from ...common.errors import InputError
from ..catalogue.records import shown
from .ephemeris import Array
from .interpolation import METHODS, USUAL

NEEDED = (
    "OBJECT_NAME",
    "OBJECT_ID",
    "CENTER_NAME",
    "REF_FRAME",
    "TIME_SYSTEM",
    "START_TIME",
    "STOP_TIME",
)
"""Keywords that the metadata of a segment must have."""

COLUMNS = (7, 10)
"""Number of columns of a state: time, position and velocity, and perhaps acceleration."""

Rows = list[tuple[int, str]]
"""States while a file is read: line number and text of each."""


@dataclass(frozen=True)
class MessageSegment:
    """A segment of a message.

    Attributes
    ----------
    source : str
        The file.
    line : int
        Where its metadata begin.
    fields : dict
        Metadata by keyword.
    rows : tuple of str
        Lines of states.
    row_lines : tuple of int
        Where each of them stands in the file.
    covariance_rows : tuple of str
        Lines of covariances, their keywords included; those of XML are not read.
    """

    source: str
    line: int
    fields: dict[str, str]
    rows: tuple[str, ...]
    row_lines: tuple[int, ...]
    covariance_rows: tuple[str, ...] = ()

    @property
    def where(self) -> str:
        """File, line of the metadata and object, for messages."""
        return self.at(self.line)

    def at(self, line: int) -> str:
        """File, a line and object, for messages."""
        return f"{self.source}: line {line} ({shown(self.fields['OBJECT_NAME'])})"

    @property
    def names(self) -> tuple[str, str]:
        """Name of the object and its designator."""
        return self.fields["OBJECT_NAME"], self.fields["OBJECT_ID"]

    def says(self, keyword: str, default: str) -> str:
        """Value of a keyword in capitals."""
        return self.fields.get(keyword, default).upper()

    @property
    def method(self) -> tuple[str, int]:
        """Method of interpolation and its degree.

        Raises
        ------
        InputError
            Neither is known here.
        """
        usual, usual_degree = USUAL
        method = self.says("INTERPOLATION", usual)
        if method not in METHODS:
            raise InputError(
                f"{self.where}: INTERPOLATION = {shown(method)}: must be one of "
                f"{', '.join(METHODS)}"
            )
        text = self.fields.get("INTERPOLATION_DEGREE", str(usual_degree))
        if not text.isdecimal() or not 1 <= int(text) <= 31:
            raise InputError(
                f"{self.where}: INTERPOLATION_DEGREE = {shown(text)}: must be from 1 to 31"
            )
        return method, int(text)

    def states(self) -> tuple[list[str], Array]:
        """Times as written in the message, and states, shape (states, 6) [m, m/s].

        Raises
        ------
        InputError
            A row is no state.
        """
        times, numbers = [], []
        for at, row in enumerate(self.rows):
            parts = row.split()
            try:
                if len(parts) not in COLUMNS:
                    raise ValueError
                numbers.append([float(part) for part in parts[1:7]])
            except ValueError:
                raise InputError(
                    f"{self.at(self.row_lines[at])}: {shown(row)!r} is not a time with six numbers"
                ) from None
            times.append(parts[0])
        states = 1e3 * np.array(numbers)
        bad = np.flatnonzero(~np.isfinite(states).all(axis=1))
        if bad.size:
            raise InputError(f"{self.at(self.row_lines[bad[0]])}: a state is not finite")
        return times, states


def segment_of(
    source: str, line: int, fields: dict[str, str], rows: Rows, covariance_rows: Sequence[str] = ()
) -> MessageSegment:
    """A segment from its parts, checked for required metadata and states.

    Raises
    ------
    InputError
        It has not.
    """
    missing = [keyword for keyword in NEEDED if not fields.get(keyword)]
    if missing:
        raise InputError(f"{source}: line {line}: {missing[0]} is missing")
    lines, texts = tuple(zip(*rows, strict=True)) or ((), ())
    segment = MessageSegment(source, line, fields, texts, lines, tuple(covariance_rows))
    if len(rows) < 2:
        raise InputError(f"{segment.where}: fewer than two states")
    return segment
