"""The timeline as a Gantt chart."""

from __future__ import annotations

from ....common.wording import shortened
from ....plan.palette import COLOURS, LABELS, PHASES
from ....plan.plan import Plan
from ....plan.routes import routes_of, several
from ....problem.instance import Instance
from ...plot.segments import segments
from ..text import in_chart, lasting
from .parts import FRAME_PX, LONGEST_TICK, Figure, days, leg_title, period, time_axis

ROW_PX = 19


def gantt(instance: Instance, plan: Plan) -> Figure:
    """One row per leg, the first on top, with a bar for each of its phases.

    Where there are several chasers, the legs of each come below a row with its name.
    """
    row_of, ticks = _rows(instance, plan)
    traces = []
    found = segments(instance, plan)
    for phase in PHASES:
        bars = [segment for segment in found if segment.phase == phase]
        if bars:
            traces.append(
                {
                    "type": "bar", "orientation": "h", "name": LABELS[phase],
                    "meta": {"phase": phase},
                    "base": days([bar.start_s for bar in bars]),
                    "x": days([bar.duration_s for bar in bars]),
                    "y": [row_of[bar.leg] for bar in bars],
                    "customdata": [bar.leg for bar in bars],
                    "text": [
                        f"{LABELS[phase]}, {lasting(bar.duration_s)}<br>"
                        f"{leg_title(plan, bar.leg)}<br>{period(bar.start_s, bar.end_s)}"
                        for bar in bars
                    ],
                    "textposition": "none", "hovertemplate": "%{text}<extra></extra>",
                    "marker": {"color": COLOURS[phase], "line": {"width": 0}}, "width": 0.72,
                }
            )  # fmt: skip
    rows = len(ticks)
    layout = {
        "barmode": "overlay",
        "height": FRAME_PX + ROW_PX * max(rows, 4),
        "xaxis": time_axis(instance, plan),
        "yaxis": {
            "range": [rows + 0.6, 0.4],
            "fixedrange": True,
            "tickvals": list(range(1, rows + 1)),
            "ticktext": ticks,
            "showgrid": False,
        },
    }
    return {"data": traces, "layout": layout}


def _rows(instance: Instance, plan: Plan) -> tuple[dict[int, int], list[str]]:
    """The row of each leg, by its number, and what stands beside each row, from the first on."""
    names = [flown.chaser.name for flown in routes_of(instance, plan)]
    short = shortened([*plan.destinations, *names], LONGEST_TICK)
    row_of: dict[int, int] = {}
    ticks: list[str] = []
    for flown in routes_of(instance, plan):
        if several(instance):
            ticks.append(f"<b>{in_chart(short[flown.chaser.name])}</b>")
        for number, leg in flown.legs:
            ticks.append(in_chart(short[leg.destination]))
            row_of[number] = len(ticks)
    return row_of, ticks
