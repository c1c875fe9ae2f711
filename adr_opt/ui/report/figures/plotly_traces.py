"""Charts in plotly's form, and the common parts of their hover texts."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from datetime import UTC
from typing import Any

import numpy as np
import numpy.typing as npt

from ....common.constants import DAY_S
from ....common.wording import shortened
from ....plan.phases import LABELS
from ....plan.plan import Plan
from ....plan.routes import several
from ....problem.instance import Instance
from ...plot.chart import Bars, Box, Chart, ChartAxis, Line, Marks, Series
from ..text import clock, in_chart, lasting

Figure = dict[str, Any]

FRAME_PX = 70
LONGEST_TICK = 16
"""Length beyond which names are cut beside the chart; hover texts and tables have all of it."""

NO_LINE = {"width": 0}
SILENT = {"hoverinfo": "skip"}


def figure(chart: Chart, more: Callable[[Series], dict[str, Any]], **layout: Any) -> Figure:
    """A chart as plotly's data and layout.

    Parameters
    ----------
    chart : Chart
    more : callable
        What a trace has beyond its series: what is said where the mouse is, mostly.
    **layout
        Of the figure; what is said of an axis is added to that of the chart.
    """
    boxes = [one for one in chart.series if isinstance(one, Box)]
    if boxes:
        layout["shapes"] = [_shape(box) for box in boxes]
    for name, axis in (("xaxis", chart.x), ("yaxis", chart.y)):
        layout[name] = _axis(axis) | layout.get(name, {})
    return {"data": [trace(one, chart) | more(one) for one in chart.series], "layout": layout}


def trace(one: Series, chart: Chart) -> dict[str, Any]:
    """A series as a trace, without its hover text."""
    x, y = (column(values, axis.digits) for values, axis in ((one.x, chart.x), (one.y, chart.y)))
    made: dict[str, Any] = {"name": in_chart(one.name), "x": x, "y": y}
    if one.phase is not None:
        made["meta"] = {"phase": one.phase}
    if one.in_legend is not None:
        made["showlegend"] = one.in_legend
    if one.legs is not None:
        made["customdata"] = list(one.legs)
    if isinstance(one, Line):
        line = {"color": one.colour, "width": one.width, **({"shape": "hv"} if one.step else {})}
        made |= {"type": "scatter", "mode": "lines", "line": line}
    elif isinstance(one, Marks):
        colour = list(one.colours) or one.colour
        made |= {"type": "scatter", "mode": "markers"}
        made["marker"] = {"color": colour, "size": one.size, "symbol": one.symbol}
    elif isinstance(one, Box):
        line = {"width": 1.5, "color": one.colour}
        made |= {"type": "scatter", "mode": "markers"}
        made["marker"] = {"color": one.colour, "size": 7, "symbol": "x-thin", "line": line}
        made |= {"x": [sum(one.x) / 2.0], "y": [sum(one.y) / 2.0]}
    else:
        made |= {"type": "bar", "textposition": "none"}
        made["marker"] = {"color": one.colour, "line": NO_LINE}
    if isinstance(one, Bars):
        made |= {"orientation": "h", "base": x, "x": column(one.lengths, chart.x.digits)}
        made["width"] = one.share
        if one.pattern:
            made["marker"]["pattern"] = {"shape": one.pattern, "size": 6, "fillmode": "overlay"}
    return made


def _shape(box: Box) -> dict[str, Any]:
    (left, right), (low, high) = box.x, box.y
    return {
        "type": "rect",
        "layer": "below",
        "x0": left,
        "x1": right,
        "y0": low,
        "y1": high,
        "fillcolor": box.colour,
        "opacity": 0.28,
        "line": {"width": 1, "color": box.colour},
    }


def _axis(axis: ChartAxis) -> dict[str, Any]:
    if axis.rows is None:
        return {"title": {"text": axis.title}}
    short, count = shortened(axis.rows, LONGEST_TICK), len(axis.rows)
    ticks = [in_chart(short[name]) for name in axis.rows]
    for row in axis.headings:
        ticks[row - 1] = f"<b>{ticks[row - 1]}</b>"
    return {
        "range": [count + 0.6, 0.4],
        "fixedrange": True,
        "showgrid": False,
        "tickvals": list(range(1, count + 1)),
        "ticktext": ticks,
    }


def said(text: str, texts: Sequence[str] | None = None) -> dict[str, Any]:
    """Hover text in plotly's form, with a text for each point."""
    return {"hovertemplate": f"{text}<extra></extra>"} | ({} if texts is None else {"text": texts})


def of_arcs(line: Series, text: str) -> dict[str, Any]:
    """Hover text of flown arcs, to which the page adds the titles of their legs."""
    if line.phase is None:
        return SILENT
    meta = {"phase": line.phase, "titled": True}
    return {"meta": meta} | said(f"{LABELS[line.phase]}, %{{text}}{text}")


def of_bars(plan: Plan, bars: Series) -> dict[str, Any]:
    """Hover text of a phase's segments."""
    texts = [
        f"{bars.name}, {lasting(bar.duration_s)}<br>{leg_title(plan, bar.leg)}<br>"
        f"{period(bar.start_s, bar.end_s)}"
        for bar in bars.of
    ]
    return said("%{text}", texts)


def column(values: npt.ArrayLike, digits: int) -> list[float | None]:
    """Numbers for JSON, rounded; NaN, which makes a gap in a line, becomes null."""
    return [
        None if value != value else value
        for value in np.round(np.asarray(values, dtype=float), digits).tolist()
    ]


def time_axis(instance: Instance, plan: Plan) -> dict[str, Any]:
    """The common time axis of the charts, from the epoch to the end of the mission."""
    last = [route.legs[-1].end_s for route in plan.routes if route.legs]
    end = max([instance.mission.duration_s, *last])
    title = f"days since {instance.epoch.astimezone(UTC):%Y-%m-%d %H:%M} UTC"
    return {"title": {"text": title}, "range": [0.0, end / DAY_S or 1.0]}


def leg_title(plan: Plan, number: int) -> str:
    """Title of a leg in hover texts."""
    leg = plan.legs[number - 1]
    title = f"leg {number}: {in_chart(leg.origin)} → {in_chart(leg.destination)}"
    if len(plan.routes) == 1:
        return title
    before = 0
    for route in plan.routes:
        before += len(route.legs)
        if number <= before:
            return f"{in_chart(route.chaser)}, {title}"
    return title


def named(instance: Instance, are_shown: bool) -> dict[str, Any]:
    """Legend settings of a layout or a trace, shown for several chasers."""
    return {"showlegend": are_shown} if several(instance) else {}


def period(start_s: float, end_s: float) -> str:
    """A time window, for hover texts."""
    return f"{clock(start_s)} – {clock(end_s)}"
