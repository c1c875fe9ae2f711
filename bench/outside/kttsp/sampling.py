"""Tables of given connections, sampled from Lambert arcs.

Of each pair the arcs that arrive earliest by when one is ready, on a grid of departures: an arc is
a row if none of those that depart later arrives as early. Arrivals are looked for on a coarser
grid and then made as early as they can be.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from adr_opt.common.constants import DAY_S
from adr_opt.kernels.core.compile import kernel

from ..reading import FloatArray
from . import kepler
from .arrivals import HALVINGS, within
from .costs import REVOLUTIONS, cheapest
from .reading import Problem
from .spans import least_cost_m_s

UNDER_M_S = 1e-6
"""So much cheaper than the limit rows are, against rounding."""

Leg = tuple[int, int, int]
"""Kind (1 for exceptions), origin, destination."""


class Grid(NamedTuple):
    """What is sampled.

    Attributes
    ----------
    end_d : float
        No departure is later.
    step_d, arrival_d : tuple of float
        Between departures, and between arrivals, of usual arcs and of exceptions.
    flight_d : tuple of float
        The longest flights.
    nearest : tuple of int
        Destinations of an origin, those that can be cheapest: of usual arcs, and of exceptions for
        each group that usual arcs join.
    """

    end_d: float
    step_d: tuple[float, float] = (0.01, 0.05)
    arrival_d: tuple[float, float] = (0.02, 0.05)
    flight_d: tuple[float, float] = (6.0, 3.0)
    nearest: tuple[int, int] = (60, 8)


class Rows(NamedTuple):
    """Rows of a table: origins and destinations, times [s], ΔV [m/s], and which are exceptions."""

    origin: npt.NDArray[np.int32]
    destination: npt.NDArray[np.int32]
    departure: FloatArray
    arrival: FloatArray
    delta_v: FloatArray
    exception: npt.NDArray[np.bool_]


def limit_m_s(problem: Problem, kind: int) -> float:
    """Of usual legs (0) and of exceptions (1)."""
    return problem.most_exception_m_s if kind else problem.most_m_s


def legs_of(problem: Problem) -> list[Leg]:
    """Kind, origin and destination of all legs that are not ruled out at any time."""
    least = _least(problem)
    return [
        (kind, int(i), int(j))
        for kind in range(2)
        for i, j in zip(
            *np.nonzero(least <= limit_m_s(problem, kind) * (1.0 + 1e-9)), strict=True
        )
    ]  # fmt: skip


def _least(problem: Problem) -> FloatArray:
    """What legs of all pairs cost at least; infinite from a target to itself [m/s]."""
    count = problem.targets
    least = np.full((count, count), np.inf)
    for i in range(count):
        for j in range(i):
            least[i, j] = least[j, i] = least_cost_m_s(problem.elements[i], problem.elements[j])
    return least


def sampled_legs(problem: Problem, nearest: tuple[int, int]) -> list[Leg]:
    """Those of :func:`legs_of` that are sampled."""
    least, found = _least(problem), list[Leg]()
    joined = least <= problem.most_m_s
    group = np.arange(problem.targets)
    for _ in range(problem.targets):
        lowest = np.minimum(group, np.where(joined, group[None, :], problem.targets).min(axis=1))
        if (lowest == group).all():
            break
        group = lowest
    for i in range(problem.targets):
        order = np.argsort(least[i], kind="stable")
        usual = order[least[i, order] <= problem.most_m_s][: nearest[0]]
        found += [(0, i, int(j)) for j in usual]
        special = order[least[i, order] <= problem.most_exception_m_s]
        for number in np.unique(group):
            found += [(1, i, int(j)) for j in special[group[special] == number][: nearest[1]]]
    return found


@kernel
def _earliest(pair, steps, least, longest, limit, wanted, arrival):
    """The earliest arrival by when one is ready, on a grid of departures.

    Parameters
    ----------
    pair : tuple of (6,) float64
        Elements of both targets.
    steps : tuple of float
        Between departures, and between arrivals [s].
    least, longest : float
        Flights [s].
    limit : float
        [m/s].
    wanted : (departures,) bool
        Departures that are looked at.
    arrival : (departures,) float64
        Is filled [s]; infinite where nobody is known to arrive.
    """
    step, coarse = steps
    count = int(((arrival.size - 1) * step + longest) / coarse) + 2
    r_1, v_1, r, v = np.empty(3), np.empty(3), np.empty(3), np.empty(3)
    r_2, v_2 = np.empty((count, 3)), np.empty((count, 3))
    for m in range(count):
        kepler.state(pair[1], m * coarse, r_2[m], v_2[m])
    known = math.inf
    for k in range(arrival.size - 1, -1, -1):
        leaves = k * step
        if wanted[k]:
            kepler.state(pair[0], leaves, r_1, v_1)
            first = math.ceil((leaves + least) / coarse)
            for m in range(first, int((leaves + longest) / coarse) + 1):
                if m * coarse >= known:
                    break
                if within(r_1, v_1, r_2[m], v_2[m], m * coarse - leaves, limit):
                    good, bad = m * coarse, max((m - 1) * coarse, leaves + least)
                    for _ in range(HALVINGS):
                        middle = 0.5 * (good + bad)
                        kepler.state(pair[1], middle, r, v)
                        if within(r_1, v_1, r, v, middle - leaves, limit):
                            good = middle
                        else:
                            bad = middle
                    known = min(known, good)
                    break
        arrival[k] = known


@kernel
def _rows(elements_i, elements_j, step, limit, arrival, departures, arrivals, delta_v):
    """Rows of a pair from its earliest arrivals; returns how many."""
    r_1, v_1, r_2, v_2 = np.empty(3), np.empty(3), np.empty(3), np.empty(3)
    found = np.empty((4 * REVOLUTIONS + 2, 6))
    count = 0
    for k in range(arrival.size):
        later = arrival[k + 1] if k + 1 < arrival.size else math.inf
        if not arrival[k] < later:
            continue
        kepler.state(elements_i, k * step, r_1, v_1)
        kepler.state(elements_j, arrival[k], r_2, v_2)
        cost = cheapest(r_1, v_1, r_2, v_2, arrival[k] - k * step, limit, found)
        if cost <= limit:
            departures[count], arrivals[count], delta_v[count] = k * step, arrival[k], cost
            count += 1
    return count


def sampled(
    problem: Problem,
    grid: Grid,
    *,
    visits_d: FloatArray | None = None,
    within_d: float = math.inf,
    jobs: int = 2,
    doing: Callable[[int, int], None] | None = None,
) -> Rows:
    """The rows of all pairs.

    Parameters
    ----------
    problem : Problem
    grid : Grid
    visits_d : (targets,) float64, optional
        When a plan leaves each target: no departures are sampled but those near it [d].
    within_d : float
        How near [d].
    jobs : int
        Threads.
    doing : callable, optional
        Hears of the number of pairs done, and of all.
    """
    legs = sampled_legs(problem, grid.nearest)
    done = 0

    def one(leg: Leg) -> tuple[FloatArray, FloatArray, FloatArray]:
        nonlocal done
        kind, i, j = leg
        step = grid.step_d[kind] * DAY_S
        arrival = np.full(int(grid.end_d / grid.step_d[kind]) + 1, np.inf)
        limit = limit_m_s(problem, kind) - UNDER_M_S
        pair = problem.elements[i], problem.elements[j]
        wanted = np.ones(arrival.size, dtype=np.bool_)
        if visits_d is not None:
            leaves_d = np.arange(arrival.size) * grid.step_d[kind]
            wanted = np.abs(leaves_d - visits_d[i]) <= within_d
        _earliest(
            pair, (step, grid.arrival_d[kind] * DAY_S), problem.least_flight_d * DAY_S,
            grid.flight_d[kind] * DAY_S, limit, wanted, arrival,
        )  # fmt: skip
        columns = np.empty((3, arrival.size))
        count = _rows(*pair, step, limit, arrival, *columns)
        done += 1
        if doing is not None:
            doing(done, len(legs))
        return tuple(column[:count].copy() for column in columns)  # type: ignore[return-value]

    with ThreadPoolExecutor(jobs) as threads:
        parts = list(threads.map(one, legs))
    sizes = [part[0].size for part in parts]
    kind, origin, destination = np.repeat(np.array(legs, dtype=np.int32), sizes, axis=0).T
    times = [np.concatenate([part[column] for part in parts]) for column in range(3)]
    return Rows(origin, destination, *times, kind.astype(np.bool_))
