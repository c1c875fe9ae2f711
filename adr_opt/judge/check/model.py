"""Check of the model version that a plan's costs are based on."""

from __future__ import annotations

from collections.abc import Iterator

from ...plan.plan import Plan
from .violation import Violation


def check_model(plan: Plan) -> Iterator[Violation]:
    """Refuse drift legs that were planned by the former model, without a cost of phasing."""
    if plan.has_former_drifts:
        yield Violation(
            None,
            "model",
            f"its drift legs are of version {plan.model} of the model, in which phasing "
            "was free; plan anew",
        )
