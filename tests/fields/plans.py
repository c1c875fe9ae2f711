"""Plans made of other plans, for tests."""

from __future__ import annotations

import math
from collections.abc import Iterable
from pathlib import Path
from typing import Any

import adr_opt
from adr_opt.judge.admit import Admitted, What, admit
from adr_opt.plan.plan import InstanceReference, Leg, Plan, Route
from adr_opt.plan.refined_plan import RefinedPlan
from adr_opt.problem.instance import Instance


def with_legs(plan: Plan, legs: Iterable[Leg], **changes: Any) -> Plan:
    """The plan of one chaser with other legs and what these cost, and more fields changed.

    The chaser may fly from the beginning, and a second costs what it does in the plan.
    """
    legs = tuple(legs)
    last_s = plan.legs[-1].done_s if plan.legs else math.inf
    paid = (plan.cost - plan.delta_v_m_s) / last_s * (legs[-1].done_s if legs else 0.0)
    chaser = plan.routes[0].chaser if plan.routes else "chaser"
    stated = {
        "routes": (Route(chaser=chaser, legs=legs),),
        "cost": float(sum(leg.delta_v_m_s for leg in legs)) + paid,
    }
    return plan.replace(**(stated | changes))


def solved(instance: Instance) -> Plan:
    """A quick plan."""
    plan = adr_opt.solve(instance, "greedy-guarded").plan
    assert plan is not None
    return plan


def write(instance: Instance, plan: Plan) -> None:
    """Write both where the command line runs."""
    Path("my.json").write_text(instance.to_json(), encoding="utf-8")
    plan.save("plan.json")


def unjudged(instance: Instance, plan: What) -> Admitted[What]:
    """A plan, or a refined one, let in with its violations."""
    return admit(instance, plan, unjudged=True)


def moved_to(instance: Instance, refined: RefinedPlan) -> RefinedPlan:
    """A refined plan, and the plan that it holds, as if they were of another instance."""
    reference = InstanceReference(name=instance.name, sha256=instance.sha256)
    assert refined.planned is not None
    moved = refined.made_of(refined.planned.replace(instance=reference))
    return moved.replace(instance=reference)
