"""A lane for each chaser with what it does, and one for each station with who is there."""

from __future__ import annotations

from typing import Any

from ....common.wording import shortened
from ....plan.palette import COLOURS, LABELS, PHASES, chaser_colours
from ....plan.plan import Plan
from ....plan.routes import owners, routes_of, several
from ....problem.instance import Instance
from ...plot.segments import Segment, segments
from ...plot.traffic import Stay, stays
from ..text import clock, in_chart, lasting
from .parts import FRAME_PX, LONGEST_TICK, Figure, days, leg_title, period, time_axis

LANE_PX = 30
SHARED = 0.72
"""Of a lane, taken by bars; chasers that are at a station share its lane."""


def lanes(instance: Instance, plan: Plan) -> Figure:
    """Chasers from the top, their bars coloured by phase; then stations, coloured by chaser."""
    whose = owners(instance, plan)
    crew = [flown.chaser.name for flown in routes_of(instance, plan)]
    lane = {name: at for at, name in enumerate([*crew, *instance.station_names], start=1)}
    found = segments(instance, plan)
    traces = []
    for phase in PHASES:
        bars = [bar for bar in found if bar.phase == phase]
        if bars:
            rows = [lane[whose.get(bar.leg, crew[0])] for bar in bars]
            traces.append(_phase(plan, phase, bars, rows))
    every = stays(instance, plan)
    for name in crew:
        mine = [stay for stay in every if stay.chaser == name and stay.until_s > stay.since_s]
        if mine:
            traces.append(_stays(instance, name, mine, lane, crew))
    count = len(lane)
    short = shortened(lane, LONGEST_TICK)
    layout = {
        "barmode": "overlay",
        "height": FRAME_PX + LANE_PX * max(count, 3),
        "xaxis": time_axis(instance, plan),
        "yaxis": {
            "range": [count + 0.6, 0.4], "fixedrange": True, "showgrid": False,
            "tickvals": list(lane.values()), "ticktext": [in_chart(short[name]) for name in lane],
        },
        "showlegend": several(instance),
    }  # fmt: skip
    return {"data": traces, "layout": layout}


def _phase(plan: Plan, phase: str, bars: list[Segment], rows: list[int]) -> dict[str, Any]:
    return {
        "type": "bar", "orientation": "h", "name": LABELS[phase], "meta": {"phase": phase},
        "base": days([bar.start_s for bar in bars]), "x": days([bar.duration_s for bar in bars]),
        "y": rows, "customdata": [bar.leg for bar in bars],
        "text": [
            f"{LABELS[phase]}, {lasting(bar.duration_s)}<br>"
            f"{leg_title(plan, bar.leg)}<br>{period(bar.start_s, bar.end_s)}"
            for bar in bars
        ],
        "textposition": "none", "hovertemplate": "%{text}<extra></extra>", "showlegend": False,
        "marker": {"color": COLOURS[phase], "line": {"width": 0}}, "width": SHARED,
    }  # fmt: skip


def _stays(
    instance: Instance, chaser: str, mine: list[Stay], lane: dict[str, int], crew: list[str]
) -> dict[str, Any]:
    """Its part of the lanes of the stations, so that chasers at one station do not hide another."""
    each = SHARED / len(crew)
    beside = each * (crew.index(chaser) + 0.5) - SHARED / 2.0
    return {
        "type": "bar", "orientation": "h", "name": in_chart(chaser),
        "base": days([stay.since_s for stay in mine]),
        "x": days([stay.until_s - stay.since_s for stay in mine]),
        "y": [lane[stay.station] + beside for stay in mine],
        "customdata": [stay.leg for stay in mine],
        "text": [
            f"{in_chart(chaser)} at {in_chart(stay.station)}<br>"
            f"{period(stay.since_s, stay.until_s)}"
            + ("" if stay.refuelled_s is None else f"<br>refuelled at {clock(stay.refuelled_s)}")
            for stay in mine
        ],
        "textposition": "none", "hovertemplate": "%{text}<extra></extra>",
        "marker": {"color": chaser_colours(instance)[chaser], "line": {"width": 0}},
        "width": each,
    }  # fmt: skip
