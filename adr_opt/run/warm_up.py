"""Practice missions: a method that has run on them has compiled its kernels."""

from __future__ import annotations

from datetime import UTC, datetime
from functools import cache
from itertools import cycle, permutations
from typing import NamedTuple

import numpy as np

from ..common.constants import DAY_S
from ..common.stop import MaxRuntime
from ..legs.nearest_pairs import neighbours
from ..mission.mission import Mission
from ..mission.problem import Problem, problem_of
from ..problem.bodies import Station, Target
from ..problem.chasers import AtStation, Chaser, Expense, Tank
from ..problem.given import only
from ..problem.given_functions import of_breakpoints
from ..problem.instance import Instance
from ..problem.settings import GivenFile, MissionSettings, Objective, TransferSettings
from ..problem.transfer_sizes import transfers_for
from ..sources.generator import generate

PRIZES = (1.0, 1.1, 1.2)
"""Prizes of practice missions, unequal so that no method ends at once."""

SPAN_S = 100.0
"""Duration of missions with functions of time [s]."""


def electric_instance(several: bool) -> Instance:
    """Two years of one chaser with low thrust or two, some of whose targets are towed."""
    field = generate("electric", 0, targets=12, chasers=2 if several else 1)
    # Of one kind, or hardly any pair would have a leg.
    lighter = [target for target in field.targets if (target.mass_kg or 0.0) < 2000.0]
    return field.replace(
        targets=tuple(
            target.replace(prize=prize, removal=removal)
            for target, prize, removal in zip(
                lighter, cycle(PRIZES), cycle(("tow", "visit")), strict=False
            )
        ),
        mission=field.mission.replace(duration_s=730.0 * DAY_S),
        transfer=field.transfer.replace(drift_step_s=40.0 * DAY_S, max_drift_s=200.0 * DAY_S),
    )


def timed_instance(required: bool) -> Instance:
    """A van whose roads take longer at noon, with all targets required or none."""
    names = ["depot", *(f"target-{number}" for number in range(5))]
    pairs = []
    for at, (i, j) in enumerate(permutations(names, 2)):
        least = 3.0 + at % 7
        departures = np.array([0.0, 0.4 * SPAN_S, 0.9 * SPAN_S])
        arrivals = departures + least + np.array([0.0, 4.0, 1.0])
        pairs.append((i, j, np.column_stack([departures, arrivals]), 0.0 if required else 1.0))
    targets = tuple(
        Target(name=name, prize=prize, required=required)
        for name, prize in zip(names[1:], cycle(PRIZES), strict=False)
    )
    made = Instance(
        name="practice",
        epoch=datetime(2026, 1, 1, tzinfo=UTC),
        stations=(Station(name=names[0]),),
        targets=targets,
        chasers=(
            Chaser(name="van", start=AtStation(station=names[0]), tank=Tank(delta_v_m_s=4.0)),
        ),
        mission=MissionSettings(duration_s=SPAN_S, service_s=2.0, refuel_revolutions=0.0),
        objective=Objective(cost="duration" if required else "delta-v"),
        transfer=TransferSettings(given=GivenFile(functions="practice.json")),
    )
    return made.with_given(only(of_breakpoints(pairs, names)))


LONGEST_S = 10.0
"""Time limit for methods that query only the time, compilation excluded [s]."""


class PracticeKind(NamedTuple):
    """Kind of a practice mission.

    Attributes
    ----------
    starts : bool
        Whether there is a plan to begin from.
    drifts : bool
        Whether nodes drift.
    several : bool
        Whether there are several chasers, or rules that count for all of them.
    asks : bool
        Whether rows of the timetable are worked out on demand.
    tours : bool
        Whether it is a tour through time.
    thrusts : bool
        Whether chasers have low thrust.
    timed : bool
        Whether arrivals are functions of time.
    """

    starts: bool = False
    drifts: bool = False
    several: bool = False
    asks: bool = False
    tours: bool = False
    thrusts: bool = False
    timed: bool = False

    def problem(self) -> Problem:
        """The practice mission."""
        if self.thrusts:
            return thrusting_problem(self.several)
        if self.timed:
            return timed_problem(self.tours)
        if self.tours:
            return tour_problem()
        if self.asks:
            return asking_problem(self.several)
        return practice_problem(self.drifts, self.several)


USUAL = PracticeKind()
"""One chaser, without a start plan."""


@cache
def practice_mission(drifts: bool = False) -> Mission:
    """A small field with zones and unequal prizes, on which no method ends at once.

    Parameters
    ----------
    drifts : bool
        Whether nodes drift, and the chaser may wait for it.
    """
    field = _drifting() if drifts else generate("reduced-time", 0, targets=16, zones=2)
    prizes = cycle(PRIZES)
    return Mission(
        field.replace(
            targets=tuple(
                target.replace(prize=prize)
                for target, prize in zip(field.targets, prizes, strict=False)
            )
        )
    )


@cache
def asking_problem(several: bool = False) -> Problem:
    """The practice field, with rows of its timetables computed on demand."""
    problem = Problem(practice_problem(several=several).instance)
    problem.ask(neighbours(problem.instance, len(problem.names)))
    return problem


@cache
def practice_problem(drifts: bool = False, several: bool = False) -> Problem:
    """The practice field as a problem, with one chaser or two of different kinds."""
    mission = practice_mission(drifts)
    if not several:
        return problem_of(mission)
    field = mission.instance
    second = field.chaser.replace(name=f"{field.chaser.name}-2", max_targets=8)
    return Problem(field.replace(chasers=(field.chaser, second)))


@cache
def thrusting_problem(several: bool = False) -> Problem:
    """A mission of low thrust, with one chaser or two."""
    return Problem(electric_instance(several))


@cache
def timed_problem(required: bool = False) -> Problem:
    """A mission whose arrivals are functions of time; with all targets required or with none."""
    return Problem(timed_instance(required))


@cache
def tour_problem() -> Problem:
    """A campaign of launches in sequence with all targets required, without a timetable."""
    field = generate("removal", 0, targets=5)
    rest_s, leg_s, service_s = 5.0 * DAY_S, 60.0 * DAY_S, 5.0 * DAY_S
    mission = field.mission.replace(
        duration_s=400.0 * DAY_S,
        service_revolutions=None,
        service_s=service_s,
        launch_separation_s=None,
        mission_separation_s=rest_s,
    )
    priced = field.chasers[0].replace(
        available_s=(0.0, None), kits=None, expense=Expense(fixed=1.0, per_kg_squared=1e-6)
    )
    problem = Problem(
        field.replace(
            targets=tuple(target.replace(required=True, removal="kit") for target in field.targets),
            chasers=tuple(priced.replace(name=f"chaser-{number}") for number in range(3)),
            mission=mission,
            transfer=field.transfer.replace(
                max_drift_s=leg_s - service_s, drift_step_s=5.0 * DAY_S, max_leg_s=leg_s
            ),
            objective=Objective(cost="expense"),
        )
    )
    problem.do_without()
    return problem


def _drifting() -> Instance:
    """A mission of some weeks among drifting nodes."""
    days = 40.0
    field = generate("sso", 0, targets=6).with_limits(duration_s=days * DAY_S)
    # Coarse, so that models with a variable for each connection are made in a moment.
    return field.replace(
        transfer=transfers_for(
            days * DAY_S, drift_step_s=8.0 * DAY_S, departure_spacing_s=5.0 * DAY_S
        )
    )


class PracticeStop:
    """Stop of a practice run, after some rounds.

    Parameters
    ----------
    rounds : int
        Of :class:`.method_spec.Practice`.
    """

    def __init__(self, rounds: int) -> None:
        self._left = rounds
        self._limit = MaxRuntime(LONGEST_S)

    def __call__(self, incumbent: float, bound: float) -> bool:
        """Whether to stop."""
        self._left -= 1
        return self._left < 0 or self._limit(incumbent, bound)

    def remaining_s(self) -> float:
        """Remaining time [s]."""
        return self._limit.remaining_s()
