"""Best times of a mission whose targets and their order are given.

By dynamic programming backwards: the least mass on arrival at each target at each time. The rocket
equation makes less mass after a leg less mass before it, so that this is exact on a grid; where the
cost is ΔV, sums take the place of masses. First on the whole grid with costs to first order
(:mod:`adr_opt.kernels.legs.drift_linear`), then near the times found so, with the exact costs of
the connections of the instance (:mod:`adr_opt.kernels.legs.drift`).
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from adr_opt.common.constants import DAY_S
from adr_opt.kernels.core.compile import inlined, kernel
from adr_opt.kernels.legs import drift, drift_linear, drift_pair
from adr_opt.kernels.orbits.ephemeris import EPOCH_S
from adr_opt.legs.families.ends import AllEnds

FloatArray = npt.NDArray[np.float64]
Integers = npt.NDArray[np.int64]

NEAR_STEPS = 24
"""Half width of the band of times with exact costs [steps of the fine grid]."""

AROUND_S = 20.0 * DAY_S
"""Half width of the band of times with first-order costs [s]."""

ROUNDS = 4
"""Maximum number of bands, each around the times found in the previous one."""


class FineGrid(NamedTuple):
    """The grid of connections, in whole steps.

    Attributes
    ----------
    step : float
        [s].
    stay, within : int
        Stay at a target, and from one arrival to the next at most.
    shortest, longest : int
        Of a transfer.
    """

    step: float
    stay: int
    within: int
    shortest: int
    longest: int


class Growth(NamedTuple):
    """Backward recursion of mass, or sum, from the last target of a mission.

    Attributes
    ----------
    exhaust : float
        Exhaust speed [m/s] where mass grows by the rocket equation; 0 where ΔV is added up.
    kit : float
        What is left at each target [kg].
    begin : float
        On arrival at the last target: mass with its kit, or 0.
    """

    exhaust: float
    kit: float
    begin: float


@inlined
def _grown(growth, after, delta_v):
    """Mass, or sum, on arrival at the target before a leg."""
    if growth.exhaust > 0.0:
        return after * math.exp(delta_v / growth.exhaust) + growth.kit
    return after + delta_v


@kernel
def first_order(pair, bands, grid, growth, after, here, leaves, arrives):
    """Least masses on arrival at a target from those at the next one, with linear costs.

    Parameters
    ----------
    pair : LinearPair
    bands : (2,) int64
        First times on arrival at the target and at the next one.
    grid : FineGrid
    growth : Growth
    after : (times,) float64
        On arrival at the next target at each time of its band.
    here : (times,) float64
        Written; infinite where there is no way on.
    leaves, arrives : (times,) int64
        Written: departure of the leg, and its arrival, as places in the bands.
    """
    spans = min(grid.longest, grid.within - grid.stay)
    here[:] = np.inf
    for a in range(after.size):
        if after[a] == np.inf:
            continue
        # The longest leg and stay that begin in the band; a shorter one begins later in it.
        most = min(bands[1] + a - bands[0], grid.within)
        arrival = (bands[1] + a) * grid.step
        shape = drift_linear.shape_left(pair, arrival)
        best, of_span, found = np.inf, 0, np.inf
        for s in range(grid.shortest, most - grid.stay + 1):
            # The cheapest span up to each, since a chaser that is ready may wait.
            if s <= spans:
                span = s * grid.step
                node = drift_linear.node_left_from(pair, arrival - span, arrival)
                climb = drift_linear.climb_of(pair, span, node)
                cost = drift_linear.cost_of(pair, span, node, shape, climb)
                if cost < best:
                    best, of_span, found = cost, s, _grown(growth, after[a], cost)
            t = bands[1] + a - s - grid.stay - bands[0]
            if t < here.size and found < here[t]:
                here[t], leaves[t], arrives[t] = found, a - of_span, a


@kernel
def exact(pair, bands, grid, growth, after, here, leaves, arrives):
    """As :func:`first_order` with exact costs, where times lie in bands.

    Parameters
    ----------
    pair : DriftPair
    bands : (3,) int64
        First times on arrival at a target, of departure from it, and on arrival at the next one.
    grid : FineGrid
    growth : Growth
    after, here : (times,) float64
    leaves, arrives : (times,) int64
        Places in the bands.
    """
    size = after.size
    cost = np.full((size, size), np.inf)
    for d in range(size):
        for a in range(size):
            span = bands[2] + a - bands[1] - d
            if after[a] < np.inf and grid.shortest <= span <= grid.longest:
                times = (bands[1] + d) * grid.step, (bands[2] + a) * grid.step
                cost[d, a] = drift.delta_v(pair, times[0], times[1])
    here[:] = np.inf
    for a in range(size):
        best, of, d = np.inf, 0, size - 1
        # From the last arrival at this target back, more and more departures are early enough.
        for t in range(size - 1, -1, -1):
            while d >= 0 and bands[1] + d >= bands[0] + t + grid.stay:
                if cost[d, a] < best:
                    best, of = cost[d, a], d
                d -= 1
            if best == np.inf or bands[2] + a - bands[0] - t > grid.within:
                continue
            found = _grown(growth, after[a], best)
            if found < here[t]:
                here[t], leaves[t], arrives[t] = found, of, a


class MissionTimes(NamedTuple):
    """Times of a mission, in steps of the fine grid.

    Attributes
    ----------
    arrivals : (targets,) int64
    departures : (targets − 1,) int64
        Of the legs between them.
    total : float
        Mass at the launch [kg], or ΔV of all legs [m/s].
    """

    arrivals: Integers
    departures: Integers
    total: float


class Retiming:
    """Finds times of missions.

    Parameters
    ----------
    ends : AllEnds
    grid : FineGrid
    growth : Growth
    """

    def __init__(self, ends: AllEnds, grid: FineGrid, growth: Growth) -> None:
        self._ends, self.grid, self._growth = ends, grid, growth

    def _linear(self, i: int, j: int) -> drift_linear.LinearPair:
        rule = self._ends.rule
        limits = rule.min_radius, rule.max_radius, rule.oblateness, EPOCH_S
        ends = self._ends.leaving[i], self._ends.arriving[j]
        pair: drift_linear.LinearPair = drift_linear.prepare(*ends, *limits)
        return pair

    def delta_v(self, i: int, j: int, departure_s: float, arrival_s: float) -> float:
        """ΔV of the drift leg between two bodies and times [m/s]."""
        return float(drift.delta_v(self._exact(i, j), departure_s, arrival_s))

    def _exact(self, i: int, j: int) -> drift_pair.DriftPair:
        ends = self._ends.leaving[i], self._ends.arriving[j]
        pair: drift_pair.DriftPair = drift_pair.prepare(*ends, self._ends.rule, EPOCH_S)
        return pair

    def first_order(
        self, order: Sequence[int], near: Integers, first: int, last: int
    ) -> MissionTimes | None:
        """Best times by linear costs; None if there are none.

        Parameters
        ----------
        order : sequence of int
            Numbers of bodies.
        near : (targets,) int64
            About which arrivals they are looked for, within :data:`AROUND_S`.
        first, last : int
            First and last step at which the mission may arrive anywhere.
        """
        half = math.ceil(AROUND_S / self.grid.step)
        begins = near - half

        def take(k: int, *rows: npt.NDArray[Any]) -> None:
            pair, bands = self._linear(order[k], order[k + 1]), begins[k : k + 2]
            first_order(pair, bands, self.grid, self._growth, *rows)

        leaving = begins[1:]
        return self._backwards(take, begins, leaving, 2 * half + 1, (first, last))

    def exact(
        self, order: Sequence[int], near: MissionTimes, first: int, last: int
    ) -> MissionTimes | None:
        """Best times near given ones by exact costs; None if there are none."""
        found: MissionTimes | None = None
        for _ in range(ROUNDS):
            there = self._in_bands(order, near, first, last)
            if there is None or (found is not None and there.total >= found.total):
                break
            found = near = there
        return found

    def _in_bands(
        self, order: Sequence[int], near: MissionTimes, first: int, last: int
    ) -> MissionTimes | None:
        begins, leaving = near.arrivals - NEAR_STEPS, near.departures - NEAR_STEPS

        def take(k: int, *rows: npt.NDArray[Any]) -> None:
            bands = np.array([begins[k], leaving[k], begins[k + 1]])
            exact(self._exact(order[k], order[k + 1]), bands, self.grid, self._growth, *rows)

        return self._backwards(take, begins, leaving, 2 * NEAR_STEPS + 1, (first, last))

    def _backwards(
        self,
        take: Callable[..., None],
        begins: Integers,
        leaving: Integers,
        size: int,
        within: tuple[int, int],
    ) -> MissionTimes | None:
        """Best times in bands of arrivals, and of departures, by legs from the last one back."""

        def inside(k: int) -> npt.NDArray[np.bool_]:
            steps = begins[k] + np.arange(size)
            found: npt.NDArray[np.bool_] = (steps >= within[0]) & (steps <= within[1])
            return found

        after = np.where(inside(-1), self._growth.begin, np.inf)
        choices = []
        for k in range(begins.size - 2, -1, -1):
            here, leaves, arrives = np.empty(size), *np.zeros((2, size), np.int64)
            take(k, after, here, leaves, arrives)
            choices.append((leaves, arrives))
            after = np.where(inside(k), here, np.inf)
        now = int(np.argmin(after))
        if not np.isfinite(after[now]):
            return None
        total, arrivals, departures = float(after[now]), [now], []
        for leaves, arrives in choices[::-1]:
            departures.append(int(leaves[now]))
            now = int(arrives[now])
            arrivals.append(now)
        return MissionTimes(begins + arrivals, leaving + np.array(departures, np.int64), total)
