"""Routes of one chaser over the targets left by others."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from weakref import WeakKeyDictionary

import numpy as np
import numpy.typing as npt

from adr_opt.mission.mission import Mission
from adr_opt.mission.problem import Problem, Routes
from adr_opt.plan.station_limits import Use

from ..beams.greedy_order import guarded_sequence

FloatArray = npt.NDArray[np.float64]

RouteOf = Callable[[Mission], Iterable[int]]


def left(problem: Problem, done: Iterable[int]) -> FloatArray:
    """Worths of remaining targets, and −inf for serviced ones, shape (bodies,)."""
    worths = np.array(problem.planning_prizes)
    for j in done:
        worths[j] = -np.inf
    worths[: problem.instance.first_target] = 0.0
    return worths


def targets_of(problem: Problem, routes: Iterable[Iterable[int]]) -> set[int]:
    """The targets on routes."""
    first = problem.instance.first_target
    return {j for route in routes for j in route if j >= first}


def one_after_another(problem: Problem, route_of: RouteOf) -> Routes:
    """Routes made chaser by chaser, each over the targets left by the previous ones.

    Parameters
    ----------
    problem : Problem
    route_of : callable
        From the mission of a chaser that offers what is left to its route.
    """
    if problem.alone is not None:
        return (tuple(int(j) for j in route_of(problem.alone)),)
    routes: list[tuple[int, ...]] = []
    uses: list[Use] = []
    for mission in problem.missions:
        worths = left(problem, targets_of(problem, routes))
        offered = mission.offering(without_empty(problem, worths, uses))
        route, use = trimmed(problem, mission, [int(j) for j in route_of(offered)], uses)
        routes.append(route)
        uses.append(use)
    return tuple(routes)


def guarded_routes(problem: Problem) -> Routes:
    """The routes of the planner ``greedy-guarded`` with its usual options, computed once."""
    if problem not in _guarded:
        _guarded[problem] = one_after_another(problem, guarded_sequence)
    return _guarded[problem]


_guarded: WeakKeyDictionary[Problem, Routes] = WeakKeyDictionary()


def without_empty(problem: Problem, worths: FloatArray, uses: Sequence[Use]) -> FloatArray:
    """Worths with −inf at stations whose supplies are exhausted.

    Parameters
    ----------
    problem : Problem
    worths : (bodies,) float64
        Written.
    uses : sequence of tuple of float
        What others take of stations.
    """
    if problem.limits:
        worths[list(problem.limits.exhausted(problem.limits.left(uses)))] = -np.inf
    return worths


def trimmed(
    problem: Problem, mission: Mission, route: Iterable[int], uses: Sequence[Use]
) -> tuple[tuple[int, ...], Use]:
    """The longest beginning of a route within stations' propellant, and its use of it.

    Parameters
    ----------
    problem : Problem
    mission : Mission
        Of the chaser.
    route : iterable of int
    uses : sequence of tuple of float
        What others take.
    """
    moves = tuple(route)
    if not problem.limits:
        return moves, ()
    while True:
        closed = mission.closed(moves)
        schedule = mission.time(closed)
        use = problem.use(mission, closed[: schedule.made], schedule.delta_vs)
        if not moves or problem.limits.allow([*uses, use]):
            return moves, use
        stops = [at for at, body in enumerate(moves) if mission.rules.is_station[body]]
        # Without a stop on the way it is the one at the end that takes too much.
        moves = moves[: stops[-1] if stops else -1]
