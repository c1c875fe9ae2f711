"""The file ``adr-opt-worth/1``: worths alone of objects, and worths shared by their pairs."""

from __future__ import annotations

import hashlib
import json
import math
import os
from collections import Counter
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import Annotated, Literal, Self

import numpy as np
from pydantic import Field, model_validator

from ...common.errors import InputError
from ...common.files import read_model
from ...common.records import Name, NonNegative, Positive, Record
from ...problem.air import FLOAT
from .prizes import RemovalPrizes, reference
from .worth import UNIT


@dataclass(frozen=True)
class SetWorths:
    """Worths of removing any set of some objects.

    Attributes
    ----------
    names : tuple of str
        Objects, by their names as targets.
    alone : (object,) float64
        Worth of removing each alone [fragment-years].
    pairs : (object, object) float64
        What two objects share; symmetric, zero on the diagonal [fragment-years].
    prize_unit : float
        What prizes are whole multiples of [fragment-years].
    total : float
        Worth of all pairs of the catalogue [fragment-years].
    years : float
        Horizon.
    references : tuple of str
        Their names in tables.
    """

    names: tuple[str, ...]
    alone: FLOAT
    pairs: FLOAT
    prize_unit: float
    total: float
    years: float
    references: tuple[str, ...] = ()

    @property
    def digest(self) -> str:
        """SHA-256 of names, worths and unit, which identifies results."""
        text = json.dumps([self.names, self.alone.tolist(), self.pairs.tolist(), self.prize_unit])
        return hashlib.sha256(text.encode()).hexdigest()

    def of_set(self, chosen: Iterable[str]) -> float:
        """Equation 9: fragment-years avoided by removing a set; pairs within it count once.

        Raises
        ------
        InputError
            An object is not known, or named twice.
        """
        at = self._places(chosen)
        return float(self.alone[at].sum() - 0.5 * self.pairs[np.ix_(at, at)].sum())

    @property
    def floors(self) -> FLOAT:
        """Equation 10: additive worths, whose sum is at most what removing a set avoids."""
        floors: FLOAT = self.alone - 0.5 * self.pairs.sum(axis=1)
        return np.maximum(floors, 0.0)

    def among(self, names: Sequence[str]) -> SetWorths:
        """The same worths for some of the objects, in the order given.

        Floors among fewer candidates are closer to worths alone.

        Raises
        ------
        InputError
            An object is not known, or named twice.
        """
        at = self._places(names)
        return SetWorths(
            tuple(names),
            self.alone[at],
            self.pairs[np.ix_(at, at)],
            self.prize_unit,
            self.total,
            self.years,
            tuple(self.references[place] for place in at) if self.references else (),
        )

    def _places(self, names: Iterable[str]) -> list[int]:
        places = {name: at for at, name in enumerate(self.names)}
        found: list[int] = []
        for name in names:
            if name not in places:
                raise InputError(
                    f"worth of {name!r} is unknown; write it with 'worth --pairs' and more "
                    "--candidates"
                )
            found.append(places[name])
        if len(set(found)) < len(found):
            raise InputError("worth of a set: an object occurs twice; name each once")
        return found


FORMAT: Literal["adr-opt-worth/1"] = "adr-opt-worth/1"

MOST_OBJECTS = 1000
"""Maximum number of objects in a file, whose size grows with its square."""

DIGITS = 10
"""Significant digits of worths in a file."""

ROUNDED = 1e-6
"""Relative excess of an object's shared worth over its worth alone that rounding may cause."""


class RatedObject(Record):
    """An object and its worth alone [fragment-years]; ``object`` is its name in tables."""

    object: Name
    name: Name
    alone: NonNegative


class WorthFile(Record):
    """The fields of the file ``adr-opt-worth/1``.

    ``total`` is the worth of all pairs of the catalogue, and ``prize_unit`` what prizes are whole
    multiples of, both in fragment-years. Row *i* of ``pairs`` has what object *i* shares with each
    object after it.
    """

    format: Literal["adr-opt-worth/1"] = FORMAT
    unit: Literal["fragment-years"] = "fragment-years"
    years: Positive
    activity: Name
    total: NonNegative
    prize_unit: Positive
    objects: Annotated[tuple[RatedObject, ...], Field(strict=False, max_length=MOST_OBJECTS)]
    pairs: Annotated[
        tuple[Annotated[tuple[NonNegative, ...], Field(strict=False)], ...], Field(strict=False)
    ]

    @model_validator(mode="after")
    def _agree(self) -> Self:
        count = len(self.objects)
        if [len(row) for row in self.pairs] != list(range(count - 1, -1, -1)):
            raise ValueError(
                f"field pairs: must have a row for each of {count} objects, with one number for "
                "each object after it"
            )
        names = Counter(each.name for each in self.objects)
        twice = [name for name, number in names.items() if number > 1]
        if twice:
            raise ValueError(f"field objects: {twice[0]!r} occurs twice; keep one")
        shared = _symmetric(self.pairs).sum(axis=1)
        for each, sum_of_pairs in zip(self.objects, shared, strict=True):
            if sum_of_pairs > each.alone * (1.0 + ROUNDED):
                raise ValueError(
                    f"field objects: {each.name!r} shares {sum_of_pairs:g} with the others, more "
                    f"than its worth alone, {each.alone:g}"
                )
        return self


def pairs_json(prizes: RemovalPrizes) -> str:
    """The file ``adr-opt-worth/1`` of the candidates of some prizes.

    Raises
    ------
    InputError
        There are too many candidates.
    """
    candidates, worth = prizes.candidates, prizes.worth
    check_count(len(candidates))
    records = [worth.bodies.records[at] for at in candidates]
    matrix = worth.shared_pairs(candidates)
    content = {
        "format": FORMAT,
        "unit": UNIT,
        "years": worth.years,
        "activity": worth.activity,
        "total": _rounded(worth.total),
        "prize_unit": prizes.unit,
        "objects": [
            {"object": reference(record), "name": record.label, "alone": _rounded(alone)}
            for record, alone in zip(records, worth.alone[candidates], strict=True)
        ],
        "pairs": [[_rounded(shared) for shared in row[at + 1 :]] for at, row in enumerate(matrix)],
    }
    WorthFile.from_json(json.dumps(content))  # what could not be read again is not written
    parts = [f" {json.dumps(key)}: {_lines(value)}" for key, value in content.items()]
    return "{\n" + ",\n".join(parts) + "\n}\n"


def check_count(candidates: int) -> None:
    """Raise :class:`InputError` if a file of pairs would have too many objects."""
    if candidates > MOST_OBJECTS:
        raise InputError(
            f"--pairs: {candidates} candidates, but the file has at most {MOST_OBJECTS}; lower "
            "--candidates"
        )


def load_set_worths(path: str | os.PathLike[str]) -> SetWorths:
    """Read a file ``adr-opt-worth/1``, as ``worth --pairs`` writes it.

    Raises
    ------
    InputError
        It cannot be read, or breaks the format.
    """
    file = read_model(path, WorthFile)
    return SetWorths(
        names=tuple(each.name for each in file.objects),
        alone=np.array([each.alone for each in file.objects], dtype=np.float64),
        pairs=_symmetric(file.pairs),
        prize_unit=file.prize_unit,
        total=file.total,
        years=file.years,
        references=tuple(each.object for each in file.objects),
    )


def _symmetric(rows: Sequence[Sequence[float]]) -> FLOAT:
    matrix = np.zeros((len(rows), len(rows)))
    for at, row in enumerate(rows):
        matrix[at, at + 1 :] = row
    return matrix + matrix.T


def _rounded(value: float) -> float:
    """A worth rounded to :data:`DIGITS` significant digits."""
    if value == 0.0:
        return 0.0
    return round(float(value), DIGITS - 1 - math.floor(math.log10(abs(value))))


def _lines(value: object) -> str:
    """JSON with a line for each item of a list."""
    if not isinstance(value, list) or not value:
        return json.dumps(value, ensure_ascii=False)
    return (
        "[\n" + ",\n".join("  " + json.dumps(each, ensure_ascii=False) for each in value) + "\n ]"
    )
