"""Planning where exceptions are limited, by the same mission without the limit and without them.

A plan of the mission without the limit that keeps to it is a best one, and its bound holds in any
case. A plan without exceptions keeps to the limit. From the better of them targets are added one by
one where the schedule of the whole order allows.
"""

from __future__ import annotations

import math
from collections.abc import Iterable
from typing import Any, Protocol

import numpy as np

from adr_opt.common.progress import Progress, silent
from adr_opt.common.stop import Stop
from adr_opt.mission.problem import Problem, Routes
from adr_opt.mission.result import Result
from adr_opt.problem.given import Given

from ..progress.gap import GapTracker
from ..progress.halting import ShareOfTime

SHARE = 0.5
"""Share of the remaining time for each of both missions."""

ROUNDS = 20
"""Rounds of each where work is limited and time is not."""


class _Planner(Protocol):
    def __call__(self, problem: Any, *, seed: int, stop: Stop, progress: Progress) -> Result: ...


class _Rounds(ShareOfTime):
    """A share of the time, and a number of rounds at most."""

    def __init__(self, stop: Stop) -> None:
        super().__init__(stop, SHARE)
        self._left = ROUNDS if math.isinf(stop.remaining_s()) else math.inf

    def __call__(self, incumbent: float, bound: float) -> bool:
        """Whether to stop."""
        self._left -= 1
        return self._left < 0 or super().__call__(incumbent, bound)


def _without_exceptions(problem: Problem) -> Problem:
    """The same problem without connections that are exceptions."""
    instance = problem.without_limits_of_exceptions().instance
    given = instance.given
    assert given is not None
    assert given.exception is not None
    rows = np.flatnonzero(~given.exception)
    columns = given.origin, given.destination, given.departure, given.arrival, given.cost
    usual = Given(given.names, *(column[rows] for column in columns))  # type: ignore[arg-type]
    return Problem(instance.with_given(usual), margin=problem.margin)


def plan(
    method: str,
    problem: Problem,
    *,
    seed: int,
    stop: Stop,
    progress: Progress,
    start: Iterable[Iterable[int]] | None = None,
    planner: _Planner,
) -> Result:
    """The best plan found that keeps to the limits of exceptions, and a bound.

    Parameters
    ----------
    method : str
        What the result is said to be of.
    problem : Problem
    seed, stop, progress, start
        As planners take them.
    planner : callable
        Plans missions in which exceptions are not limited.
    """
    certificate = GapTracker(problem, progress)
    certificate.offer(*((),) * len(problem.missions))
    if start is not None:
        certificate.offer(*start)
    unlimited = problem.without_limits_of_exceptions()
    free = planner(unlimited, seed=seed, stop=_Rounds(stop), progress=silent)
    if free.upper_bound == -math.inf:
        certificate.lower(-math.inf)
    elif math.isfinite(free.upper_bound):
        certificate.lower(problem.worth(free.upper_bound), free.evidence)
    _offer(certificate, problem, free.routes)
    if not certificate.proven and stop.remaining_s() > 0.0:
        usual = planner(
            _without_exceptions(problem), seed=seed, stop=_Rounds(stop), progress=silent
        )
        _offer(certificate, problem, usual.routes)
    while not certificate.proven and stop.remaining_s() > 0.0:
        if not _added(certificate, problem, stop):
            break
    return certificate.result(method, seed=seed, counters={}, upper_bound=certificate.stated)


def _offer(certificate: GapTracker, problem: Problem, routes: Routes) -> None:
    """Offer routes as far as they can be flown."""
    if routes:
        legal = []
        for mission, route in zip(problem.missions, routes, strict=True):
            legal.append(mission.closed(route[: mission.time(route).made]))
        certificate.offer(*legal)


def _added(certificate: GapTracker, problem: Problem, stop: Stop) -> bool:
    """Add a target to the best plan where it fits; returns whether one did."""
    routes = certificate.routes or ()
    done = {body for route in routes for body in route}
    first = problem.instance.first_target
    missing = [body for body in range(first, len(problem.names)) if body not in done]
    missing.sort(key=lambda body: -problem.missions[0].planning_prizes[body])
    for body in missing:
        for number, route in enumerate(routes):
            for place in range(len(route) + 1):
                if stop.remaining_s() <= 0.0:
                    return False
                changed = (*route[:place], body, *route[place:])
                if certificate.offer(*routes[:number], changed, *routes[number + 1 :]):
                    return True
    return False
