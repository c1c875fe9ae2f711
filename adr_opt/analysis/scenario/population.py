"""Objects in orbit at the beginning of a year: orbits under drag and J2 (docs/scenarios.md)."""

from __future__ import annotations

import math
from collections import Counter
from dataclasses import dataclass, replace
from datetime import datetime
from typing import Any

import numpy as np

from ...common.constants import EARTH_RADIUS_M, OBLATENESS_M2
from ...common.errors import InputError
from ...kernels.orbits.decay import after_drag
from ...kernels.orbits.encounters import LEAST_WIDTH_M
from ...kernels.orbits.ephemeris import secular_rates
from ...problem.air import ALTITUDES_KM, DRAG_COEFFICIENT, FLOAT, YEAR_S, table
from ...sources.catalogue.propagation import mean_elements, true_anomaly
from ...sources.worth.bodies import Bodies
from ...sources.worth.pairs import INDICES
from .settings import KINDS, AltitudeShells

MASK = np.ndarray[tuple[int], np.dtype[np.bool_]]

PERIGEE, APOGEE, TILT, NODE, ARGUMENT, ANOMALY = range(6)
"""Columns of orbits."""

TUPLES = ("records", "kinds", "mass_sources", "size_sources", "area_sources")
ARRAYS = ("shells", "tilts", "masses", "sizes", "areas")
"""Columns of :class:`.Bodies`."""


@dataclass(frozen=True)
class ObjectPopulation:
    """Objects as arrays.

    Attributes
    ----------
    numbers : (object,) int64
        Numbers for life, in ascending order; no number is given twice.
    orbits : (object, 6) float64
        Radii of perigee and apogee [m], inclination, RAAN, argument of perigee, mean anomaly [rad].
    bodies : Bodies
        The same objects, with their shells.
    """

    numbers: INDICES
    orbits: FLOAT
    bodies: Bodies

    def __len__(self) -> int:
        return len(self.numbers)

    @property
    def altitudes_m(self) -> FLOAT:
        """Mean altitudes, shape (object,)."""
        means: FLOAT = self.orbits[:, :2].mean(axis=1) - EARTH_RADIUS_M
        return means

    @property
    def kinds(self) -> INDICES:
        """Place of each object's kind in :data:`.settings.KINDS`."""
        return np.array([KINDS.index(kind) for kind in self.bodies.kinds], dtype=np.int64)

    def kept(self, mask: MASK) -> ObjectPopulation:
        """The objects for which a mask is true."""
        return ObjectPopulation(self.numbers[mask], self.orbits[mask], part_of(self.bodies, mask))

    def without(self, gone: set[int]) -> ObjectPopulation:
        """The population without the objects of given numbers."""
        return self.kept(~np.isin(self.numbers, sorted(gone))) if gone else self

    def joined(self, other: ObjectPopulation) -> ObjectPopulation:
        """These objects and those of another population, whose numbers are larger."""
        if not len(other):
            return self
        one, two = self.bodies, other.bodies
        columns: dict[str, Any] = {name: getattr(one, name) + getattr(two, name) for name in TUPLES}
        for name in ARRAYS:
            columns[name] = np.concatenate((getattr(one, name), getattr(two, name)))
        bodies = replace(one, **columns)
        return ObjectPopulation(
            np.concatenate((self.numbers, other.numbers)),
            np.concatenate((self.orbits, other.orbits)),
            bodies,
        )

    def by_shell(self, shells: AltitudeShells) -> INDICES:
        """Numbers of objects, shape (kind, shells + 2), from those below to those above."""
        found = np.zeros((len(KINDS), shells.count + 2), dtype=np.int64)
        np.add.at(found, (self.kinds, shells.numbers(self.altitudes_m)), 1)
        return found

    def a_year_later(self, activity: str, *, drag: bool) -> tuple[ObjectPopulation, INDICES]:
        """The population after a year of drag and J2, and numbers of the re-entered objects."""
        orbits = self.orbits.copy()
        ends = np.ascontiguousarray(orbits[:, :2])
        if drag:
            after_drag(ends, DRAG_COEFFICIENT * self.bodies.areas, *table(activity), YEAR_S)
        # The nodes and perigees of the mean of both orbits.
        middle = 0.5 * (ends + orbits[:, :2])
        for at, (perigee, apogee) in enumerate(middle):
            axis, eccentricity = 0.5 * (perigee + apogee), (apogee - perigee) / (apogee + perigee)
            rates = secular_rates(axis, eccentricity, orbits[at, TILT], OBLATENESS_M2)
            orbits[at, NODE:] += YEAR_S * np.array(rates)
        orbits[:, NODE:] %= 2.0 * math.pi
        orbits[:, :2] = ends
        stays = ends[:, 0] > EARTH_RADIUS_M + 1e3 * ALTITUDES_KM[0]
        bodies = replace(self.bodies, shells=padded(ends))
        made = ObjectPopulation(self.numbers, orbits, bodies)
        return made.kept(stays), self.numbers[~stays]


def padded(ends: FLOAT) -> FLOAT:
    """Shells of perigee and apogee radii, at least :data:`.LEAST_WIDTH_M` wide [m]."""
    more = np.maximum(0.5 * (LEAST_WIDTH_M - (ends[:, 1] - ends[:, 0])), 0.0)
    shells: FLOAT = np.column_stack((ends[:, 0] - more, ends[:, 1] + more))
    return shells


def part_of(bodies: Bodies, mask: MASK) -> Bodies:
    """The bodies for which a mask is true."""
    places = np.flatnonzero(mask)
    columns: dict[str, Any] = {name: getattr(bodies, name)[mask] for name in ARRAYS}
    for name in TUPLES:
        columns[name] = tuple(getattr(bodies, name)[at] for at in places)
    return replace(bodies, **columns)


def population_of(bodies: Bodies, epoch: datetime) -> tuple[ObjectPopulation, dict[str, int]]:
    """Objects of a catalogue at an epoch, by SGP4, and the number left out for each reason.

    Raises
    ------
    InputError
        Fewer than two objects are in orbit then.
    MissingExtra
        sgp4 is not installed.
    """
    elements, failed = mean_elements(bodies.records, epoch)
    axis, eccentricity = elements[:, 0], elements[:, 1]
    ends = np.column_stack((axis * (1.0 - eccentricity), axis * (1.0 + eccentricity)))
    there = np.isfinite(axis) & (ends[:, 0] > EARTH_RADIUS_M + 1e3 * ALTITUDES_KM[0])
    left_out = Counter({name: count for name, count in bodies.left_out.items()})
    left_out.update(drop.reason for drop in failed)
    left_out["decayed"] += int(np.isfinite(axis).sum() - there.sum())
    if there.sum() < 2:
        raise InputError(
            f"{int(there.sum())} objects in orbit at the epoch: a collision needs two; give a "
            "larger catalogue"
        )
    orbits = np.column_stack((ends, elements[:, 2:6]))
    orbits[:, NODE:] %= 2.0 * math.pi
    moved = replace(bodies, shells=padded(ends), tilts=elements[:, 2].copy())
    made = ObjectPopulation(np.arange(len(bodies)), orbits, moved).kept(there)
    return made, {reason: count for reason, count in left_out.items() if count}


def true_anomalies(orbits: FLOAT) -> FLOAT:
    """True anomalies of orbits [rad]."""
    eccentricity = (orbits[:, APOGEE] - orbits[:, PERIGEE]) / (
        orbits[:, APOGEE] + orbits[:, PERIGEE]
    )
    return true_anomaly(orbits[:, ANOMALY], eccentricity)
