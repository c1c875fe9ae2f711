"""Figures over time, with lanes of chasers and stations, and the costs of legs."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np

from ....plan.palette import chaser_colours
from ....plan.plan import Leg, Plan
from ....plan.refined_plan import RefinedPlan
from ....plan.routes import owners, routes_of, several
from ....problem.instance import Instance
from ...plot.budget import budget_chart, costs_chart, has_burns, mass_chart
from ...plot.chart import DAYS, Bars, Box, Chart, ChartAxis, Marks, Series, days
from ...plot.courses import altitude_chart, zones
from ...plot.gantt import gantt_chart, phase_bars, segments
from ...plot.nodes import nodes_chart
from ...plot.strands import DrawnArc
from ...plot.traffic import stays
from ..text import clock, in_chart, number
from .plotly_traces import (
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


LANE_PX = 30


def lanes(instance: Instance, plan: Plan) -> Figure:
    """Chasers at the top, with bars coloured by phase; then stations, coloured by chaser."""

    def more(one: Series) -> dict[str, Any]:
        if one.phase is not None:
            return of_bars(plan, one)
        texts = [
            f"{in_chart(one.name)} at {in_chart(stay.station)}<br>"
            f"{period(stay.since_s, stay.until_s)}"
            + ("" if stay.refuelled_s is None else f"<br>refuelled at {clock(stay.refuelled_s)}")
            for stay in one.of
        ]
        return said("%{text}", texts)

    chart = _chart(instance, plan)
    return figure(
        chart,
        more,
        xaxis=time_axis(instance, plan),
        showlegend=several(instance),
        height=FRAME_PX + LANE_PX * max(len(chart.y.rows or ()), 2),
        barmode="overlay",
    )


def _chart(instance: Instance, plan: Plan) -> Chart:
    """Simultaneous stays share the lane of a station, so that none hides another."""
    whose = owners(instance, plan)
    crew = [flown.chaser.name for flown in routes_of(instance, plan)]
    names = (*crew, *instance.station_names)
    lane = {name: at for at, name in enumerate(names, start=1)}
    phases = phase_bars(segments(instance, plan), lambda leg: lane[whose.get(leg, crew[0])])
    bars = [replace(one, in_legend=False) for one in phases]
    every = stays(instance, plan)
    for at, (name, colour) in enumerate(chaser_colours(instance).items()):
        mine = [stay for stay in every if stay.chaser == name and stay.until_s > stay.since_s]
        each = Bars.share / len(crew)
        beside = each * (at + 0.5) - Bars.share / 2.0
        if mine:
            bars.append(
                Bars(
                    name=name,
                    colour=colour,
                    share=each,
                    of=mine,
                    legs=[stay.leg for stay in mine],
                    x=days([stay.since_s for stay in mine]),
                    y=[lane[stay.station] + beside for stay in mine],
                    lengths=days([stay.until_s - stay.since_s for stay in mine]),
                )
            )
    return Chart(tuple(bars), DAYS, ChartAxis("", rows=names))
