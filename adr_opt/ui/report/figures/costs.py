"""ΔV of every leg: planned, and the sum of its burns."""

from __future__ import annotations

import math

from ....plan.leg_kinds import GIVEN
from ....plan.plan import Leg, Plan
from ....plan.refined_plan import RefinedPlan
from ...plot.costs import BURNED, PLANNED, REFINED
from ..text import number
from .parts import Figure, column, leg_title

MOST_TICKS = 20
"""Where there are more legs, not each has its number below the chart."""


def costs(plan: Plan, refined: RefinedPlan | None = None) -> Figure:
    """Two bars per leg in m/s; one where connections are given, which have no burns.

    With the plan refined, a third one is what the leg takes then.
    """
    is_given = any(leg.kind == GIVEN.name for leg in plan.legs)
    numbers = list(range(1, len(plan.legs) + 1))
    said = [f"{leg_title(plan, at)}<br>{_words(leg)}" for at, leg in enumerate(plan.legs, start=1)]
    traces = [
        {
            "type": "bar", "name": name, "x": numbers, "y": column(values, 2),
            "customdata": numbers, "text": said, "textposition": "none",
            "hovertemplate": "%{text}<extra></extra>",
            "marker": {"color": colour, "line": {"width": 0}},
        }
        for name, values, colour in (
            ("planned", [leg.delta_v_m_s for leg in plan.legs], PLANNED),
            ("burns", None if is_given else [leg.burns_delta_v_m_s for leg in plan.legs], BURNED),
            ("refined", _refined(plan, refined), REFINED),
        )
        if values is not None
    ]  # fmt: skip
    layout = {
        "barmode": "group",
        "showlegend": not is_given,
        "xaxis": {
            "title": {"text": "leg"},
            "range": [0.4, max(numbers, default=1) + 0.6],
            **({"dtick": 1} if len(numbers) <= MOST_TICKS else {}),
        },
        "yaxis": {"title": {"text": "ΔV [m/s]"}, "rangemode": "tozero"},
    }
    return {"data": traces, "layout": layout}


def _refined(plan: Plan, refined: RefinedPlan | None) -> list[float] | None:
    """What the legs take in true dynamics; NaN for those that are missing [m/s]."""
    if refined is None:
        return None
    flown = {leg.leg: leg.flown_delta_v_m_s for leg in refined.legs}
    return [flown.get(at, math.nan) for at in range(1, len(plan.legs) + 1)]


def _words(leg: Leg) -> str:
    if leg.kind == GIVEN.name:
        return f"given, {number(leg.delta_v_m_s)} m/s"
    aside = ""
    if leg.eccentricity_delta_v_m_s > 0.0:
        aside = f", {number(leg.eccentricity_delta_v_m_s)} of them for eccentricity"
    return (
        f"{leg.kind}, planned {number(leg.delta_v_m_s)} m/s{aside}; burns "
        f"{number(leg.burns_delta_v_m_s)} m/s"
    )
