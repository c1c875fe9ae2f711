"""User's tables of masses and sizes, which take precedence over catalogues.

CSV, a line for each object. The column ``object`` has its catalogue number, name or designator;
``mass`` is in kg, ``size`` the diameter of a sphere of its mean cross-section, in m. Either of the
two columns may be left out, and an empty cell leaves things as they are.
"""

from __future__ import annotations

import math
import os
from collections.abc import Sequence
from typing import NamedTuple

from ...common.errors import InputError
from ...common.files import read_text
from ...common.wording import counted
from ..catalogue.finding import Finder
from ..catalogue.records import ElementSet, shown
from ..csv_table import csv_number, csv_rows

COLUMNS = ("mass", "size")


class Measures(NamedTuple):
    """Mass [kg] and size [m] of an object; None where the table does not say."""

    mass: float | None = None
    size: float | None = None


class MeasuresTable(NamedTuple):
    """A table that was read.

    Attributes
    ----------
    known : dict of int to Measures
        By index of the record.
    strange : tuple of str
        Objects that are not among the records: a table may be of a larger or an older catalogue.
    """

    known: dict[int, Measures]
    strange: tuple[str, ...]


def read_measures(path: str | os.PathLike[str], records: Sequence[ElementSet]) -> MeasuresTable:
    """Read a table.

    Raises
    ------
    InputError
        It cannot be read, a column or a value is wrong, or none of its objects is among the
        records.
    """
    finder, found, strange = Finder(records), dict[int, Measures](), list[str]()
    for where, fields in csv_rows(read_text(path), path, _header, "object, mass, size"):
        measures = Measures(*(_number(fields.get(name), where, name) for name in COLUMNS))
        if fields["object"] and not finder.all(fields["object"]):
            strange.append(fields["object"])
            continue
        at = finder.one(fields["object"], f"{where}: object")
        if at in found:
            raise InputError(f"{where}: {records[at].label} already has a row; keep one")
        found[at] = measures
    if strange and not found:
        raise InputError(
            f"{path}: none of its {counted(len(strange), 'object')}, {shown(strange[0])!r} for "
            "one, is in the catalogue; give catalogue numbers, names or designators of it"
        )
    return MeasuresTable(found, tuple(strange))


def _header(cells: list[str], where: str) -> list[str]:
    header = [cell.casefold() for cell in cells]
    known = [sorted(("object", *some)) for some in (COLUMNS, COLUMNS[:1], COLUMNS[1:])]
    if sorted(header) not in known:
        raise InputError(f"{where}: give the columns object, {', '.join(COLUMNS)}")
    return header


def _number(text: str | None, where: str, name: str) -> float | None:
    if not text:
        return None
    value = csv_number(text, f"{where}: {name}")
    if not 0.0 < value < math.inf:
        raise InputError(f"{where}: {name} = {shown(text)}: must be positive")
    return value
