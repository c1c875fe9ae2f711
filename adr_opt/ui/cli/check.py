"""``check``: judge a plan, independently of all planners."""

from __future__ import annotations

from typing import TYPE_CHECKING

import click

from ...common.errors import InputError
from ...common.wording import counted
from . import param
from .flown import flight_line, flight_of, no_fly_option, was_refined
from .output import emit, emit_json, say_doubts
from .parameters import about, admitted_plan

if TYPE_CHECKING:
    from ...fly.flight.mean_flight import MeanFlight

VIOLATED, UNASKED = "it has violations", "not requested"
"""Reasons why a plan was not flown."""


@click.command("check")
@param.instance
@param.plan
@param.file("--refined-from", "For a refined PLAN: the plan that it refines.", name="planned_path")
@no_fly_option
@param.as_json
def command(
    instance_path: str, plan_path: str, planned_path: str | None, no_fly: bool, as_json: bool
) -> int:
    """List all violations of PLAN on INSTANCE.

    A plan without violations is flown in mean motion on the true orbits, unless it states that it
    was refined when made; the outcome is printed and does not change the verdict. The states,
    burns and arcs of a refined plan are judged by a separate propagation. Exit status 1: there
    are violations.
    """
    from ...fly.flight.flyable import off_circles
    from ...plan.refined_plan import is_refined

    if is_refined(plan_path):
        return _of_refined(instance_path, plan_path, planned_path, as_json)
    if planned_path is not None:
        raise InputError(f"--refined-from: {plan_path} is not a refined plan; leave it out")
    admitted = admitted_plan(instance_path, plan_path, unjudged=True)
    instance, plan, violations = admitted.instance, admitted.plan, admitted.violations
    say_doubts(instance)
    refined = was_refined(plan)
    flight: MeanFlight | str = VIOLATED if violations else UNASKED
    if refined is None and not violations and not no_fly:
        flight = flight_of(admitted)
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
            emit(f"{plan_path}: unjudged: according to the plan, {refined}")
        elif not isinstance(flight, str):
            emit(f"{plan_path}: {flight_line(flight)}; it was not refined")
        else:
            emit(f"{plan_path}: neither flown nor refined: {flight}")
        off = None if refined is not None else off_circles(instance, plan)
        if off is not None:
            emit(f"{plan_path}: {off}")
        if plan.flown is not None and plan.own_flight is None:
            emit(f"{plan_path}: the flight that it records has other legs")
    return 1 if violations else 0


def _of_refined(
    instance_path: str, refined_path: str, planned_path: str | None, as_json: bool
) -> int:
    """Judge a refined plan, against the plan that it was made of if that is given."""
    from ...judge.admit import admit
    from ...plan.plan import Plan
    from ...plan.refined_plan import RefinedPlan
    from ...problem.instance import load

    instance, refined = load(instance_path), RefinedPlan.load(refined_path)
    planned = None if planned_path is None else Plan.load(planned_path)
    with about(refined_path):
        found = admit(instance, refined, unjudged=True, refined_from=planned).violations
    legs = counted(len(refined.legs), "leg")
    if as_json:
        emit_json(
            {
                "instance": instance.name,
                "legs": len(refined.legs),
                "gravity": refined.gravity,
                "violations": [violation.to_dict() for violation in found],
                "missing": [missing.model_dump(mode="json") for missing in refined.missing],
            }
        )
    elif found:
        for violation in found:
            emit(f"{refined_path}: {violation}")
    else:
        emit(f"{refined_path}: no violations, refined, {legs}")
    for missing in () if as_json else refined.missing:
        emit(f"{refined_path}: leg {missing.leg} is missing: {missing.reason}")
    return 1 if found or refined.missing else 0
