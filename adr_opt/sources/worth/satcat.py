"""Masses and sizes from Jonathan McDowell's General Catalog of Artificial Space Objects.

Its file ``satcat.tsv`` (https://planet4589.org/space/gcat, CC BY 4.0): columns between tabs under a
line that begins with ``#JCAT``, numbers padded, ``-`` for what is unknown, and behind each quantity
a column with a flag, ``?`` where it is uncertain.
"""

from __future__ import annotations

import math
import os
from dataclasses import dataclass
from typing import NamedTuple

from ...common.errors import InputError
from ...common.files import read_text
from ..catalogue.records import shown
from ..csv_table import csv_number

_COLUMNS = """
Satcat Piece Type Mass MassFlag DryMass DryFlag Length LFlag Diameter DFlag
"""
COLUMNS = tuple(_COLUMNS.split())

UNKNOWN = ("", "-")

KINDS = {"P": "payload", "R": "rocket body", "C": "debris", "D": "debris"}
"""First letter of a type → kind of object; components count as debris."""


class Quantity(NamedTuple):
    """A number of the catalogue, with whether it is marked as uncertain."""

    value: float
    uncertain: bool


@dataclass(frozen=True, slots=True)
class SatcatRow:
    """An object of the General Catalog.

    Attributes
    ----------
    kind : str
        ``payload``, ``rocket body`` or ``debris``.
    mass : Quantity or None
        [kg]; without propellant for rocket bodies; None if unknown.
    length, diameter : Quantity or None
        [m].
    """

    kind: str
    mass: Quantity | None
    length: Quantity | None
    diameter: Quantity | None


@dataclass(frozen=True)
class Satcat:
    """Content of the file.

    Attributes
    ----------
    by_number : dict of int to SatcatRow
        By the number of the US catalogue.
    by_piece : dict of str to SatcatRow
        By international designator.
    updated : str
        Date of the file as it says it; empty if it does not.
    """

    by_number: dict[int, SatcatRow]
    by_piece: dict[str, SatcatRow]
    updated: str = ""

    def __len__(self) -> int:
        return len(self.by_piece)


def read_satcat(path: str | os.PathLike[str]) -> Satcat:
    """Read ``satcat.tsv``.

    Raises
    ------
    InputError
        It cannot be read, lacks a column, or has a number that cannot be one; the sentence says
        file and line.
    """
    by_number: dict[int, SatcatRow] = {}
    by_piece: dict[str, SatcatRow] = {}
    places: dict[str, int] = {}
    updated = ""
    for line_number, line in enumerate(read_text(path).splitlines(), 1):
        where = f"{path}: line {line_number}"
        if line.startswith("#JCAT"):
            places = _places(line, where)
        elif line.startswith("#"):
            updated = line.lstrip("# ").removeprefix("Updated").strip()[:11] or updated
        elif line.strip():
            if not places:
                raise InputError(
                    f"{where}: no line of columns before it; give satcat.tsv of the General Catalog"
                )
            cells = [cell.strip() for cell in line.split("\t")]
            if len(cells) <= max(places.values()):
                raise InputError(f"{where}: {len(cells)} columns of {max(places.values()) + 1}")
            fields = {name: cells[place] for name, place in places.items()}
            row = _row(fields, where)
            if row is None:
                continue
            if fields["Satcat"].isdigit():
                # Parts attached to an object repeat its number; the catalogue's own row is first.
                by_number.setdefault(int(fields["Satcat"]), row)
            by_piece.setdefault(_piece(fields["Piece"]), row)
    if not by_piece:
        raise InputError(f"{path}: no object in it; give satcat.tsv of the General Catalog")
    return Satcat(by_number, by_piece, updated)


def _places(line: str, where: str) -> dict[str, int]:
    names = [name.strip() for name in line.lstrip("#").split("\t")]
    for name in COLUMNS:
        if name not in names:
            raise InputError(f"{where}: no column {name}; give satcat.tsv of the General Catalog")
    return {name: names.index(name) for name in COLUMNS}


def _row(fields: dict[str, str], where: str) -> SatcatRow | None:
    """The object of a row; None if the row is not an object in orbit."""
    kind = KINDS.get(fields["Type"][:1])
    if kind is None:
        return None
    dry = kind == "rocket body"
    return SatcatRow(
        kind,
        _quantity(fields, *(("DryMass", "DryFlag") if dry else ("Mass", "MassFlag")), where),
        _quantity(fields, "Length", "LFlag", where),
        _quantity(fields, "Diameter", "DFlag", where),
    )


def _quantity(fields: dict[str, str], name: str, flag: str, where: str) -> Quantity | None:
    text = fields[name]
    if text in UNKNOWN or fields[flag] == "-":
        return None
    value = csv_number(text, f"{where}: {name}")
    if not 0.0 <= value < math.inf:
        raise InputError(f"{where}: {name} = {shown(text)}: must not be negative")
    return None if value == 0.0 else Quantity(value, fields[flag] == "?")


def _piece(text: str) -> str:
    return " ".join(text.upper().split())
