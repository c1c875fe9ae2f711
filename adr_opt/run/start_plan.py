"""Start plans: bodies that a planner may begin from, taken from an earlier plan."""

from __future__ import annotations

from collections.abc import Iterable
from itertools import takewhile
from typing import Any

import numpy as np

from ..common.errors import InputError
from ..judge.check.verdict import check
from ..kernels.rules.loads import most_kits
from ..mission.mission import Mission
from ..mission.problem import Problem
from ..mission.refused_legs import why_not_flown
from ..plan.plan import Plan

Start = Plan | Iterable[int | str] | Iterable[Iterable[int | str]]
"""A plan, or its bodies in order; for several chasers, one sequence each."""


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
            _refuse_violations(problem, start)
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


def legal_beginning(
    mission: Mission, destinations: Iterable[str], *, repair: bool
) -> tuple[int, ...]:
    """The bodies with these names, up to the first that the mission lacks.

    Raises
    ------
    InputError
        Without ``repair``: a move is illegal; the sentence says which and why.
    """
    index = {name: number for number, name in enumerate(mission.names)}
    moves = [index[name] for name in takewhile(index.__contains__, destinations)]
    timing = mission.time(moves)
    if timing.made < len(moves) and not repair:
        # Next to impossible for a plan that was checked: rounding at the very edge of the slack.
        raise InputError(
            f"start plan: leg {timing.made + 1} {why_illegal(mission, moves, timing.made)}; "
            "correct it, or repair: keep the legal beginning only"
        )
    return tuple(moves[: timing.made])


def _refuse_violations(problem: Problem, plan: Plan) -> None:
    try:
        violations = check(problem.instance, plan)
    except InputError as error:
        raise InputError(
            f"start plan: {error}, or repair: keep the beginning that is legal here"
        ) from None
    if violations:
        more = f" (and {len(violations) - 1} more)" if len(violations) > 1 else ""
        raise InputError(
            f"start plan: {violations[0]}{more}; "
            "correct it, or repair: keep the legal beginning only"
        )


def why_illegal(mission: Mission, moves: list[int], made: int) -> str:
    """Reason why the first illegal move of a sequence is illegal."""
    rules, j = mission.rules, moves[made]
    body = moves[made - 1] if made else rules.start
    name = repr(mission.names[j])
    if rules.is_station[j] and (rules.is_station[body] or body == rules.start):
        return "refuels, but no target was visited since the last refuelling"
    if j == body:
        return f"goes from {name} to itself"
    if not rules.is_station[j] and j in moves[:made]:
        return f"goes to {name}, which was visited before"
    if not rules.is_station[j] and sum(i >= rules.first_target for i in moves[:made]) == (
        rules.most_targets
    ):
        return f"goes to {name}, one more target than the {rules.most_targets} of the chaser"
    kits, most = mission.schedules.kits_for(tuple(moves[: made + 1])), most_kits(rules.loads)
    if rules.loads is not None and kits > most:
        return f"goes to {name}, one more kit than the {most} of the chaser"
    return why_not_flown(mission, moves, made)
