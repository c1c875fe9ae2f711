"""Distances between orbits: what lies near a body, without any timetable."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt
from scipy.spatial import KDTree

from ...kernels.orbits.ephemeris import planes_drift
from ...legs.nearest_pairs import PERIODS, places_of
from ...problem.instance import Instance

FloatArray = npt.NDArray[np.float64]
IntArray = npt.NDArray[np.int64]

NEIGHBOURS = 16
"""Number of nearest targets of each body that its density counts."""


@dataclass(frozen=True)
class OrbitPlaces:
    """Orbits as points whose distances approximate ΔV, in one period of a mission.

    Attributes
    ----------
    points : (bodies, 7) float64
        [m/s].
    near : (bodies, neighbours) int64
        Nearest targets of each body, itself left out.
    apart : (bodies, neighbours) float64
        Their distances [m/s].
    """

    points: FloatArray
    near: IntArray
    apart: FloatArray

    def distances(self, body: int, others: IntArray) -> FloatArray:
        """Distances of a body from some others [m/s]."""
        away = self.points[others] - self.points[body]
        found: FloatArray = np.sqrt(np.einsum("ij,ij->i", away, away))
        return found


class NearOrbits:
    """OrbitPlaces of the bodies of an instance, made for a period when first asked for.

    Bodies with given connections, or without an orbit, are near to none: their distances are 0.

    Parameters
    ----------
    instance : Instance
    """

    def __init__(self, instance: Instance) -> None:
        self._instance = instance
        periods = PERIODS if planes_drift(instance.oblateness_m2) else 1
        self._length_s = max(instance.mission.duration_s, 1.0) / periods
        self._made: list[OrbitPlaces | None] = [None] * periods

    def at(self, time_s: float) -> OrbitPlaces:
        """The places in the period of a time."""
        period = min(max(int(time_s / self._length_s), 0), len(self._made) - 1)
        made = self._made[period]
        if made is None:
            made = self._made[period] = self._of((period + 0.5) * self._length_s)
        return made

    def _of(self, time_s: float) -> OrbitPlaces:
        instance, first = self._instance, self._instance.first_target
        bodies = len(instance.names)
        points = np.zeros((bodies, 7))
        if instance.given is None:
            points = np.nan_to_num(places_of(instance, time_s))
        count = min(NEIGHBOURS, bodies - first - 1)
        if count < 1:
            nothing = np.empty((bodies, 0))
            return OrbitPlaces(points, nothing.astype(np.int64), nothing)
        apart, near = KDTree(points[first:]).query(points, k=np.arange(1, count + 2))
        near = near + first
        # Without itself, wherever it stands among bodies at equal places.
        itself = near == np.arange(bodies)[:, None]
        order = np.argsort(itself, axis=1, kind="stable")[:, :count]
        return OrbitPlaces(
            points,
            np.take_along_axis(near, order, axis=1),
            np.take_along_axis(apart, order, axis=1),
        )
