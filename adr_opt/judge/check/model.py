"""Whether the costs of a plan are of the model as it is."""

from __future__ import annotations

from collections.abc import Iterator

from ...plan.plan import Plan
from .violation import Violation


def check_model(plan: Plan) -> Iterator[Violation]:
    """Legs that drift have to be planned anew if they were planned as if phase cost nothing."""
    if plan.has_former_drifts:
        yield Violation(
            None,
            "model",
            f"its drift legs are of version {plan.model} of the model, in which phase cost "
            "nothing; plan anew",
        )
