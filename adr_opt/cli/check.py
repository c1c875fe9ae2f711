"""``check``: judge a plan, independently of every planner."""

from __future__ import annotations

import click

from ..errors import InputError
from ..wording import counted
from .output import emit, emit_json
from .parameters import instance_argument, json_option, plan_argument


@click.command("check")
@instance_argument
@plan_argument
@json_option
def command(instance_path: str, plan_path: str, as_json: bool) -> int:
    """List all violations of PLAN on INSTANCE.

    Exit status 1: there are some.
    """
    from ..checking import check
    from ..instance import load
    from ..plan import load_plan

    instance, plan = load(instance_path), load_plan(plan_path)
    try:
        violations = check(instance, plan)
    except InputError as error:
        raise InputError(f"{plan_path}: {error}") from None
    if as_json:
        emit_json(
            {
                "instance": instance.name,
                "method": plan.method,
                "objective": plan.objective,
                "legs": len(plan.legs),
                "violations": [violation.to_dict() for violation in violations],
            }
        )
    elif violations:
        for violation in violations:
            emit(f"{plan_path}: {violation}")
    else:
        legs = counted(len(plan.legs), "leg")
        emit(f"{plan_path}: no violations, objective {plan.objective:g}, {legs}")
    return 1 if violations else 0
