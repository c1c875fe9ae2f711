"""Whether the plan was flown, refined, or neither: a paragraph of every page."""

from __future__ import annotations

from ...common.errors import InputError
from ...common.wording import counted
from ...fly.flight.mean_flight import fly_mean
from ...judge.admit import Admitted
from ...plan.plan import Plan
from ...plan.refined_plan import RefinedPlan
from .text import escape


def paragraph(admitted: Admitted[Plan], refined: RefinedPlan | None) -> str:
    """Knowledge of the plan beyond the model, from a flight in mean motion.

    Parameters
    ----------
    admitted : Admitted
        The plan, with its instance.
    refined : RefinedPlan or None
        The plan as refined, if the page has it.
    """
    said, holds = _said(admitted, refined)
    kind = "" if holds else " bad"
    return f'<p class="verdict{kind}" id="standing">{escape(said)}.</p>'


def _said(admitted: Admitted[Plan], refined: RefinedPlan | None) -> tuple[str, bool]:
    if refined is not None:
        legs = counted(len(refined.legs), "leg")
        return f"Refined in the field {refined.gravity}: {legs}, as told below", True
    known = admitted.plan.own_flight
    if known is not None and known.how == "refined":
        return f"The plan states, and nobody has judged, that {known}", known.holds
    try:
        flight = fly_mean(admitted.instance, admitted)
    except InputError as error:
        return f"Neither flown nor refined: {error}", True
    assert flight is not None  # it is never interrupted
    told = str(flight)
    return f"{told[:1].upper()}{told[1:]}; not refined", flight.holds
