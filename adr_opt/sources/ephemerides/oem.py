"""CCSDS Orbit Ephemeris Messages (502.0-B, section 5), in key-value notation here.

Reading finds the segments and their metadata; the states of a segment are parsed when they are
asked for.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from ...common.errors import InputError
from ..catalogue.records import shown
from .ephemeris import Array
from .interpolation import METHODS, USUAL

NEEDED = ("OBJECT_NAME", "OBJECT_ID", "CENTER_NAME", "REF_FRAME", "TIME_SYSTEM", "START_TIME",
          "STOP_TIME")  # fmt: skip
"""Keywords that the metadata of a segment must have."""

COLUMNS = (7, 10)
"""Number of columns of a state: time, position and velocity, and perhaps acceleration."""


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
    """

    source: str
    line: int
    fields: dict[str, str]
    rows: tuple[str, ...]

    @property
    def where(self) -> str:
        """File, line and object, for messages."""
        return f"{self.source}: line {self.line} ({shown(self.fields['OBJECT_NAME'])})"

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
        """Times as they stand there, and states, shape (states, 6) [m, m/s].

        Raises
        ------
        InputError
            A row is no state.
        """
        times, numbers = [], []
        for row in self.rows:
            parts = row.split()
            try:
                if len(parts) not in COLUMNS:
                    raise ValueError
                numbers.append([float(part) for part in parts[1:7]])
            except ValueError:
                raise InputError(
                    f"{self.where}: {shown(row)!r} is no time with six numbers"
                ) from None
            times.append(parts[0])
        states = 1e3 * np.array(numbers)
        if not np.isfinite(states).all():
            raise InputError(f"{self.where}: a state is not finite")
        return times, states


def read_oem(content: bytes, source: str) -> list[MessageSegment]:
    """The segments of a message.

    Raises
    ------
    InputError
        It is none, or a segment lacks metadata or states.
    """
    text = content.decode("utf-8", "replace").lstrip("\ufeff \t\r\n")
    if text.startswith("<"):
        from .oem_xml import read_xml

        found = read_xml(content, source)
    elif text.startswith("CCSDS_OEM_VERS"):
        found = list(_segments(text, source))
    else:
        raise InputError(f"{source}: no OEM, it does not begin with CCSDS_OEM_VERS")
    if not found:
        raise InputError(f"{source}: an OEM without a segment; give one with states")
    return found


def _segments(text: str, source: str) -> Iterator[MessageSegment]:
    fields: dict[str, str] = {}
    rows: list[str] = []
    begin, in_metadata, in_covariance = 0, False, False
    for number, row in enumerate(text.splitlines(), 1):
        line = row.strip()
        if not line or line.startswith("COMMENT"):
            continue
        if line == "META_START":
            if begin:
                yield checked(MessageSegment(source, begin, fields, tuple(rows)))
            fields, rows, begin, in_metadata, in_covariance = {}, [], number, True, False
        elif line == "META_STOP":
            in_metadata = False
        elif line in ("COVARIANCE_START", "COVARIANCE_STOP"):
            in_covariance = line == "COVARIANCE_START"
        elif in_metadata:
            keyword, is_given, value = line.partition("=")
            keyword = keyword.strip()
            if not is_given or keyword in fields:
                fault = "is given twice" if is_given else "has no value"
                raise InputError(f"{source}: line {number}: {shown(keyword)} {fault}")
            fields[keyword] = value.strip()
        elif begin and not in_covariance:
            rows.append(line)
    if begin:
        yield checked(MessageSegment(source, begin, fields, tuple(rows)))


def checked(segment: MessageSegment) -> MessageSegment:
    """A segment, if it has the metadata and states that it needs."""
    missing = [keyword for keyword in NEEDED if not segment.fields.get(keyword)]
    if missing:
        raise InputError(f"{segment.source}: line {segment.line}: {missing[0]} is missing")
    if len(segment.rows) < 2:
        raise InputError(f"{segment.where}: fewer than two states")
    return segment
