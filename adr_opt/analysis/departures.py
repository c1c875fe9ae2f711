"""Plans from chosen departures: each leg at its given time, judged by ``check``."""

from __future__ import annotations

import math
import operator
from collections.abc import Iterable, Mapping, Sequence
from copy import copy
from dataclasses import replace
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from ..common.constants import DAY_S, SLACK_S
from ..common.errors import InputError
from ..common.wording import counted
from ..judge.admit import admit
from ..kernels.core.windows import service_ends
from ..legs.connections import Connections
from ..legs.families.family import StatedLeg
from ..mission.certified import certify_routes
from ..mission.mission import Mission
from ..mission.problem import AnyProblem, Problem, problem_of
from ..plan.plan import Plan
from ..run.legal_moves import why_illegal
from ..run.table_budget import candidates

METHOD = "own departures"

NEAR_S = 1.0
"""Tolerance of a time that selects a connection [s]."""

BUILD_S = 20.0
"""Longest time to build a timetable that explains targets left out [s]."""

Body = int | str
ChosenLeg = Body | tuple[Body, float] | tuple[Body, float, float]
"""A body, optionally with a departure time [s] and an arrival time [s]."""

ChosenLegs = Iterable[ChosenLeg] | Iterable[Iterable[ChosenLeg]] | Mapping[str, Iterable[ChosenLeg]]


class _Leg(NamedTuple):
    body: int
    departure_s: float | None
    arrival_s: float | None


def plan_of(instance: AnyProblem, legs: ChosenLegs, *, method: str = METHOD) -> Plan:
    """Make a plan of chosen departures, and judge it by :func:`adr_opt.check`.

    Burns, services, refuelling, tows, tanks and the reasons for targets left out follow from the
    departures.

    Parameters
    ----------
    instance : Instance, path, dict, Mission or Problem
    legs : sequence of legs
        Of an only chaser; of several a mapping from their names, or a sequence of such sequences in
        the order of the file. A leg is one of

        - ``(body, departure)``: leave for a body, by name or by number, with a connection that
          departs then, to a second [s after the epoch]; a launch may be at any time from its first;
        - ``(body, departure, arrival)``: the connection that arrives then, to a second, and departs
          no earlier: what :meth:`.Timetable.lookup` tells for a time when the chaser is ready, or a
          row of :meth:`.Timetable.connections`;
        - ``body``: any connection.

        The departure of a launch is also its arrival, and may be later than the first possible one.
        Whatever legs leave open is scheduled at least cost, as for an order of bodies.
        Stations are for refuelling. The chaser waits until a leg departs. A refuelling that nothing
        follows is left out, as in all plans, and a way back is added where the mission has to end
        at a station and no leg leads there.
    method : str
        Method stated in the plan.

    Returns
    -------
    Plan
        :func:`adr_opt.check` finds nothing.

    Raises
    ------
    InputError
        No connection departs then, or a leg or the plan breaks a rule; the sentence says which.
    """
    problem = problem_of(instance)
    routes = [
        [_leg_of(mission, leg) for leg in route]
        for mission, route in zip(problem.missions, _routes(problem, legs), strict=True)
    ]
    _build(problem, [leg.body for route in routes for leg in route])
    flown = copy(problem)
    flown.missions = tuple(
        _pinned(mission, route, "" if len(routes) == 1 else f"{mission.chaser.name!r}: ")
        for mission, route in zip(problem.missions, routes, strict=True)
    )
    moves = [[leg.body for leg in route] for route in routes]
    result = certify_routes(flown, method, moves, seed=0, runtime_s=0.0)
    plan = result.plan
    if plan is None:
        said = result.notes[-1] if result.notes else "the mission has to end at a station"
        raise InputError(f"the departures do not form a plan: {said}")
    admitted = admit(problem.instance, plan, unjudged=True)
    if not admitted.holds:
        raise InputError(f"the departures do not form a plan: {admitted.violations[0]}")
    return admitted.plan


def _routes(problem: Problem, legs: Any) -> list[list[Any]]:
    """Legs of each chaser, in the order of the file.

    Raises
    ------
    InputError
        A chaser is unknown, or there are more routes than chasers.
    """
    names = [mission.chaser.name for mission in problem.missions]
    if isinstance(legs, Mapping):
        unknown = [name for name in legs if name not in names]
        if unknown:
            raise InputError(
                f"legs: {unknown[0]!r} is not a chaser of {problem.instance.name!r}, which has "
                f"{', '.join(map(repr, names))}"
            )
        return [list(legs.get(name, ())) for name in names]
    given = list(legs) if not isinstance(legs, str) else [legs]
    if len(names) == 1:
        return [given]
    if len(given) > len(names) or any(isinstance(route, (str, int, tuple)) for route in given):
        raise InputError(
            f"legs: must be a list of legs for each of {counted(len(names), 'chaser')}, or say the "
            "chaser of each by name"
        )
    return [list(route) for route in given] + [[] for _ in names[len(given) :]]


def _leg_of(mission: Mission, given: Any) -> _Leg:
    """A given leg with the number of its body.

    Raises
    ------
    InputError
        It is no such leg.
    """
    parts: Sequence[Any] = (given,) if isinstance(given, (str, int, np.integer)) else given
    try:
        body, *times = parts
        body = body if isinstance(body, str) else operator.index(body)
        seconds = [float(time) for time in times]
    except (TypeError, ValueError):
        seconds = [math.nan]
    if len(seconds) > 2 or not all(math.isfinite(time) and time >= 0.0 for time in seconds):
        raise InputError(
            f"leg {given!r}: give (body, departure) or (body, departure, arrival), times in "
            "seconds after the epoch, or the body alone"
        )
    departure, arrival, *_ = (*seconds, None, None)
    return _Leg(int(mission.numbers([body])[0]), departure, arrival)


def _build(problem: Problem, bodies: list[int]) -> None:
    """Ensure that there is a timetable, with the bodies of the legs first."""
    names = [problem.names[body] for body in bodies]
    candidates(
        problem,
        BUILD_S,
        first=list(dict.fromkeys(names)),
        interrupted=lambda: False,
        building=lambda share: None,
        on_demand=True,
    )


def _pinned(mission: Mission, route: list[_Leg], whose: str) -> Mission:
    """The mission of a chaser restricted to the connections that the legs allow.

    Raises
    ------
    InputError
        No connection is meant, or the chaser cannot take any.
    """
    pins: dict[tuple[int, int], Connections] = {}
    usual = mission.schedules.connections
    moves = [leg.body for leg in route]
    mission.rules  # noqa: B018  one timetable for both
    made = copy(mission)
    # Reasons of targets that are left out ask for all connections.
    made.__dict__["over_all"] = mission.schedules
    made.__dict__["schedules"] = mission.schedules.over(
        lambda i, j: pins[i, j] if (i, j) in pins else usual(i, j)
    )
    for at, leg in enumerate(route):
        i, said = moves[at - 1] if at else mission.rules.start, f"{whose}leg {at + 1}"
        beginning = tuple(moves[: at + 1])
        if mission.in_order(beginning) <= at:
            raise InputError(f"{said} {why_illegal(made, moves[: at + 1], at)}")
        pins[i, leg.body] = _meant(mission, i, leg, said)
        if made.time(beginning).made <= at:
            raise InputError(f"{said}, to {mission.names[leg.body]!r}, {_why_not(made, beginning)}")
    return made


def _why_not(mission: Mission, moves: tuple[int, ...]) -> str:
    """Reason why a chaser cannot fly any connection of the last leg, while those before it hold."""
    rules, j = mission.rules, moves[-1]
    body = moves[-2] if len(moves) > 1 else rules.start
    found = mission.schedules.connections(body, j)
    here = mission.schedules.fronts(moves[:-1], mission.schedules.kits_for(moves))[-1]
    ready = float(here.ready.min())
    there = found.departure >= ready - SLACK_S
    if not there.any():
        return (
            f"departs at {found.departure.max():.10g} s, but the chaser is free at {ready:.10g} s "
            "only"
        )
    service, closing = float(rules.service[j]), float(rules.windows.closing[j])
    open_end = rules.windows.later(j, math.inf)
    begin = float(service_ends(open_end, j, found.arrival[there]).min())
    end = begin + service
    if begin > closing:
        return (
            f"ends at {end:.10g} s at the earliest, service included, after its window, the "
            f"mission or the chaser's time, which end at {closing + service:.10g} s"
        )
    spent = mission.connecting.spent_m_s(body)
    cost, left = float(found.delta_v[there].min()) - spent, float(here.left.max()) - spent
    if cost > left:
        return f"needs {cost:.6g} m/s, but only {left:.6g} m/s are left"
    return (
        f"has no connection that is in time and takes no more than the {left:.6g} m/s that are left"
    )


def _meant(mission: Mission, i: int, leg: _Leg, said: str) -> Connections:
    """Connections selected by a leg: those of the pair that fit its times.

    Raises
    ------
    InputError
        There is none.
    """
    j, connecting = leg.body, mission.connecting
    for resolution in dict.fromkeys((connecting.planning_resolution_m_s, 0.0)):
        found = connecting.of_pair(i, j, resolution)
        if leg.departure_s is None:
            return found
        if found.departure.size and i in mission.instance.launches:
            return _launched(found, leg, said)
        fits = found.departure <= leg.departure_s + NEAR_S
        if leg.arrival_s is None:
            leaves = _leaves(mission, i, j, found, fits)
            fits = np.abs(found.departure - leg.departure_s) <= NEAR_S
            fits |= np.abs(leaves - leg.departure_s) <= NEAR_S
        else:
            fits = np.abs(found.arrival - leg.arrival_s) <= NEAR_S
            fits &= _leaves(mission, i, j, found, fits) >= leg.departure_s - NEAR_S
        if fits.any():
            return found.at(fits)
    raise InputError(f"{said}, {_nothing_there(mission, i, leg, found)}")


def _launched(found: Connections, leg: _Leg, said: str) -> Connections:
    """The launch at the stated time, which is its end as well.

    Planners launch as soon as the chaser is there, since to be early is no loss; a later launch is
    as good as its rules.

    Raises
    ------
    InputError
        It is before that time, or arrives at another one.
    """
    opens_s, time_s = float(found.departure.min()), leg.departure_s
    assert time_s is not None
    if time_s < opens_s - NEAR_S:
        raise InputError(f"{said} launches at {time_s:.10g} s, but may not before {opens_s:.10g} s")
    if leg.arrival_s is not None and abs(leg.arrival_s - time_s) > NEAR_S:
        raise InputError(
            f"{said} launches at {time_s:.10g} s and arrives at {leg.arrival_s:.10g} s; a launch "
            "takes no time"
        )
    when = np.array([max(time_s, opens_s)])
    return replace(found.at(np.arange(1)), departure=when, arrival=when)


LATEST_S = 0.25 * DAY_S
"""Largest delay of the first burn after the event at which a connection departs [s]."""


def _leaves(
    mission: Mission, i: int, j: int, found: Connections, in_question: npt.NDArray[np.bool_]
) -> npt.NDArray[np.float64]:
    """Departures of selected connections as stated in plans [s].

    Where nodes drift, events are those of a grid, and the first burn of a short transfer follows.
    """
    leaves = found.departure.copy()
    if mission.connecting.times is None or not in_question.any():
        return leaves
    latest = found.departure[in_question].max()
    for row in np.flatnonzero(in_question & (found.departure >= latest - LATEST_S)):
        stated = StatedLeg(found.departure[row], found.arrival[row], int(found.revolutions[row]))
        flown = mission.connecting.flown(i, j, int(found.family[row]), stated)
        leaves[row] = flown.departure
    return leaves


def _nothing_there(mission: Mission, i: int, leg: _Leg, found: Connections) -> str:
    """The message for a leg that selects no connection, with a near one."""
    way = f"from {mission.names[i]!r} to {mission.names[leg.body]!r}"
    assert leg.departure_s is not None
    if not found.departure.size:
        return f"{way}: no connection exists"
    what, times, wanted = "departs", found.departure, leg.departure_s
    then = f"at {wanted:.10g} s"
    if leg.arrival_s is not None:
        what, times, wanted = "arrives", found.arrival, leg.arrival_s
        then = f"at {wanted:.10g} s and departs at {leg.departure_s:.10g} s or later"
    nearest = float(times[np.argmin(np.abs(times - wanted))])
    return f"{way}: no connection {what} {then}; the nearest one {what} at {nearest:.10g} s"
