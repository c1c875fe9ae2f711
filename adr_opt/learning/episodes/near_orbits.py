"""Distances between orbits: what lies near a body, without any timetable."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt
from scipy.spatial import KDTree

from ...kernels.core.lists import nearest
from ...kernels.episodes.choices import NEAREST
from ...kernels.orbits.ephemeris import planes_drift
from ...legs.nearest_pairs import PERIODS, places_of
from ...problem.instance import Instance

FloatArray = npt.NDArray[np.float64]
IntArray = npt.NDArray[np.int64]


class OrbitPlaces:
    """Orbits as points whose distances approximate ΔV, in one period of a mission.

    Neighbours of a body are looked up when first asked for.

    Parameters
    ----------
    points : (bodies, 7) float64
        [m/s].
    first_target : int
        Bodies with smaller numbers are near to none.

    Attributes
    ----------
    points : (bodies, 7) float64
        [m/s].
    """

    def __init__(self, points: FloatArray, first_target: int) -> None:
        self.points, self._first = np.ascontiguousarray(points), first_target
        bodies = len(points)
        count = max(0, min(NEAREST, bodies - first_target - 1))
        self._tree = KDTree(self.points[first_target:]) if count else None
        self._known = np.full(bodies, count == 0)
        self._near = np.zeros((bodies, count), dtype=np.int64)

    def nearest_of(
        self, body: int, among: npt.NDArray[np.bool_], first: npt.NDArray[np.bool_], count: int
    ) -> IntArray:
        """At most ``count`` bodies of ``among``, nearest first, those of ``first`` before all."""
        found = np.empty(count, dtype=np.int64)
        return found[: nearest(self.points, int(body), among, first, found)]

    def neighbours_of(self, bodies: IntArray) -> IntArray:
        """Nearest targets of some bodies, themselves left out, the nearest first."""
        unknown = bodies[~self._known[bodies]]
        if unknown.size and self._tree is not None:
            count = self._near.shape[1]
            near = self._tree.query(self.points[unknown], k=np.arange(1, count + 2))[1]
            near = near + self._first
            # Without itself, wherever it stands among bodies at equal places.
            order = np.argsort(near == unknown[:, None], axis=1, kind="stable")[:, :count]
            self._near[unknown] = np.take_along_axis(near, order, axis=1)
            self._known[unknown] = True
        return self._near[bodies]


class NearOrbits:
    """OrbitPlaces of the bodies of an instance, made for a period when first asked for.

    Bodies with given connections, or without an orbit, are near to none: their distances are 0.

    Parameters
    ----------
    instance : Instance
    periods : int, optional
        As many as planes need that drift or do not, if None.

    Attributes
    ----------
    period_s : float
        [s].
    """

    def __init__(self, instance: Instance, periods: int | None = None) -> None:
        self._instance = instance
        if periods is None:
            periods = PERIODS if planes_drift(instance.oblateness_m2) else 1
        self.period_s = max(instance.mission.duration_s, 1.0) / periods
        self._made: list[OrbitPlaces | None] = [None] * periods

    def at(self, time_s: float) -> OrbitPlaces:
        """The places in the period of a time."""
        period = min(max(int(time_s / self.period_s), 0), len(self._made) - 1)
        made = self._made[period]
        if made is None:
            made = self._made[period] = self._of((period + 0.5) * self.period_s)
        return made

    def _of(self, time_s: float) -> OrbitPlaces:
        instance = self._instance
        points = np.zeros((len(instance.names), 7))
        if instance.given is None:
            points = np.nan_to_num(places_of(instance, time_s))
        return OrbitPlaces(points, instance.first_target)
