"""Worth of any set of some objects: worths alone, and what pairs share."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Iterable, Sequence
from dataclasses import dataclass

import numpy as np

from ...common.errors import InputError
from .air import FLOAT


@dataclass(frozen=True)
class SetWorths:
    """Worths of removing any set of some objects.

    Attributes
    ----------
    names : tuple of str
        Objects, as instances call targets.
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
        What tables call the objects.
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
        """SHA-256 of names, worths and unit, by which results are told apart."""
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
        """Equation 10: worths that add up, to at most what removing a set avoids."""
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
                    f"worth of {name!r} is not known; write it with 'worth --pairs' and more "
                    "--candidates"
                )
            found.append(places[name])
        if len(set(found)) < len(found):
            raise InputError("worth of a set: an object occurs twice; name each once")
        return found
