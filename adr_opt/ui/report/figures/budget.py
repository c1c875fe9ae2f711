"""ΔV left against time, with refuellings."""

from __future__ import annotations

from typing import Any

from ....plan.palette import STATION, chaser_colours
from ....plan.plan import Plan
from ....plan.routes import several
from ....problem.instance import Instance
from ...plot.budget import Budget, budgets
from ..text import clock, in_chart
from .parts import Figure, column, days, leg_title, named, time_axis

FILL = "rgba(63,127,196,0.12)"


def budget(instance: Instance, plan: Plan) -> Figure:
    """ΔV left in m/s against days, a step at every burn and at every refuelling; per chaser."""
    colours, lines, marks = chaser_colours(instance), [], []
    for name, course in budgets(instance, plan).items():
        about: dict[str, Any] = {"name": "ΔV left", "fill": "tozeroy", "fillcolor": FILL}
        if several(instance):
            about = {"name": in_chart(name)}
        lines.append(_line(plan, course, colours[name]) | about)
        marks.append((name, course))
    traces = [*lines, _refuellings(instance, plan, marks)]
    layout = {
        "xaxis": time_axis(instance, plan),
        "yaxis": {"title": {"text": "ΔV left [m/s]"}, "rangemode": "tozero"},
        **named(instance, True),
    }
    return {"data": traces, "layout": layout}


def _said(plan: Plan, course: Budget) -> list[str]:
    return [
        f"{'start' if leg == 0 else leg_title(plan, leg)}<br>{clock(time)}"
        for leg, time in zip(course.legs, course.times_s, strict=True)
    ]


def _line(plan: Plan, course: Budget, colour: str) -> dict[str, Any]:
    return {
        "type": "scatter", "mode": "lines",
        "line": {"shape": "hv", "color": colour, "width": 1.8},
        "x": days(course.times_s), "y": column(course.left_m_s, 2),
        "customdata": list(course.legs), "text": _said(plan, course),
        "hovertemplate": "%{text}<br>%{y:.1f} m/s left<extra></extra>",
    }  # fmt: skip


def _refuellings(
    instance: Instance, plan: Plan, courses: list[tuple[str, Budget]]
) -> dict[str, Any]:
    colours = chaser_colours(instance)
    found = [
        (course.times_s[at], course.left_m_s[at], course.legs[at], said, colours[name])
        for name, course in courses
        for at, said in enumerate(_said(plan, course))
        if course.refuelled[at]
    ]
    colour: Any = [each[4] for each in found] if several(instance) else STATION
    return {
        "type": "scatter", "mode": "markers", "name": "refuelling",
        "x": days([each[0] for each in found]), "y": column([each[1] for each in found], 2),
        "customdata": [each[2] for each in found], "text": [each[3] for each in found],
        "marker": {"color": colour, "size": 10, "symbol": "triangle-up"},
        "hovertemplate": "refuelled, %{text}<br>%{y:.1f} m/s left<extra></extra>",
    }  # fmt: skip
