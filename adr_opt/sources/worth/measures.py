"""Tables of masses and sizes that a user knows better than any catalogue.

CSV, a line for each object. The column ``object`` has its catalogue number, name or designator;
``mass`` is in kg, ``size`` the diameter of a sphere of its mean cross-section, in m. Either of the
two columns may be left out, and an empty cell leaves things as they are.
"""

from __future__ import annotations

import csv
import math
import os
from collections.abc import Sequence
from typing import NamedTuple

from ...common.errors import InputError
from ...common.files import read_text
from ..catalogue.finding import Finder
from ..catalogue.records import ElementSet, shown

COLUMNS = ("mass", "size")


class Measures(NamedTuple):
    """Mass [kg] and size [m] of an object; None where the table does not say."""

    mass: float | None = None
    size: float | None = None


def read_measures(
    path: str | os.PathLike[str], records: Sequence[ElementSet]
) -> dict[int, Measures]:
    """Read a table; returns the measures of records by their index.

    Raises
    ------
    InputError
        It cannot be read, a column or a value is wrong, or an object is not among the records.
    """
    finder, found = Finder(records), dict[int, Measures]()
    rows = csv.reader(read_text(path).removeprefix("\ufeff").splitlines(), skipinitialspace=True)
    header: list[str] = []
    for row in rows:
        cells = [cell.strip() for cell in row]
        if not any(cells):
            continue
        where = f"{path}: line {rows.line_num}"
        if not header:
            header = [cell.casefold() for cell in cells]
            if sorted(header) not in (
                sorted(("object", *some)) for some in (COLUMNS, COLUMNS[:1], COLUMNS[1:])
            ):
                raise InputError(f"{where}: give the columns object, {', '.join(COLUMNS)}")
            continue
        if len(cells) != len(header):
            raise InputError(f"{where}: {len(cells)} values under {len(header)} columns")
        fields = dict(zip(header, cells, strict=True))
        at = finder.one(fields["object"], f"{where}: object")
        if at in found:
            raise InputError(f"{where}: {records[at].label} has a row already; keep one")
        found[at] = Measures(*(_number(fields.get(name), where, name) for name in COLUMNS))
    if not header:
        raise InputError(f"{path}: empty; give a line with the columns object, mass, size")
    return found


def _number(text: str | None, where: str, name: str) -> float | None:
    if not text:
        return None
    try:
        value = float(text)
    except ValueError:
        raise InputError(f"{where}: {name} = {shown(text)!r}: must be a number") from None
    if not 0.0 < value < math.inf:
        raise InputError(f"{where}: {name} = {shown(text)}: must be positive")
    return value
