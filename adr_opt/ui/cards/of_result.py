"""The card of the result of a planner or a bound."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

from ...common.card import Card, order_words
from ...common.wording import counted
from .of_plan import details_of, legs_table

if TYPE_CHECKING:
    from ...mission.result import Result


def of_result(result: Result) -> Card:
    """The card of a result: prize, proof, and the order by names."""
    plan, bounded = result.plan, math.isfinite(result.upper_bound)
    facts = []
    if plan is not None:
        facts.append(f"prize {result.objective:g}")
    if bounded:
        facts.append(f"at most {result.upper_bound:g}")
    facts.append(result.status)
    if plan is not None:
        facts += [counted(len(plan.legs), "leg"), f"{plan.delta_v_m_s:,.1f} m/s"]
    facts.append(f"{result.runtime_s:.3g} s")
    if plan is not None and len(plan.routes) == 1 and plan.destinations:
        facts.append(order_words(plan.destinations))
    said = f"of {result.method!r}"
    if plan is None:
        return Card("Result", said, tuple(facts), tuple(("note", each) for each in result.notes))
    said += f" on {plan.instance.name!r}"
    details = [each for each in details_of(plan) if each[0] != "note"]
    details += [("note", note) for note in result.notes]
    details += [(name, f"{count:g}") for name, count in result.counters.items()]
    return Card("Result", said, tuple(facts), tuple(details), (legs_table(plan.routes),))
