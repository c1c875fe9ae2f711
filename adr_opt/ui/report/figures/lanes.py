"""A lane for each chaser with its activities, and one for each station with its visitors."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

from ....plan.palette import chaser_colours
from ....plan.plan import Plan
from ....plan.routes import owners, routes_of, several
from ....problem.instance import Instance
from ...plot.chart import DAYS, Bars, Chart, ChartAxis, Series, days
from ...plot.gantt import phase_bars
from ...plot.segments import segments
from ...plot.traffic import stays
from ..text import clock, in_chart
from .parts import FRAME_PX, Figure, figure, of_bars, period, said, time_axis

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
        height=FRAME_PX + LANE_PX * max(len(chart.y.rows or ()), 3),
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
