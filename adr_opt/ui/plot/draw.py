"""Drawing of charts on a matplotlib axis, through the axis's own methods alone."""

from __future__ import annotations

from typing import Any

import numpy as np

from .chart import Bars, Box, Chart, Columns, Line, Marks, Series

POINT_PX = 0.75
MARKS = {
    "circle": {"marker": "o"},
    "circle-open": {"marker": "o", "fillstyle": "none"},
    "square": {"marker": "s"},
    "triangle-up": {"marker": "^"},
}
BAND = 0.18
"""Opacity of a band below a line."""

COLUMNS = 0.8
"""Width of all columns at a value, as a share of the available width."""


def draw(ax: Any, chart: Chart) -> Any:
    """Add a chart to an axis, label the axis unless already labelled, and return it."""
    columns = [one for one in chart.series if isinstance(one, Columns)]
    known: set[str] = set()
    for one in chart.series:
        said = None if one.name in known else plain(one.name)
        known.add(one.name)
        if isinstance(one, Columns):
            width = COLUMNS / max(len(columns), 2)
            off = width * (columns.index(one) - 0.5 * (len(columns) - 1))
            ax.bar(np.asarray(one.x) + off, one.y, width, color=one.colour, label=said)
        else:
            add(ax, one, said)
    if chart.y.rows:
        count = len(chart.y.rows)
        ax.set_yticks(range(1, count + 1), labels=[plain(name) for name in chart.y.rows])
        ax.set_ylim(count + 0.5, 0.5)
    return label(ax, chart.x.title, chart.y.title)


def add(ax: Any, one: Series, said: str | None) -> None:
    """Add a single series, under a name in the legend."""
    about: dict[str, Any] = {"color": one.colour, "label": said}
    if isinstance(one, Line):
        about["linewidth"] = POINT_PX * one.width
        about["drawstyle"] = "steps-post" if one.step else "default"
        if one.dots:
            about |= {"marker": "o", "markersize": 4}
        ax.plot(one.x, one.y, *(() if one.z is None else (one.z,)), **about)
        if len(one.below):
            ax.fill_between(one.x, one.y, one.below, color=one.colour, alpha=BAND, linewidth=0)
    elif isinstance(one, Marks):
        ax.plot(one.x, one.y, linestyle="none", **MARKS[one.symbol], **about)
    elif isinstance(one, Bars):
        ax.barh(one.y, one.lengths, left=one.x, **about)
    elif isinstance(one, Box):
        ax.fill_between(one.x, *one.y, alpha=0.25, linewidth=0.8, **about)


def plain(name: str) -> str:
    """A name for matplotlib, with `$` escaped, as it would begin mathematics."""
    return name.replace("$", r"\$")


def label(ax: Any, *titles: str) -> Any:
    """Label the axes x, y and, in space, z unless already labelled, and return ``ax``."""
    for axis, title in zip("xyz", titles, strict=False):
        if not getattr(ax, f"get_{axis}label")():
            getattr(ax, f"set_{axis}label")(title)
    return ax
