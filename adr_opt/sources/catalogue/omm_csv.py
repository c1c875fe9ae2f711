"""OMM as CSV: a header line of keywords, then a line per object."""

from __future__ import annotations

import csv
from collections.abc import Iterable, Iterator

from ...common.errors import InputError
from . import omm
from .records import Dropped, ElementSet, RowError

LONGEST_LINE = 20_000


def read_csv(lines: Iterable[str], source: str) -> Iterator[ElementSet | Dropped]:
    """The records of a CSV file, in their order.

    Each line is parsed for itself, so that an unbalanced quote spoils one row and not the rest.

    Raises
    ------
    InputError
        The first line lacks a column that every OMM needs.
    """
    header: list[str] = []
    for number, line in enumerate(lines, 1):
        if not line.strip():
            continue
        try:
            if len(line) > LONGEST_LINE:
                raise RowError(f"the line is longer than {LONGEST_LINE} characters")
            values = _split(line)
        except RowError as error:
            if not header:
                raise InputError(f"{source}: line {number}: {error.detail}") from None
            yield Dropped(source, number, "", error.reason, error.detail)
            continue
        if not header:
            header = [omm.keyword(value) for value in values]
            _check_header(header, source, number)
            continue
        fault = None
        if len(values) != len(header):
            reason = "truncated" if len(values) < len(header) else "malformed"
            fault = RowError(f"{len(values)} values under {len(header)} columns", reason)
        fields = dict(zip(header, values, strict=False))
        yield omm.read_message(fields, source, number, fault=fault)


def _check_header(header: list[str], source: str, number: int) -> None:
    for key in ("EPOCH", "MEAN_MOTION", "ECCENTRICITY", "INCLINATION"):
        if key not in header:
            raise InputError(
                f"{source}: line {number}: no column {key}; give the columns of OMM, with commas"
            )
    for place, key in enumerate(header):
        if key in omm.FIELDS and key in header[:place]:
            raise InputError(f"{source}: line {number}: two columns {key}; keep one")


def _split(line: str) -> list[str]:
    try:
        return next(csv.reader([line.rstrip("\r\n")], strict=True))
    except (csv.Error, StopIteration) as error:
        raise RowError(f"not a line of CSV ({error or 'empty'})") from None
