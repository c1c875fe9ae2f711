"""Our tours of the targets, from nothing: sampled, planned by ``solve``, flown, sampled again.

A table of arcs is sampled (:mod:`.sampling`), ``adr_opt.solve`` plans the mission over it
(:mod:`.instances`), and its tour is flown in continuous time. Near the times of that tour arcs are
then sampled on finer grids, and the mission is planned again from it.
"""

from __future__ import annotations

import math
import time
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

import adr_opt
from adr_opt.common.constants import DAY_S
from adr_opt.common.errors import InputError

from .arrivals import earliest_from
from .costs import delta_v_m_s
from .instances import instance_of, names_of, tour_of_plan
from .reading import Problem, Tour
from .sampling import UNDER_M_S, Grid, limit_m_s, sampled
from .scoring import score

FIRST_SHARE = 0.6
"""Of the time that a tour may take, for a first search."""

FIRST = Grid(math.nan, (0.02, 0.04), (0.02, 0.04), (7.0, 4.0), (60, 60))
"""What is sampled first."""

FINER = (
    (15.0, Grid(math.nan, (0.01, 0.02), (0.02, 0.02), (7.0, 1.0), (60, 20))),
    (2.0, Grid(math.nan, (0.0025, 0.005), (0.02, 0.02), (7.0, 1.0), (60, 20))),
)
"""How near to the times of the tour departures are then sampled [d], and what."""

PLANNING_S = 60.0
"""Time for planning on each table."""

FLYING_D = 0.005
"""Between times at which departures and arrivals in continuous time begin."""

FILE = "connections.parquet"


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


def flown(problem: Problem, order: npt.NDArray[np.int64], kinds: list[int]) -> Tour:
    """A tour in continuous time: each leg arrives as early as it can.

    Parameters
    ----------
    problem : Problem
    order : (targets,) int64
    kinds : list of int
        Of the legs, 1 for exceptions.

    Raises
    ------
    InputError
        Some leg of the tour was in the tables only.
    """
    ready, departures, flights = problem.begin_d, [], []
    for i, j, kind in zip(order[:-1], order[1:], kinds, strict=True):
        departure, arrival = earliest_from(
            problem.elements[i], problem.elements[j], ready * DAY_S, FLYING_D * DAY_S,
            problem.least_flight_d * DAY_S, (ready + FIRST.flight_d[0]) * DAY_S,
            limit_m_s(problem, kind) - UNDER_M_S,
        )  # fmt: skip
        if not math.isfinite(arrival):
            raise InputError(f"{problem.name}: no leg from {i} to {j}; take shorter steps")
        departures.append(departure / DAY_S)
        flights.append((arrival - departure) / DAY_S)
        ready = departures[-1] + flights[-1]
    return Tour(np.array(departures), np.array(flights), np.array(order))


def kinds_of(problem: Problem, tour: Tour) -> list[int]:
    """Which legs of a tour are exceptions."""
    legs = zip(tour.order[:-1], tour.order[1:], tour.departures_d, tour.flights_d, strict=True)
    return [int(delta_v_m_s(problem, *leg) > problem.most_m_s) for leg in legs]


def visits_d(problem: Problem, tour: Tour) -> npt.NDArray[np.float64]:
    """When a tour leaves each target; when it ends, of the last one [d]."""
    found = np.empty(problem.targets)
    found[tour.order[:-1]] = tour.departures_d
    found[tour.order[-1]] = tour.departures_d[-1] + tour.flights_d[-1]
    return found


def planned(
    problem: Problem, grid: Grid, *, limit_s: float = PLANNING_S, near: Tour | None = None,
    within_d: float = math.inf, jobs: int = 2,
) -> Tour | None:  # fmt: skip
    """The tour that ``solve`` finds over a sampled table; None if it finds none.

    Parameters
    ----------
    problem : Problem
    grid : Grid
    limit_s : float
        Of planning.
    near : Tour, optional
        To begin from; departures are sampled near its own.
    within_d : float
        How near [d].
    jobs : int
    """
    visits = None if near is None else visits_d(problem, near)
    rows = sampled(problem, grid, visits_d=visits, within_d=within_d, jobs=jobs)
    instance = instance_of(problem, rows, FILE)
    start = None if near is None else [names_of(problem)[one] for one in near.order]
    result = adr_opt.solve(
        instance, time_limit=limit_s, jobs=jobs, start=start, repair=start is not None
    )
    return None if result.plan is None else tour_of_plan(problem, result.plan)


def plan(
    problem: Problem, *, end_d: float | None = None, limit_s: float = PLANNING_S, jobs: int = 2
) -> Ours:
    """Plan a tour.

    Parameters
    ----------
    problem : Problem
    end_d : float, optional
        Tours that end later are not looked for. By default they may take as long as they like, but
        it is tried with less first.
    limit_s : float
        For planning on each table.
    jobs : int
        Threads.

    Raises
    ------
    InputError
        No tour was found.
    """
    clock = time.perf_counter(), time.process_time()
    ends = (FIRST_SHARE * problem.longest_d, problem.longest_d) if end_d is None else (end_d,)
    for last_d in ends:
        tour = planned(problem, FIRST._replace(end_d=last_d), limit_s=limit_s, jobs=jobs)
        if tour is not None:
            break
    else:
        raise InputError(f"{problem.name}: no tour was found in {ends[-1]:g} d")
    best, end = tour, math.inf
    for within_d, grid in (*FINER, (0.0, None)):
        for each in (tour, flown(problem, tour.order, kinds_of(problem, tour))):
            judged = score(problem, each)
            if not judged.violations and judged.duration_d < end:
                best, end = each, judged.duration_d
        if grid is not None:
            found = planned(
                problem, grid._replace(end_d=min(end, last_d)), limit_s=limit_s, near=best,
                within_d=within_d, jobs=jobs,
            )  # fmt: skip
            tour = best if found is None else found
    spent = time.perf_counter() - clock[0], time.process_time() - clock[1]
    return Ours(best, end, *spent)
