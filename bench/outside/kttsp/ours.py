"""Our tours of the targets, from nothing.

How early a target can be reached from another one, by when one is ready there, is tabulated for all
pairs on a grid of times, and the tour that ends earliest on these tables found by all states
(:mod:`solvers.tours.earliest`). Flown in continuous time it ends at some time, and only pairs and
times that matter to tours which end little later are tabulated once more, finer, stage by stage.
"""

from __future__ import annotations

import math
import time
from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from adr_opt.common.constants import DAY_S
from adr_opt.common.errors import InputError
from solvers.tours.earliest import Arrivals, Found, arrivals_of, earliest_tour, near_of
from solvers.tours.earliest_arrivals import wanted_by

from .arrivals import earliest, earliest_from
from .reading import Problem, Tour
from .scoring import score
from .spans import least_cost_m_s

STEP_D = 0.04
"""Of the first tables."""

STAGES = (4, 2.0), (1, 1.0), (2, 0.6), (1, 0.4)
"""Parts of a step of the next tables, and how much later than the best tour those end that they are
made for [d]. Finer tables make states earlier than was thought, so that others matter then."""

FIRST_SHARE = 0.6
"""Of the time that a tour may take, for a first search."""

FLIGHT_D = {0: 10.0, 1: 4.0}
"""The longest flights of legs that are looked at for a plan, usual ones and exceptions."""

FLYING_D = 0.005
"""Between times at which departures and arrivals in continuous time begin."""

UNDER_M_S = 1e-6
"""So much cheaper than the limit legs are kept, against rounding."""

Leg = tuple[int, int, int]


class Ours(NamedTuple):
    """What was planned.

    Attributes
    ----------
    tour : Tour
    duration_d : float
    time_s, processor_s : float
        Of planning, tables included.
    """

    tour: Tour
    duration_d: float
    time_s: float
    processor_s: float


def limit_m_s(problem: Problem, kind: int) -> float:
    """Of usual legs (0) and of exceptions (1)."""
    return problem.most_exception_m_s if kind else problem.most_m_s


def legs_of(problem: Problem) -> list[Leg]:
    """Kind, origin and destination of all legs that are not ruled out at any time."""
    count = problem.targets
    pairs = [(i, j) for i in range(count) for j in range(count) if i != j]
    least = {pair: least_cost_m_s(*(problem.elements[one] for one in pair)) for pair in pairs}
    return [
        (kind, *pair)
        for kind in range(2)
        for pair in pairs
        if least[pair] <= limit_m_s(problem, kind) * (1.0 + 1e-9)
    ]


def windows_of(marks: npt.NDArray[np.bool_]) -> Iterator[tuple[int, int]]:
    """First places of runs of what is true, and those after their last."""
    edges = np.flatnonzero(np.diff(np.concatenate([[False], marks, [False]]).astype(np.int8)))
    for first, last in zip(edges[::2], edges[1::2], strict=True):
        yield int(first), int(last)


def first_tables(problem: Problem, end_d: float, jobs: int) -> Arrivals:
    """The earliest arrivals of all legs on the first grid [d]."""
    times = int(end_d / STEP_D) + 1
    tables = np.full((2, problem.targets, problem.targets, times), np.inf)

    def fill(leg: Leg) -> None:
        kind, i, j = leg
        earliest(
            problem.elements[i], problem.elements[j], STEP_D * DAY_S,
            problem.least_flight_d * DAY_S, FLIGHT_D[kind] * DAY_S,
            limit_m_s(problem, kind) - UNDER_M_S, 0, times, tables[kind, i, j],
        )  # fmt: skip

    with ThreadPoolExecutor(jobs) as threads:
        list(threads.map(fill, legs_of(problem)))
    tables /= DAY_S
    return arrivals_of(STEP_D, *tables, problem.exceptions, linear=True)


def finer_tables(
    problem: Problem, tables: Arrivals, marks: npt.NDArray[np.bool_], parts: int, jobs: int
) -> Arrivals:
    """Arrivals of the legs that matter, on a grid of so many parts of a step where they do."""
    rows = np.flatnonzero(marks.any(axis=1))
    row = np.full(tables.row.shape, -1, dtype=np.int64)
    step = tables.step / parts
    finer = np.full((rows.size, (marks.shape[1] - 1) * parts + 1), np.inf)
    legs = {int(tables.row[leg]): leg for leg in np.ndindex(*tables.row.shape)}

    def fill(place: int) -> None:
        kind, i, j = legs[int(rows[place])]
        row[kind, i, j] = place
        # Who waits for the next time of the first grid arrives as its table says.
        known = np.repeat(tables.arrival[rows[place], 1:], parts)
        finer[place, 0], finer[place, 1:] = tables.arrival[rows[place], 0], known
        line = finer[place] * DAY_S
        for first, last in windows_of(marks[rows[place]]):
            earliest(
                problem.elements[i], problem.elements[j], step * DAY_S,
                problem.least_flight_d * DAY_S, FLIGHT_D[kind] * DAY_S,
                limit_m_s(problem, kind) - UNDER_M_S, first * parts,
                min(last * parts + 1, line.size), line,
            )  # fmt: skip
        finer[place] = line / DAY_S

    with ThreadPoolExecutor(jobs) as threads:
        list(threads.map(fill, range(rows.size)))
    near = near_of(row[0] >= 0)
    return Arrivals(step, row, finer, near, problem.exceptions, True)


def flown(problem: Problem, found: Found) -> Tour:
    """A tour in continuous time: each leg arrives as early as it can.

    Raises
    ------
    InputError
        Some leg of the tour was in the tables only.
    """
    ready, departures, flights = problem.begin_d, [], []
    for i, j, kind in zip(found.order[:-1], found.order[1:], found.exceptional, strict=True):
        departure, arrival = earliest_from(
            problem.elements[i], problem.elements[j], ready * DAY_S, FLYING_D * DAY_S,
            problem.least_flight_d * DAY_S, (ready + FLIGHT_D[0]) * DAY_S,
            limit_m_s(problem, int(kind)) - UNDER_M_S,
        )  # fmt: skip
        if not math.isfinite(arrival):
            raise InputError(f"{problem.name}: no leg from {i} to {j}; take shorter steps")
        departures.append(departure / DAY_S)
        flights.append((arrival - departure) / DAY_S)
        ready = departures[-1] + flights[-1]
    return Tour(np.array(departures), np.array(flights), np.array(found.order))


def plan(problem: Problem, *, end_d: float | None = None, jobs: int = 2) -> Ours:
    """Plan a tour.

    Parameters
    ----------
    problem : Problem
    end_d : float, optional
        Tours that end later are not looked for. By default they may take as long as they like, but
        it is tried with less first.
    jobs : int
        Threads.

    Raises
    ------
    InputError
        No tour was found.
    """
    clock = time.perf_counter(), time.process_time()
    for last_d in (
        (FIRST_SHARE * problem.longest_d, problem.longest_d) if end_d is None else (end_d,)
    ):
        tables = first_tables(problem, last_d, jobs)
        found = earliest_tour(tables, last_d, begin=problem.begin_d)
        if found.order:
            break
    else:
        raise InputError(f"{problem.name}: no tour was found in {last_d:g} d")
    best = flown(problem, found)
    ends = score(problem, best).duration_d
    for parts, margin_d in STAGES:
        later = min(ends, found.end) + margin_d
        found = earliest_tour(tables, later, begin=problem.begin_d)
        marks = wanted_by(tables, found, later) > -np.inf
        tables = finer_tables(problem, tables, marks, parts, jobs)
        found = earliest_tour(tables, later, begin=problem.begin_d)
        if not found.order:
            break
        tour = flown(problem, found)
        judged = score(problem, tour)
        if not judged.violations and judged.duration_d < ends:
            best, ends = tour, judged.duration_d
    spent = time.perf_counter() - clock[0], time.process_time() - clock[1]
    return Ours(best, ends, *spent)
