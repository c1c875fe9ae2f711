"""Start plans: bodies that a planner may begin from, taken from an earlier plan."""

from __future__ import annotations

from typing import Any

import numpy as np

from ..common.errors import InputError
from ..judge.admit import admit
from ..mission.problem import Problem
from ..plan.plan import Plan
from .run_options import Start


def start_destinations(
    problem: Problem, start: Start, *, repair: bool = False
) -> tuple[tuple[str, ...], ...]:
    """Names of a start plan's bodies by chaser, checked as far as possible without a timetable.

    Raises
    ------
    InputError
        A body is none of the mission; without ``repair``: :func:`adr_opt.check` is against the
        plan.
    """
    missions = problem.missions
    if isinstance(start, Plan):
        if not repair:
            try:
                admit(problem.instance, start)
            except InputError as error:
                raise InputError(
                    f"start plan: {error}; to keep its legal beginning only, solve with repair"
                ) from None
        if len(missions) == 1:
            return (start.destinations,)
        flown = {route.chaser: route.legs for route in start.routes}
        return tuple(
            tuple(leg.destination for leg in flown.get(mission.chaser.name, ()))
            for mission in missions
        )
    routes: list[Any] = list(start) if len(missions) > 1 else [start]
    single = [isinstance(route, (int, np.integer, str)) for route in routes]
    if len(routes) > len(missions) or any(single):
        raise InputError(
            f"start: must be a plan, or a sequence of bodies for each of {len(missions)} chasers"
        )
    routes += [()] * (len(missions) - len(routes))
    destinations = []
    done: set[str] = set()
    for mission, route in zip(missions, routes, strict=True):
        names = tuple(mission.names[j] for j in mission.numbers(route))
        twice = done.intersection(names).difference(mission.instance.station_names)
        if twice:
            raise InputError(f"start: {min(twice)!r} is visited by two chasers")
        done.update(names)
        destinations.append(names)
    return tuple(destinations)
