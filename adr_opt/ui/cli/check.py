"""``check``: judge a plan, independently of all planners."""

from __future__ import annotations

from typing import TYPE_CHECKING

import click

from ...common.wording import counted
from . import take
from .doubts import say_doubts
from .flown import flight_line, flight_of, no_fly_option, was_refined
from .output import emit, emit_json
from .parameters import about, mission_of

if TYPE_CHECKING:
    from ...fly.flight.mean_flight import MeanFlight

VIOLATED, UNASKED = "it has violations", "not requested"
"""Reasons for not flying."""


@click.command("check")
@take.instance
@take.plan
@no_fly_option
@take.as_json
def command(instance_path: str, plan_path: str, no_fly: bool, as_json: bool) -> int:
    """List all violations of PLAN on INSTANCE.

    A plan without violations is flown in mean motion on the true orbits, unless it states that it
    was refined when made; the outcome is printed and does not change the verdict. Exit status 1:
    there are violations.
    """
    from ...fly.flight.off_circles import off_circles
    from ...judge.check.verdict import check

    instance, plan = mission_of(instance_path, plan_path)
    say_doubts(instance)
    with about(plan_path):
        violations = check(instance, plan)
    refined = was_refined(plan)
    flight: MeanFlight | str = VIOLATED if violations else UNASKED
    if refined is None and not violations and not no_fly:
        flight = flight_of(instance, plan)
    if as_json:
        flown = refined if isinstance(flight, str) else flight.record
        emit_json(
            {
                "instance": instance.name,
                "method": plan.method,
                "objective": plan.objective,
                "legs": len(plan.legs),
                "violations": [violation.to_dict() for violation in violations],
                "flown": None if flown is None else flown.to_dict(),
                "not_flown": flight if flown is None else None,
            }
        )
    elif violations:
        for violation in violations:
            emit(f"{plan_path}: {violation}")
    else:
        legs = counted(len(plan.legs), "leg")
        emit(f"{plan_path}: no violations, objective {plan.objective:g}, {legs}")
        if refined is not None:
            emit(f"{plan_path}: according to the plan, {refined}")
        elif not isinstance(flight, str):
            emit(f"{plan_path}: {flight_line(flight)}; it was not refined")
        else:
            emit(f"{plan_path}: neither flown nor refined: {flight}")
        off = None if refined is not None else off_circles(instance, plan)
        if off is not None:
            emit(f"{plan_path}: {off}")
        if plan.flown is not None and plan.own_flight is None:
            emit(f"{plan_path}: the flight that it records is of other legs")
    return 1 if violations else 0
