"""Charts over time: altitude, remaining ΔV, mass, nodes, and the timeline."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np

from ....plan.plan import Plan
from ....plan.routes import several
from ....problem.instance import Instance
from ...plot.budget import budget_chart
from ...plot.chart import Box, Marks, Series
from ...plot.gantt import gantt_chart
from ...plot.heights import altitude_chart, zones
from ...plot.mass import mass_chart
from ...plot.nodes import nodes_chart
from ...plot.strands import DrawnArc
from ..text import clock, in_chart, number
from .parts import (
    FRAME_PX,
    Figure,
    figure,
    leg_title,
    named,
    of_arcs,
    of_bars,
    period,
    said,
    time_axis,
)

FILL = "rgba(63,127,196,0.12)"
LEAST_ROOM_DEG = 0.05
ROW_PX = 19


def altitude(instance: Instance, plan: Plan, tracks: tuple[DrawnArc, ...]) -> Figure:
    """Altitude of the chaser in km against days, one trace per phase; zones as boxes beneath.

    Where there are several chasers, each has traces and a colour of its own.
    """

    def more(one: Series) -> dict[str, Any]:
        if not isinstance(one, Box):
            return of_arcs(one, "<br>%{y:.1f} km at day %{x:.3f}")
        (zone,), (low, high) = one.of, one.y
        text = f"keep-out zone {number(low)}–{number(high)} km<br>"
        return named(instance, False) | said(text + period(zone.start_s, zone.end_s))

    chart = altitude_chart(instance, plan, tracks, by_chaser=True)
    chart = replace(chart, series=(*chart.series, *zones(instance)))
    return figure(chart, more, xaxis=time_axis(instance, plan), **named(instance, True))


def budget(instance: Instance, plan: Plan) -> Figure:
    """Remaining ΔV in m/s against days, with steps at burns and refuellings, per chaser."""

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
        budget_chart(instance, plan),
        more,
        xaxis=time_axis(instance, plan),
        yaxis={"rangemode": "tozero"},
        **named(instance, True),
    )


def mass(instance: Instance, plan: Plan) -> Figure:
    """Mass in kg against days, per chaser."""

    def more(one: Series) -> dict[str, Any]:
        texts = [f"{leg_title(plan, leg)}<br>{clock(time_s)}" for leg, time_s in one.of]
        return said("%{text}<br>%{y:.1f} kg", texts)

    return figure(
        mass_chart(instance, plan), more, xaxis=time_axis(instance, plan), **named(instance, True)
    )


def nodes(instance: Instance, plan: Plan, tracks: tuple[DrawnArc, ...]) -> Figure:
    """RAAN in degrees against days, relative to the common drift; bodies thin, chaser thick."""

    def more(one: Series) -> dict[str, Any]:
        if not one.of:
            return of_arcs(one, "<br>%{y:.2f}° at day %{x:.2f}")
        names = [in_chart(name) for name in one.of]
        return {"opacity": 0.75} | said("%{text}<br>%{y:.2f}° at day %{x:.2f}", names)

    chart = nodes_chart(instance, plan, tracks, by_chaser=True)
    return figure(
        chart,
        more,
        xaxis=time_axis(instance, plan),
        yaxis=_range(chart.series),
        **named(instance, True),
    )


def _range(lines: tuple[Series, ...]) -> dict[str, Any]:
    """Range of the chaser and the bodies it visits, with other bodies nearby."""
    near = np.concatenate([np.empty(0), *(one.y for one in lines if one.name != "not visited")])
    near = np.round(near[~np.isnan(near)], 4)
    if not near.size:
        return {}
    low, high = float(near.min()), float(near.max())
    room = max(0.08 * (high - low), LEAST_ROOM_DEG)
    return {"range": [round(low - room, 4), round(high + room, 4)]}


def gantt(instance: Instance, plan: Plan) -> Figure:
    """One row per leg, first on top, with a bar for each of its phases.

    Where there are several chasers, the legs of each come below a row with its name.
    """
    chart = gantt_chart(instance, plan, headed=True)
    return figure(
        chart,
        lambda bars: of_bars(plan, bars),
        xaxis=time_axis(instance, plan),
        height=FRAME_PX + ROW_PX * max(len(chart.y.rows or ()), 4),
        barmode="overlay",
    )
