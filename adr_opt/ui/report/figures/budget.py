"""ΔV left against time, with refuellings."""

from __future__ import annotations

from typing import Any

from ....plan.plan import Plan
from ....plan.routes import several
from ....problem.instance import Instance
from ...plot.budget import budget_chart
from ...plot.chart import Marks, Series
from ..text import clock
from .parts import Figure, figure, leg_title, named, said, time_axis

FILL = "rgba(63,127,196,0.12)"


def budget(instance: Instance, plan: Plan) -> Figure:
    """ΔV left in m/s against days, a step at every burn and at every refuelling; per chaser."""

    def more(one: Series) -> dict[str, Any]:
        texts = [
            f"{leg_title(plan, leg) if leg else 'start'}<br>{clock(time_s)}"
            for leg, time_s in one.of
        ]
        if isinstance(one, Marks):
            return said("refuelled, %{text}<br>%{y:.1f} m/s left", texts)
        area = {} if several(instance) else {"fill": "tozeroy", "fillcolor": FILL}
        return area | said("%{text}<br>%{y:.1f} m/s left", texts)

    return figure(
        budget_chart(instance, plan), more, xaxis=time_axis(instance, plan),
        yaxis={"rangemode": "tozero"}, **named(instance, True),
    )  # fmt: skip
