"""The cheapest plan on a grid of departures, by all subsets of debris.

The least ΔV with which a chaser has met a set of debris, by the last of them and the time on the
grid from which it is ready; then the cheapest way to cut all debris into so many sets. Exact for
chasers that leave at times of the grid only. Nothing is shared with planners.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from adr_opt.kernels.core.compile import kernel

from ..reading import FloatArray
from .estimate import matrices
from .scoring import LOAD, LONGEST_S, MOST_M_S, Route


class Tables(NamedTuple):
    """Legs on the grid, as (departures, bodies, bodies), and what is known of sets of debris.

    Attributes
    ----------
    cost : (departures, bodies, bodies) float64
        [m/s].
    then : (departures, bodies, bodies) int64
        First time of the grid after the arrival; that after the last one where it is in time but
        nothing can follow; −1 where it is late.
    spent : (sets, debris, times) float64
        Least ΔV to be ready at the last debris of a set at a time or before [m/s].
    """

    cost: FloatArray
    then: np.ndarray
    spent: FloatArray


@kernel
def _spread(spent, done, last):
    """A ready chaser may wait."""
    for time in range(1, spent.shape[2]):
        spent[done, last, time] = min(spent[done, last, time], spent[done, last, time - 1])


@kernel
def _fill(tables, load, most):
    """Fill the table of sets, in the order of their numbers, which is one of inclusion."""
    cost, then, spent = tables.cost, tables.then, tables.spent
    times, count = cost.shape[0], spent.shape[1]
    spent[:] = np.inf
    for one in range(count):
        for time in range(times):
            ready = then[time, 0, one + 1]
            if ready >= 0 and cost[time, 0, one + 1] <= most:
                before = spent[1 << one, one, ready]
                spent[1 << one, one, ready] = min(before, cost[time, 0, one + 1])
    for done in range(1, 1 << count):
        size = 0
        for one in range(count):
            size += done >> one & 1
        for last in range(count):
            if not done >> last & 1:
                continue
            _spread(spent, done, last)
            if size == load:
                continue
            for one in range(count):
                if done >> one & 1:
                    continue
                for time in range(times):
                    total = spent[done, last, time] + cost[time, last + 1, one + 1]
                    ready = then[time, last + 1, one + 1]
                    if ready >= 0 and total <= most:
                        if total < spent[done | 1 << one, one, ready]:
                            spent[done | 1 << one, one, ready] = total


@kernel
def _cut(least, chasers, best, part):
    """The cheapest partition of each set into a maximum number of parts, with its first part.

    Parameters
    ----------
    least : (sets,) float64
        ΔV of a chaser that meets a set.
    best, part : (chasers + 1, sets) float64, int64
        Are filled.
    """
    sets = least.size
    best[:] = np.inf
    best[0, 0] = 0.0
    for chaser in range(1, chasers + 1):
        for done in range(sets):
            best[chaser, done], part[chaser, done] = best[chaser - 1, done], 0
            if done == 0:
                continue
            low = done & -done
            rest = done ^ low
            some = rest
            while True:
                # The part with the lowest debris: every cut is seen once.
                taken = some | low
                total = least[taken] + best[chaser - 1, done ^ taken]
                if total < best[chaser, done]:
                    best[chaser, done], part[chaser, done] = total, taken
                if some == 0:
                    break
                some = (some - 1) & rest


def tables_of(bodies: FloatArray, steps: int, load: int = LOAD) -> Tables:
    """Possible routes of chasers that leave at one of ``steps`` equal parts of the time."""
    grid = LONGEST_S * np.arange(steps + 1) / steps
    duration, cost = matrices(bodies, grid)
    arrival = grid[:, None, None] + duration
    then = np.searchsorted(grid, arrival - 1e-6)
    then[arrival > LONGEST_S] = -1
    count = len(bodies) - 1
    tables = Tables(cost, then, np.empty((1 << count, count, steps + 1)))
    _fill(tables, load, MOST_M_S)
    return tables


def cheapest(
    bodies: FloatArray, steps: int, chasers: int, load: int = LOAD
) -> tuple[float, tuple[Route, ...]]:
    """Least total ΔV [m/s] on a grid with a number of steps, with its plan."""
    tables = tables_of(bodies, steps, load)
    least = tables.spent[:, :, -1].min(axis=1)
    best = np.empty((chasers + 1, least.size))
    part = np.zeros(best.shape, np.int64)
    _cut(least, chasers, best, part)
    done, routes = least.size - 1, []
    total = float(best[chasers, done])
    for chaser in range(chasers, 0, -1):
        taken = int(part[chaser, done])
        if taken and np.isfinite(total):
            routes.append(_route(tables, taken, steps))
            done ^= taken
    return total, tuple(routes)


def _route(tables: Tables, done: int, steps: int) -> Route:
    """Route of a chaser over a set at least ΔV, backwards."""
    cost, then, spent = tables
    time, left = steps, float(spent[done, :, -1].min())
    last = int(np.argmin(spent[done, :, -1]))
    debris, departures = [], []
    while done:
        before = done & ~(1 << last)
        origins = [one for one in range(spent.shape[1]) if before >> one & 1]
        off = {}
        for one in origins or [-1]:
            for leaves in range(cost.shape[0]):
                if 0 <= then[leaves, one + 1, last + 1] <= time:
                    so_far = float(spent[before, one, leaves]) if origins else 0.0
                    off[one, leaves] = abs(so_far + cost[leaves, one + 1, last + 1] - left)
        one, leaves = min(off, key=lambda way: off[way])
        debris.append(last)
        departures.append(LONGEST_S * leaves / steps)
        left = float(spent[before, one, leaves]) if origins else 0.0
        done, last, time = before, one, leaves
    return Route(tuple(debris[::-1]), tuple(departures[::-1]))
