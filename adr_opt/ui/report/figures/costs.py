"""ΔV of every leg: planned, and as the sum of its burns."""

from __future__ import annotations

from typing import Any

from ....plan.plan import Leg, Plan
from ....plan.refined_plan import RefinedPlan
from ...plot.chart import Series
from ...plot.costs import costs_chart, has_burns
from ..text import number
from .parts import Figure, figure, leg_title, said

MOST_TICKS = 20
"""Maximum number of leg numbers below the chart; of more legs, only some are numbered."""


def costs(plan: Plan, refined: RefinedPlan | None = None) -> Figure:
    """Two bars per leg in m/s; one where plans have no burns.

    With the plan refined, a third one is what the leg takes then.
    """
    count = len(plan.legs)

    def more(one: Series) -> dict[str, Any]:
        texts = [
            f"{leg_title(plan, number)}<br>{_words(leg)}"
            for number, leg in enumerate(one.of, start=1)
        ]
        return said("%{text}", texts)

    ticks = {"dtick": 1} if count <= MOST_TICKS else {}
    return figure(
        costs_chart(plan, refined),
        more,
        barmode="group",
        showlegend=has_burns(plan),
        xaxis={"range": [0.4, max(count, 1) + 0.6], **ticks},
        yaxis={"rangemode": "tozero"},
    )


def _words(leg: Leg) -> str:
    if not (leg.traits.has_burns or leg.traits.from_nowhere):
        return f"{leg.kind}, {number(leg.delta_v_m_s)} m/s"
    aside = ""
    if leg.eccentricity_delta_v_m_s > 0.0:
        aside = f", {number(leg.eccentricity_delta_v_m_s)} of them for eccentricity"
    return (
        f"{leg.kind}, planned {number(leg.delta_v_m_s)} m/s{aside}; burns "
        f"{number(leg.burns_delta_v_m_s)} m/s"
    )
