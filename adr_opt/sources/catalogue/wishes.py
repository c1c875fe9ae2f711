"""Tables of requirements on single objects: prizes, windows, masses and kinds of removal.

CSV, a line for each object. The column ``object`` has its catalogue number, name or designator
(``number`` or ``name`` will do as well); of the others, each as a field of a target, those that
are wanted: ``prize``, ``required`` (yes or no), ``window`` (days after the epoch as ``LO:HI``, one
of the two may be left out), ``mass`` [kg], ``removal``, ``prize_until`` (prizes that fall, as
``DAYS:PRIZE`` one after the other, ``prize`` being what is left). An empty cell leaves things as
they are.
"""

from __future__ import annotations

import math
import os
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from pydantic import ValidationError

from ...common.constants import DAY_S
from ...common.errors import InputError
from ...common.files import read_text
from ...common.sentences import sentence
from ...problem.bodies import Target
from ..csv_table import csv_number, csv_rows
from .filters import parse_range
from .records import shown

OBJECT = ("object", "number", "name")
COLUMNS = ("prize", "required", "window", "mass", "removal", "prize_until")

WORDS = {**dict.fromkeys(("yes", "true", "1"), True), **dict.fromkeys(("no", "false", "0"), False)}


@dataclass(frozen=True)
class Wish:
    """Requirements on one object.

    Attributes
    ----------
    said : str
        Its number, name or designator.
    source : str
        File and line, for sentences.
    fields : mapping
        Fields of the target that it becomes, as the instance has them.
    """

    said: str
    source: str
    fields: Mapping[str, Any]


def read_wishes(path: str | os.PathLike[str]) -> tuple[Wish, ...]:
    """Read a table of requirements.

    Raises
    ------
    InputError
        It cannot be read, or a column or a value is wrong; the sentence says file and line.
    """
    rows = csv_rows(read_text(path), path, _header, "object, prize, …")
    return tuple(_wish(cells, source) for source, cells in rows)


def _header(cells: list[str], source: str) -> list[str]:
    header = [cell.casefold() for cell in cells]
    for at, name in enumerate(header):
        if name not in (*OBJECT, *COLUMNS):
            raise InputError(
                f"{source}: column {shown(name)!r} is unknown; use object, {', '.join(COLUMNS)}"
            )
        if name in header[:at]:
            raise InputError(f"{source}: two columns {name}; keep one")
    if sum(name in OBJECT for name in header) != 1:
        raise InputError(f"{source}: exactly one column must name the objects; call it object")
    return header


def _wish(cells: dict[str, str], source: str) -> Wish:
    said = next(cells[name] for name in OBJECT if name in cells)
    if not said:
        raise InputError(f"{source}: no object is named; give its number or name")
    fields: dict[str, Any] = {}
    for column, field in (("prize", "prize"), ("mass", "mass_kg")):
        text = cells.get(column)
        if text:
            fields[field] = csv_number(text, f"{source}: {column}")
    if cells.get("required"):
        word = cells["required"].casefold()
        if word not in WORDS:
            raise InputError(f"{source}: required = {shown(word)!r}: must be yes or no")
        fields["required"] = WORDS[word]
    if cells.get("window"):
        opens, closes = parse_range(cells["window"], f"{source}: window")
        fields["window_s"] = (
            0.0 if math.isinf(opens) else DAY_S * opens,
            None if math.isinf(closes) else DAY_S * closes,
        )
    if cells.get("prize_until"):
        fields["prize_until"] = _levels(cells["prize_until"], f"{source}: prize_until")
    if cells.get("removal"):
        fields["removal"] = cells["removal"].casefold()
    try:
        Target(name="object", **fields)
    except ValidationError as error:
        raise InputError(f"{source}: {sentence(error)}") from None
    return Wish(said, source, fields)


def _levels(text: str, where: str) -> tuple[tuple[float, float], ...]:
    """Falling prizes, each with the time by which a service has to end [s]."""
    levels = []
    for part in text.split():
        days, colon, prize = part.partition(":")
        if not colon:
            raise InputError(f"{where} = {shown(part)!r}: must be days and a prize, as 365.25:98")
        levels.append((DAY_S * csv_number(days, where), csv_number(prize, where)))
    return tuple(levels)
