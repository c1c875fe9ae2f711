"""Worth of removing objects: expected fragment-years avoided (docs/worth.md, equations 8 to 10)."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from ...common.constants import EARTH_RADIUS_M
from ...common.errors import InputError
from ...kernels.orbits.collisions import CollidingObjects, CollisionTables
from ...problem.air import ACTIVITIES, FLOAT, LOWEST_M, YEAR_S, lifetimes
from .bodies import Bodies
from .breakup import ALTITUDE_STEP_M, CATASTROPHIC_J_KG, FRAGMENTS, KINDS, fragment_years
from .pairs import INDICES, Show, mean_speeds, shared, totals, with_one

MOST_YEARS = 200.0
"""Longest horizon: beyond it, population and solar activity cannot be assumed constant [years]."""

UNIT = "fragment-years"

CELL_KM, CELL_DEG = 100.0, 10.0
"""Sizes of the cells in which worth is summed: mean altitude, from 0, and inclination."""

LEVELS, TILTS = 21, 18
"""Numbers of cells; the highest holds everything above 2,000 km."""


@dataclass(frozen=True)
class RemovalWorth:
    """Worth of removing each object of a catalogue.

    Attributes
    ----------
    bodies : Bodies
    years : float
        Horizon.
    activity : str
        Solar activity.
    alone : (object,) float64
        Expected fragment-years avoided by removing this object alone.
    encounters, catastrophic : (object,) float64
        Encounters with all others, and catastrophic ones [1/year].
    partners : (object,) int64
        Object of the worst pair; −1 for none.
    partner_worths : (object,) float64
        Fragment-years of that pair.
    lives : (object,) float64
        Time that the object stays, at most the horizon [years].
    cells : (cell, cell) float64
        Fragment-years of pairs of objects of two cells; see :func:`cell_of`.
    """

    bodies: Bodies
    years: float
    activity: str
    alone: FLOAT
    encounters: FLOAT
    catastrophic: FLOAT
    partners: INDICES
    partner_worths: FLOAT
    lives: FLOAT
    cells: FLOAT
    _objects: CollidingObjects
    _tables: CollisionTables
    _order: INDICES

    @property
    def total(self) -> float:
        """Expected fragment-years of all pairs; each pair counts once."""
        return 0.5 * float(self.alone.sum())

    def best(self, count: int) -> INDICES:
        """The objects of the largest worth alone, in descending order."""
        return np.argsort(-self.alone, kind="stable")[:count]

    def floors(self, candidates: INDICES, jobs: int = 0) -> FLOAT:
        """Equation 10: additive worths, in the order of the candidates.

        The sum over any set of candidates is at most what removing the set avoids.
        """
        places = self._places(candidates)
        order = np.argsort(places)
        halves = np.empty(len(places))
        halves[order] = 0.5 * shared(self._objects, self._tables, places[order], jobs)
        floors: FLOAT = self.alone[candidates] - halves
        return floors

    def of_set(self, chosen: Sequence[int] | INDICES) -> float:
        """Equation 9: fragment-years avoided by removing a set; pairs within it count once."""
        indices = np.asarray(chosen, dtype=np.int64)
        if len(np.unique(indices)) != len(indices):
            raise InputError("worth of a set: an object occurs twice; name each once")
        twice = shared(self._objects, self._tables, np.sort(self._places(indices)), 1)
        return float(self.alone[indices].sum() - 0.5 * twice.sum())

    def shared_pairs(self, candidates: INDICES) -> FLOAT:
        """Worth shared by each pair of candidates; symmetric, zero diagonal [fragment-years]."""
        places = self._places(candidates)
        return np.array([with_one(self._objects, self._tables, int(one), places) for one in places])

    def best_set(self, count: int, candidates: INDICES) -> list[int]:
        """A set of candidates of large worth, by greedy addition."""
        left = self.alone[candidates].copy()
        places = self._places(candidates)
        chosen: list[int] = []
        for _ in range(min(count, len(candidates))):
            at = int(np.argmax(left))
            chosen.append(int(candidates[at]))
            left -= with_one(self._objects, self._tables, int(places[at]), places)
            left[at] = -math.inf
        return chosen

    def _places(self, indices: INDICES) -> INDICES:
        """Places of objects in the order of perigees."""
        ranks = np.empty(len(self._order), dtype=np.int64)
        ranks[self._order] = np.arange(len(self._order))
        places: INDICES = ranks[indices]
        return places


def cell_of(altitude_km: float, inclination_deg: float) -> int:
    """Cell of a mean altitude and an inclination."""
    level = min(max(int(altitude_km / CELL_KM), 0), LEVELS - 1)
    return level * TILTS + min(int(inclination_deg / CELL_DEG), TILTS - 1)


def worth_of(
    bodies: Bodies,
    years: float,
    activity: str = "mean",
    jobs: int = 0,
    show: Show = lambda done, of: None,
    *,
    since_years: float = 0.0,
) -> RemovalWorth:
    """Worth of removing each of some objects.

    Parameters
    ----------
    bodies : Bodies
    years : float
        Horizon, at most :data:`MOST_YEARS`.
    activity : str
        Solar activity, one of :data:`.air.ACTIVITIES`.
    jobs : int
        Number of threads; 0 for all cores.
    show : callable
        Progress.
    since_years : float
        Time of the removal: collisions before it are not avoided.

    Raises
    ------
    InputError
        The horizon is out of range, or there are fewer than two objects.
    """
    check_years(years)
    if activity not in ACTIVITIES:
        raise InputError(f"activity {activity!r} is unknown; use {', '.join(ACTIVITIES)}")
    if len(bodies) < 2:
        raise InputError(
            f"{len(bodies)} objects in orbit: a collision needs two; give a larger catalogue"
        )
    order = np.argsort(bodies.shells[:, 0], kind="stable")
    lives = np.minimum(lifetimes(bodies.shells, bodies.areas, activity, years), years)
    altitudes_km = (bodies.shells.mean(axis=1) - EARTH_RADIUS_M) / 1e3
    cells = np.array(
        [cell_of(*pair) for pair in zip(altitudes_km, np.degrees(bodies.tilts), strict=True)]
    )
    fragments = np.array([0 if kind == "rocket body" else 1 for kind in bodies.kinds])
    assert tuple(KINDS) == ("rocket body", "spacecraft")
    objects = CollidingObjects(
        *(
            np.ascontiguousarray(column[order])
            for column in (
                bodies.shells,
                bodies.tilts,
                0.5 * bodies.sizes,
                bodies.masses,
                lives,
                fragments,
                cells,
            )
        )
    )
    table, exposure = fragment_years(years, activity, since_years)
    tables = CollisionTables(
        mean_speeds(),
        table,
        EARTH_RADIUS_M + LOWEST_M,
        ALTITUDE_STEP_M,
        exposure,
        FRAGMENTS,
        CATASTROPHIC_J_KG,
        YEAR_S,
    )
    found = totals(objects, tables, LEVELS * TILTS, jobs, show)
    sums, partners = np.empty_like(found.sums), np.empty_like(found.partners)
    sums[order] = found.sums
    partners[order] = np.where(found.partners < 0, -1, order[found.partners])
    return RemovalWorth(
        bodies=bodies,
        years=years,
        activity=activity,
        alone=sums[:, 0],
        encounters=sums[:, 1],
        catastrophic=sums[:, 2],
        partners=partners,
        partner_worths=sums[:, 3],
        lives=lives,
        cells=found.cells,
        _objects=objects,
        _tables=tables,
        _order=order,
    )


def check_years(years: float) -> None:
    """Raise :class:`InputError` if a horizon is out of range."""
    if not 0.0 < years <= MOST_YEARS:
        raise InputError(f"--years {years:g}: must be more than 0 and at most {MOST_YEARS:g}")
