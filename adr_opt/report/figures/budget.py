"""ΔV left against time, with refuellings."""

from __future__ import annotations

from ...instance import Instance
from ...plan import Plan
from ...plot.budget import budget as course_of
from ...plot.palette import COLOURS, STATION
from ..text import clock
from .parts import Figure, column, days, leg_title, time_axis


def budget(instance: Instance, plan: Plan) -> Figure:
    """ΔV left in m/s against days, a step at every burn and at every refuelling."""
    course = course_of(instance, plan)
    said = [
        f"{'start' if leg == 0 else leg_title(plan, leg)}<br>{clock(time)}"
        for leg, time in zip(course.legs, course.times_s, strict=True)
    ]
    refuelled = [index for index, was in enumerate(course.refuelled) if was]
    traces = [
        {
            "type": "scatter", "mode": "lines", "name": "ΔV left", "line": {
                "shape": "hv", "color": COLOURS["phasing"], "width": 1.8},
            "fill": "tozeroy", "fillcolor": "rgba(63,127,196,0.12)",
            "x": days(course.times_s), "y": column(course.left_m_s, 2),
            "customdata": list(course.legs), "text": said,
            "hovertemplate": "%{text}<br>%{y:.1f} m/s left<extra></extra>",
        },
        {
            "type": "scatter", "mode": "markers", "name": "refuelling",
            "x": days([course.times_s[index] for index in refuelled]),
            "y": column([course.left_m_s[index] for index in refuelled], 2),
            "customdata": [course.legs[index] for index in refuelled],
            "text": [said[index] for index in refuelled],
            "marker": {"color": STATION, "size": 10, "symbol": "triangle-up"},
            "hovertemplate": "refuelled, %{text}<br>%{y:.1f} m/s left<extra></extra>",
        },
    ]  # fmt: skip
    layout = {
        "xaxis": time_axis(instance, plan),
        "yaxis": {"title": {"text": "ΔV left [m/s]"}, "rangemode": "tozero"},
    }
    return {"data": traces, "layout": layout}
