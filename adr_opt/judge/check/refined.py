"""Check of a refined plan."""

from __future__ import annotations

from ...common.errors import InputError
from ...plan.plan import Plan
from ...plan.refined_plan import RefinedPlan
from ...problem.instance import Instance
from .violation import Violation


def check_refined(
    instance: Instance, refined: RefinedPlan, plan: Plan | None
) -> tuple[Violation, ...]:
    """All violations of a refined plan."""
    if not refined.instance.is_of(instance):
        raise InputError("the refined plan belongs to another instance")
    return ()
