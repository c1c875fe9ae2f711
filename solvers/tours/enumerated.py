"""Small campaigns enumerated: the least cost of all orders, missions and times on a grid.

Missions are built from their last target back, by sets of targets: for each set, first target, and
first and last arrival, the least mass on that first arrival. The rocket equation makes less mass
after a leg less mass before it, so nothing is lost. Missions are then put one after another, or
beside each other, by sets again. All legs have exact costs (:mod:`adr_opt.kernels.legs.drift`).

The grid is that of the instance, or every second time of it, every fourth and so on, as the work
allows, so that all times of a coarser instance are among those of a finer one.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from adr_opt.common.stop import TimeIsOver
from adr_opt.kernels.core.compile import kernel
from adr_opt.kernels.legs import drift, drift_pair
from adr_opt.kernels.orbits.ephemeris import EPOCH_S
from adr_opt.legs.families.ends import AllEnds

from .retiming import FineGrid, Growth, MissionTimes

FloatArray = npt.NDArray[np.float64]
Integers = npt.NDArray[np.int64]

MOST_TARGETS = 8
"""Number of targets up to which campaigns are enumerated."""

MOST_WORK = 3e9
"""Maximum number of sums and products; for more, the grid is coarser."""

LEG_WORK = 2_000
"""Work of computing a leg, in sums and products."""


class CoarseGrid(NamedTuple):
    """Grid of times for enumeration.

    Attributes
    ----------
    every : int
        Steps of the fine grid from one time to the next.
    first, times : int
        The first time, in these steps, and the number of times.
    """

    every: int
    first: int
    times: int


def grid_of(targets: int, fine: FineGrid, bounds: tuple[int, int]) -> CoarseGrid:
    """The finest grid whose work is affordable.

    Parameters
    ----------
    targets : int
    fine : FineGrid
    bounds : (int, int)
        First and last arrival anywhere, in steps of the fine grid.
    """
    every, pairs = 1, targets * (targets - 1)
    while True:
        first = math.ceil(bounds[0] / every)
        times = max(math.floor(bounds[1] / every) - first + 1, 0)
        band = min(fine.within // every + 1, times)
        work = pairs * 2.0 ** max(targets - 2, 0) * times * times * band
        work += LEG_WORK * pairs * times * min(fine.longest // every + 1, times)
        if work <= MOST_WORK:
            return CoarseGrid(every, first, times)
        every *= 2


@kernel
def _fill(pair, coarse, fine, hop, leaves):
    """The least ΔV between two arrivals of a pair, and the departure of that leg."""
    size = hop.shape[0]
    cost = np.empty(size)
    hop[:] = np.inf
    for a in range(size):
        for d in range(a):
            cost[d] = np.inf
            span = (a - d) * coarse.every
            if fine.shortest <= span <= fine.longest:
                step = coarse.every * fine.step
                times = (coarse.first + d) * step, (coarse.first + a) * step
                cost[d] = drift.delta_v(pair, times[0], times[1])
        best, of, d = np.inf, 0, a - 1
        # From the latest arrival back, more and more departures are early enough.
        for t in range(a - 1, -1, -1):
            while d >= 0 and (d - t) * coarse.every >= fine.stay:
                if cost[d] < best:
                    best, of = cost[d], d
                d -= 1
            if best < np.inf and (a - t) * coarse.every <= fine.within:
                hop[t, a], leaves[t, a] = best, of


@kernel
def _before(hop, after, growth, band, here):
    """The least mass on arrival at a target, by first and last arrival, with one more leg."""
    size = hop.shape[0]
    for t in range(size):
        for a in range(t + 1, min(size, t + band + 1)):
            if hop[t, a] == np.inf:
                continue
            factor, more = 1.0, hop[t, a]
            if growth.exhaust > 0.0:
                factor, more = math.exp(hop[t, a] / growth.exhaust), growth.kit
            for last in range(a, size):
                here[t, last] = min(here[t, last], factor * after[a, last] + more)


class Enumeration:
    """All missions of a small campaign on a grid.

    Parameters
    ----------
    ends : AllEnds
    first : int
        Number of the first target.
    targets : int
    fine : FineGrid
    coarse : CoarseGrid
    growth : Growth
    over : callable
        Whether the time is over.

    Raises
    ------
    TimeIsOver
        It is.
    """

    def __init__(
        self,
        ends: AllEnds,
        first: int,
        targets: int,
        fine: FineGrid,
        coarse: CoarseGrid,
        growth: Growth,
        over: Callable[[], bool],
    ) -> None:
        self._first, self._targets, self._growth = first, targets, growth
        self._fine, self._coarse, self._over = fine, coarse, over
        size = coarse.times
        self._hops: dict[tuple[int, int], tuple[FloatArray, Integers]] = {}
        for i in range(targets):
            for j in range(targets):
                if i == j:
                    continue
                self._ask()
                bodies = ends.leaving[first + i], ends.arriving[first + j]
                pair = drift_pair.prepare(*bodies, ends.rule, EPOCH_S)
                made = np.empty((size, size)), np.zeros((size, size), dtype=np.int64)
                _fill(pair, coarse, fine, *made)
                self._hops[i, j] = made
        band = fine.within // coarse.every
        self._least: dict[tuple[int, int], FloatArray] = {}
        for mask in range(1, 1 << targets):
            self._ask()
            for i in _members(mask, targets):
                here = np.full((size, size), np.inf)
                rest = mask ^ (1 << i)
                if not rest:
                    np.fill_diagonal(here, growth.begin)
                for j in _members(rest, targets):
                    _before(self._hops[i, j][0], self._least[rest, j], growth, band, here)
                self._least[mask, i] = here

    def _ask(self) -> None:
        if self._over():
            raise TimeIsOver

    def _of_set(self, mask: int) -> FloatArray:
        """The least mass at the launch of a mission, by its first and last arrival."""
        own = [self._least[mask, i] for i in _members(mask, self._targets)]
        found: FloatArray = np.min(np.stack(own), axis=0)
        return found

    def cheapest(
        self, price: Callable[[FloatArray, int], FloatArray], most: int, apart: int | None
    ) -> list[tuple[tuple[int, ...], MissionTimes]] | None:
        """The cheapest campaign: bodies and times of each mission in order; None if there is none.

        Parameters
        ----------
        price : callable
            Cost of missions from their masses at the launch and their number of targets; infinite
            where a tank is too small.
        most : int
            Most missions.
        apart : int or None
            Least steps of the fine grid from the last arrival of a mission to the launch of the
            next one; None where missions may overlap.
        """
        size, everything = self._coarse.times, (1 << self._targets) - 1
        costs = {
            mask: price(self._of_set(mask), mask.bit_count()) for mask in range(1, everything + 1)
        }
        gap = None if apart is None else math.ceil(apart / self._coarse.every)
        # By number of missions and set: the least cost by the time of the last arrival so far.
        known: list[dict[int, FloatArray]] = [{0: np.zeros(size)}]
        for _ in range(min(most, self._targets)):
            self._ask()
            made: dict[int, FloatArray] = {}
            for done, cost in known[-1].items():
                for mask in _subsets(everything ^ done):
                    ways = _since(cost, done, gap)[:, None] + costs[mask]
                    best = np.minimum.accumulate(ways.min(axis=0))
                    made[done | mask] = np.minimum(best, made.get(done | mask, np.inf))
            known.append(made)
        ends = [each[everything][-1] if everything in each else math.inf for each in known]
        missions = int(np.argmin(ends)) if size else 0
        if not size or not math.isfinite(ends[missions]):
            return None
        found: list[tuple[tuple[int, ...], MissionTimes]] = []
        mask, until = everything, size - 1
        while mask:
            missions -= 1
            mask, until, mission = self._last(known[missions], costs, mask, until, gap)
            found.insert(0, mission)
        return sorted(found, key=lambda each: int(each[1].arrivals[0]))

    def _last(
        self,
        known: dict[int, FloatArray],
        costs: dict[int, FloatArray],
        mask: int,
        until: int,
        gap: int | None,
    ) -> tuple[int, int, tuple[tuple[int, ...], MissionTimes]]:
        """The last mission of a set's cheapest campaign, with the remaining set and its end."""
        best, chosen = math.inf, (0, 0, 0)
        for own in _subsets(mask):
            if mask ^ own not in known:
                continue
            ways = _since(known[mask ^ own], mask ^ own, gap)[:, None] + costs[own][:, : until + 1]
            at = int(np.argmin(ways))
            if ways.flat[at] < best:
                best, chosen = float(ways.flat[at]), (own, *divmod(at, until + 1))
        own, launch, last = chosen
        rest = mask ^ own
        before = until if gap is None else max(launch - gap, 0)
        return rest, before, self._flown(own, launch, last)

    def _flown(self, mask: int, launch: int, last: int) -> tuple[tuple[int, ...], MissionTimes]:
        """Order and times of the mission of a set between two arrivals."""
        members = list(_members(mask, self._targets))
        i = min(members, key=lambda each: float(self._least[mask, each][launch, last]))
        total = float(self._least[mask, i][launch, last])
        order, arrivals, departures = [i], [launch], list[int]()
        growth = self._growth
        while mask := mask ^ (1 << i):
            at, best = arrivals[-1], (math.inf, 0, 0)
            for j in _members(mask, self._targets):
                hop, after = self._hops[i, j][0][at], self._least[mask, j][:, last]
                with np.errstate(invalid="ignore", over="ignore"):
                    ways = after + hop
                    if growth.exhaust > 0.0:
                        ways = after * np.exp(hop / growth.exhaust)
                ways = np.where(np.isnan(ways), math.inf, ways)
                best = min(best, (float(ways.min()), j, int(np.argmin(ways))))
            _, j, then = best
            departures.append(int(self._hops[i, j][1][at, then]))
            order.append(j)
            arrivals.append(then)
            i = j
        there, leaving = (
            self._coarse.every * (self._coarse.first + np.array(each, np.int64))
            for each in (arrivals, departures)
        )
        return tuple(self._first + j for j in order), MissionTimes(there, leaving, total)


def _since(cost: FloatArray, done: int, gap: int | None) -> FloatArray:
    """Cost of the missions before a launch, by its time."""
    if not done:
        return cost
    if gap is None:
        return np.full(cost.size, cost[-1])
    return np.concatenate([np.full(min(gap, cost.size), math.inf), cost[: max(cost.size - gap, 0)]])


def _members(mask: int, targets: int) -> Iterator[int]:
    """Targets of a set."""
    return (j for j in range(targets) if mask >> j & 1)


def _subsets(mask: int) -> Iterator[int]:
    """All nonempty subsets of a set."""
    part = mask
    while part:
        yield part
        part = (part - 1) & mask
