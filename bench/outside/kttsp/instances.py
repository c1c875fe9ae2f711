"""Instances of the planner's own format, over sampled tables of given connections."""

from __future__ import annotations

import numpy as np

from adr_opt.common.constants import DAY_S
from adr_opt.plan.plan import Plan
from adr_opt.problem.bodies import Target
from adr_opt.problem.chasers import Chaser, Tank
from adr_opt.problem.given import of_rows
from adr_opt.problem.instance import Instance
from adr_opt.problem.settings import GivenFile, MissionSettings, Objective, TransferSettings

from .reading import Problem, Tour
from .sampling import Rows

EPOCH = "2026-01-01T00:00:00Z"
"""Nothing depends on it."""


def names_of(problem: Problem) -> tuple[str, ...]:
    """Names of the targets, in the order of their numbers also by the alphabet."""
    return tuple(f"orbit-{number:04d}" for number in range(problem.targets))


def instance_of(problem: Problem, rows: Rows, file: str) -> Instance:
    """The tour as a mission: all targets required, the end as early as possible.

    The chaser is launched onto any target at the begin, and its tank lasts for any tour.

    Parameters
    ----------
    problem : Problem
    rows : Rows
        Given connections.
    file : str
        Name of the file that holds them.
    """
    names = names_of(problem)
    instance = Instance(
        name=f"kttsp-{problem.name}",
        epoch=EPOCH,
        stations=(),
        targets=tuple(Target(name=name, required=True) for name in names),
        chasers=(
            Chaser(
                name="tomato",
                start="anywhere",
                available_s=(problem.begin_d * DAY_S, None),
                tank=Tank(delta_v_m_s=problem.targets * problem.most_exception_m_s),
                max_exceptions=problem.exceptions,
            ),
        ),
        mission=MissionSettings(
            duration_s=problem.longest_d * DAY_S, service_s=0.0, refuel_revolutions=0.0
        ),
        transfer=TransferSettings(given=GivenFile(file=file)),
        objective=Objective(cost="duration"),
    )
    columns = {
        "origin": rows.origin, "destination": rows.destination, "departure_s": rows.departure,
        "arrival_s": rows.arrival, "delta_v_m_s": rows.delta_v, "exception": rows.exception,
    }  # fmt: skip
    return instance.with_given(of_rows(columns, names), file)


def tour_of_plan(problem: Problem, plan: Plan) -> Tour:
    """The tour of a plan of :func:`instance_of`, at its times."""
    number = {name: at for at, name in enumerate(names_of(problem))}
    legs = [leg for leg in plan.legs if leg.kind == "given"]
    departures = np.array([leg.departure_s for leg in legs]) / DAY_S
    arrivals = np.array([leg.arrival_s for leg in legs]) / DAY_S
    order = [number[plan.legs[0].destination], *(number[leg.destination] for leg in legs)]
    return Tour(departures, arrivals - departures, np.array(order, dtype=np.int64))
