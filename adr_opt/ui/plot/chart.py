"""Charts as plain data: the model drawn by matplotlib, plotly and SVG.

Each chart is made once, in the module of its name, and drawn by :func:`draw` on an axis of
matplotlib, by :func:`adr_opt.ui.report.figures.plotly_traces.figure` for plotly, and by
:func:`adr_opt.ui.report.charts.drawn` on pages without scripts. Names are as people gave them: who
draws escapes them.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from ...common.constants import DAY_S
from ...plan.phases import PHASES

POINT_PX = 0.75
MARKS = {
    "circle": {"marker": "o"},
    "circle-open": {"marker": "o", "fillstyle": "none"},
    "square": {"marker": "s"},
    "square-open": {"marker": "s", "fillstyle": "none"},
    "diamond-open": {"marker": "D", "fillstyle": "none"},
    "triangle-up": {"marker": "^"},
    "triangle-up-open": {"marker": "^", "fillstyle": "none"},
    "triangle-down-open": {"marker": "v", "fillstyle": "none"},
    "pentagon-open": {"marker": "p", "fillstyle": "none"},
    "star-open": {"marker": "*", "fillstyle": "none"},
    "cross-thin-open": {"marker": "+"},
    "x-thin-open": {"marker": "x"},
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
        about["linestyle"] = "--" if one.dashed else "-"
        about["drawstyle"] = "steps-post" if one.step else "default"
        if one.dots:
            about |= {"marker": "o", "markersize": 4}
        ax.plot(one.x, one.y, *(() if one.z is None else (one.z,)), **about)
        if len(one.below):
            ax.fill_between(one.x, one.y, one.below, color=one.colour, alpha=BAND, linewidth=0)
    elif isinstance(one, Marks):
        ax.plot(one.x, one.y, linestyle="none", **MARKS[one.symbol], **about)
    elif isinstance(one, Bars):
        ax.barh(one.y, one.lengths, left=one.x, hatch=one.pattern, edgecolor="white", lw=0, **about)
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


KM_M = 1000.0

Values = Sequence[float] | npt.NDArray[np.float64]


class Link(NamedTuple):
    """Target of a point's link on a page, and its hover text."""

    href: str
    title: str


@dataclass(frozen=True, kw_only=True, eq=False)
class Series:
    """Data drawn together, with one entry in the legend.

    Attributes
    ----------
    name, colour : str
    x, y : sequence of float
        NaN for a gap in a line.
    z : sequence of float, optional
        In space.
    legs : sequence of int, optional
        The leg of each point, 0 where none has begun; None where points belong to none.
    of : sequence
        What points stand for, for hover texts and the like; a :class:`Link` can be clicked on pages
        without scripts.
    phase : str, optional
        One of :data:`.PHASES`, or "zone".
    in_legend : bool, optional
        Where not every series is.
    """

    name: str
    colour: str
    x: Values
    y: Values
    z: Values | None = None
    legs: Sequence[int] | None = None
    of: Sequence[Any] = ()
    phase: str | None = None
    in_legend: bool | None = None


@dataclass(frozen=True, kw_only=True, eq=False)
class Line(Series):
    """A line, or several with gaps between them.

    Attributes
    ----------
    width : float
        [px]; 0 for a band alone.
    step, dots, dashed : bool
        Whether it keeps its value until the next point, whether points are marked, and whether it
        is told from others by dashes.
    below : sequence of float
        Where given, the band between the line and this is filled.
    """

    width: float = 1.8
    step: bool = False
    dots: bool = False
    dashed: bool = False
    below: Sequence[float] = ()


@dataclass(frozen=True, kw_only=True, eq=False)
class Marks(Series):
    """Points, each with a mark.

    Attributes
    ----------
    symbol : str
        As plotly calls it.
    size : float
        [px].
    colours : sequence of str
        Of each mark, where they differ and can be drawn so.
    """

    symbol: str = "circle"
    size: float = 9.0
    colours: Sequence[str] = ()


@dataclass(frozen=True, kw_only=True, eq=False)
class Bars(Series):
    """Horizontal bars from ``x``, of some length, in rows ``y``, of which they fill a share."""

    lengths: Values
    share: float = 0.72

    @property
    def pattern(self) -> str:
        """Hatching of the bars."""
        return PHASES[self.phase].pattern if self.phase in PHASES else ""


@dataclass(frozen=True, kw_only=True, eq=False)
class Columns(Series):
    """Columns from 0 up to ``y``, side by side for several series."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Box(Series):
    """A background rectangle, from the first to the second ``x`` and ``y``."""


@dataclass(frozen=True)
class ChartAxis:
    """An axis.

    Attributes
    ----------
    title : str
        With the unit.
    digits : int
        Decimals that can be told apart in a picture; files do without the others.
    rows : tuple of str, optional
        What stands beside the rows 1, 2, …, from the top, where there are rows.
    headings : tuple of int
        Of the rows those that head the ones below.
    """

    title: str
    digits: int = 2
    rows: tuple[str, ...] | None = None
    headings: tuple[int, ...] = ()


DAYS = ChartAxis("days since the epoch", 6)
"""Times in days, to less than a tenth of a second."""


@dataclass(frozen=True)
class Chart:
    """Series on two axes, in drawing order."""

    series: tuple[Series, ...]
    x: ChartAxis
    y: ChartAxis


def days(times_s: npt.ArrayLike) -> npt.NDArray[np.float64]:
    """Times in days."""
    return np.asarray(times_s, dtype=float) / DAY_S
