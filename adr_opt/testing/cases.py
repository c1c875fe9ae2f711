"""Small missions, by name, on which a planner shows that it follows all their rules."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from ..common.constants import DAY_S
from ..legs.timetable import Timetable
from ..mission.problem import Problem
from ..problem.bodies import Station, Target
from ..problem.chasers import AtStation, Chaser, InOrbit
from ..problem.instance import Instance
from ..run.warm_up import asking_problem, practice_problem
from ..sources.generator import generate

BEGINNING, REPEATED, OVER = "start plan", "same seed, same plan", "time over at once"
"""Cases about how a planner is called, on the mission of :func:`_field`."""


class Case(NamedTuple):
    """A mission to plan.

    Attributes
    ----------
    problem : callable
        Makes it.
    practises : bool
        Whether the planner is stopped as it is when it practises, after some questions.
    has_plan : bool
        Whether there is one, be it that of an empty route.
    """

    problem: Callable[[], Problem]
    practises: bool = False
    has_plan: bool = True


def _field() -> Instance:
    return generate("tiny", 0)


def _with(**changes: object) -> Callable[[], Problem]:
    """The field with some parts replaced."""
    return lambda: Problem(_field().replace(**changes))


def _with_targets(change: Callable[[int, Target], Target]) -> Callable[[], Problem]:
    """The field with some targets changed, by their position in the file."""

    def problem() -> Problem:
        field = _field()
        return Problem(
            field.replace(targets=tuple(change(*each) for each in enumerate(field.targets)))
        )

    return problem


def _with_chaser(change: Callable[[Instance], Chaser]) -> Callable[[], Problem]:
    """The field with another chaser."""

    def problem() -> Problem:
        field = _field()
        return Problem(field.replace(chasers=(change(field),)))

    return problem


def _with_limits(duration_s: float | None = None, delta_v_m_s: float | None = None) -> Problem:
    return Problem(_field().with_limits(duration_s=duration_s, delta_v_m_s=delta_v_m_s))


def _required(delta_v_m_s: float | None = None) -> Problem:
    """The field with a required last target."""
    field = _field()
    *others, last = field.targets
    changed = field.replace(targets=(*others, last.replace(required=True)))
    return Problem(changed.with_limits(delta_v_m_s=delta_v_m_s))


def _without_station() -> Problem:
    """The field with a chaser in its own orbit and without refuelling."""
    field = _field()
    orbit = field.stations[0].orbit
    assert orbit is not None
    chaser = field.chaser.replace(start=InOrbit(orbit=orbit))
    return Problem(field.replace(stations=(), chasers=(chaser,)))


def _two_stations() -> Problem:
    """The field with its last target as a station, where the mission must end."""
    field = _field()
    *targets, last = field.targets
    stations = (*field.stations, Station(name="second", orbit=last.orbit))
    chaser = field.chaser.replace(end=AtStation(station="second"))
    return Problem(field.replace(stations=stations, targets=tuple(targets), chasers=(chaser,)))


def _given() -> Problem:
    """The field with connections from a table with gaps."""
    field = _field()
    bodies = len(field.names)
    origin, destination = np.meshgrid(np.arange(bodies), np.arange(bodies), indexing="ij")
    cost = 40.0 + 10.0 * ((3 * origin + 5 * destination) % 7)
    cost[(origin + destination) % 4 == 3] = math.inf
    duration = np.where(np.isfinite(cost), 5000.0 + 500.0 * abs(origin - destination), math.inf)
    departures = [0.0, 0.4 * DAY_S, 0.8 * DAY_S]
    timetable = Timetable.from_matrices(field, departures, [duration] * 3, [cost] * 3)
    return Problem(timetable.instance)


CASES: dict[str, Case] = {
    "practice mission": Case(practice_problem, practises=True),
    "practice mission with drifting nodes": Case(lambda: practice_problem(True), practises=True),
    "practice mission without a timetable": Case(asking_problem, practises=True),
    "practice campaign": Case(lambda: practice_problem(several=True), practises=True),
    "usual field": Case(_with()),
    "no targets": Case(_with(targets=())),
    "one target": Case(lambda: Problem(_field().replace(targets=_field().targets[:1]))),
    "tank nearly empty": Case(lambda: _with_limits(delta_v_m_s=1.0)),
    "mission of a quarter of an hour": Case(lambda: _with_limits(duration_s=900.0)),
    "targets worth nothing": Case(_with_targets(lambda at, each: each.replace(prize=0.0))),
    "unequal prizes": Case(_with_targets(lambda at, each: each.replace(prize=0.3 * at + 0.1))),
    "two targets in one orbit": Case(
        _with_targets(lambda at, each: each.replace(orbit=_field().targets[at // 2].orbit))
    ),
    "windows": Case(
        _with_targets(
            lambda at, each: each.replace(
                window_s=(0.1 * at * DAY_S, (0.1 * at + 0.6) * DAY_S if at % 2 else None)
            )
        )
    ),
    "required target": Case(_required),
    "required target out of reach": Case(lambda: _required(1.0), has_plan=False),
    "one target at most": Case(_with_chaser(lambda field: field.chaser.replace(max_targets=1))),
    "chaser that comes late": Case(
        _with_chaser(lambda field: field.chaser.replace(available_s=(0.3 * DAY_S, 1.2 * DAY_S)))
    ),
    "end at a station": Case(
        _with_chaser(
            lambda field: field.chaser.replace(end=AtStation(station=field.stations[0].name))
        )
    ),
    "no station": Case(_without_station),
    "two stations": Case(_two_stations),
    "keep-out zones": Case(lambda: Problem(generate("tiny", 0, zones=4))),
    "given connections": Case(_given),
    OVER: Case(_with()),
    BEGINNING: Case(_with()),
    REPEATED: Case(_with()),
}
"""All cases by name."""
