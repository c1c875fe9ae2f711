"""The card of rehearsals."""

from __future__ import annotations

from typing import TYPE_CHECKING

from ...common.card import Card
from ...common.wording import counted

if TYPE_CHECKING:
    from ...analysis.rehearse.rehearsals import Rehearsals


def of_rehearsals(made: Rehearsals) -> Card:
    """The card of rehearsals; on a page, with the reasons of losses."""
    told = made.to_dict()
    facts = [counted(len(made.outcomes), "rehearsal"), f"by {made.policy}"]
    if made.outcomes:
        facts.append(f"prize {told['prize']['mean']:.4g} of {made.plan.objective:g} planned")
    losses = tuple((reason, f"{mean:.3g} targets") for reason, mean in told["losses"].items())
    return Card("Rehearsals", f"of {made.instance.name!r}", tuple(facts), losses)
