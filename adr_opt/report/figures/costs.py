"""ΔV of every leg: planned, and the sum of its burns."""

from __future__ import annotations

from ...plan import Leg, Plan
from ...plot.costs import BURNED, PLANNED
from ..text import number
from .parts import Figure, column, leg_title

MOST_TICKS = 20
"""Where there are more legs, not each has its number below the chart."""


def costs(plan: Plan) -> Figure:
    """Two bars per leg in m/s; one where connections are given, which have no burns."""
    is_given = any(leg.kind == "given" for leg in plan.legs)
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


def _words(leg: Leg) -> str:
    if leg.kind == "given":
        return f"given, {number(leg.delta_v_m_s)} m/s"
    aside = ""
    if leg.eccentricity_delta_v_m_s > 0.0:
        aside = f", {number(leg.eccentricity_delta_v_m_s)} of them for eccentricity"
    return (
        f"{leg.kind}, planned {number(leg.delta_v_m_s)} m/s{aside}; burns "
        f"{number(leg.burns_delta_v_m_s)} m/s"
    )
