"""Small charts as SVG in a page: lines, steps and bands, in the page's colours."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from itertools import pairwise

from ..plot.chart import Chart, Line, Link, Marks, Series
from .text import escape, number

WIDE = 720, 300
LEFT, RIGHT, TOP, BOTTOM = 56, 14, 12, 42
TICKS = 6

_Place = Callable[[float, float], tuple[float, float]]
"""Position of a point in the picture."""


def drawn(
    chart: Chart, caption: str, size: tuple[int, int] = WIDE, *, from_zero: bool = True
) -> str:
    """A figure with the lines of a chart, axes and a legend.

    Parameters
    ----------
    chart : Chart
    caption : str
        Alternative text of the chart.
    size : (int, int)
        Width and height [px].
    from_zero : bool
        Whether the vertical axis begins at 0; else it begins below the least value.
    """
    width, height = size
    lines = [line for line in chart.series if isinstance(line, (Line, Marks))]
    below = [y for line in lines if isinstance(line, Line) for y in line.below]
    ys = [*(y for line in lines for y in line.y), *below] or [0.0, 1.0]
    x_low, x_high = ends(chart)
    low = 0.0 if from_zero else min(ys)
    y_ticks = ticks(low, max(*ys, low + 1e-9))
    y_low, y_high = y_ticks[0], y_ticks[-1]

    def place(x: float, y: float) -> tuple[float, float]:
        across = LEFT + (x - x_low) / (x_high - x_low) * (width - LEFT - RIGHT)
        up = (y - y_low) / (y_high - y_low) * (height - TOP - BOTTOM)
        return across, height - BOTTOM - up

    parts = [_axes(place, ticks(x_low, x_high), y_ticks, (x_low, x_high), chart, size)]
    for line in lines:
        parts.append(_drawn(line, place) if isinstance(line, Line) else _dots(line, place))
    legend = "".join(f"<span>{_key(line)}{escape(line.name)}</span> " for line in lines)
    # A picture holds nothing that a reader could follow, such as a link.
    links = any(isinstance(one, Link) for line in lines for one in line.of)
    role = "group" if links else "img"
    return (
        f'<figure class="drawn"><svg viewBox="0 0 {width} {height}" role="{role}" '
        f'aria-label="{escape(caption)}">{"".join(parts)}</svg>'
        f"<figcaption>{legend}</figcaption></figure>"
    )


def ends(chart: Chart) -> tuple[float, float]:
    """Values at the left and the right end of the horizontal axis."""
    xs = [x for line in chart.series if isinstance(line, (Line, Marks)) for x in line.x]
    low, high = min(xs, default=0.0), max(xs, default=1.0)
    return (low, high) if low < high else (low - 1.0, high + 1.0)


def _key(line: Series) -> str:
    """The mark of a series in the legend; without styles, which the live page does not allow."""
    if not isinstance(line, Line):
        shape = f'<circle cx="8" cy="5" r="5" fill="{line.colour}"/>'
    elif line.width > 0.0:
        shape = f'<path d="M0 5H16" stroke="{line.colour}" stroke-width="3"{_dashes(line)}/>'
    else:
        shape = f'<path d="M0 0H16V10H0Z" fill="{line.colour}" opacity=".3"/>'
    return f'<svg viewBox="0 0 16 10" aria-hidden="true">{shape}</svg>'


def _dashes(line: Line) -> str:
    return ' stroke-dasharray="6 4"' if line.dashed else ""


def _drawn(line: Line, place: _Place) -> str:
    points = list(zip(line.x, line.y, strict=True))
    parts = []
    if line.below:
        back = list(zip(line.x, line.below, strict=True))[::-1]
        outline = " ".join(_at(place(x, y)) for x, y in (*points, *back))
        parts.append(f'<polygon points="{outline}" fill="{line.colour}" opacity=".18"/>')
    if line.step:
        points = [
            point for one, two in pairwise(points) for point in (one, (two[0], one[1]))
        ] + points[-1:]
    if line.width > 0.0:
        path = " ".join(_at(place(x, y)) for x, y in points)
        parts.append(
            f'<polyline points="{path}" fill="none" stroke="{line.colour}" stroke-width="2"'
            f"{_dashes(line)}/>"
        )
    return "".join(parts) + (_dots(line, place) if line.dots else "")


def _dots(series: Series, place: _Place) -> str:
    """Points as dots, each a link where it leads somewhere."""
    is_open = isinstance(series, Marks) and series.symbol.endswith("-open")
    colour = series.colour
    look = f'fill="none" stroke="{colour}" stroke-width="1.5"' if is_open else f'fill="{colour}"'
    size = 0.5 * series.size if isinstance(series, Marks) else 3.5
    parts = []
    for at, (x, y) in enumerate(zip(series.x, series.y, strict=True)):
        across, up = place(x, y)
        link = series.of[at] if at < len(series.of) else None
        dot = f'<circle cx="{across:.1f}" cy="{up:.1f}" r="{size:g}" {look}'
        if isinstance(link, Link):
            title = f"<title>{escape(link.title)}</title>"
            parts.append(f'<a href="{escape(link.href)}">{dot}>{title}</circle></a>')
        else:
            parts.append(f"{dot}/>")
    return "".join(parts)


def _axes(
    place: _Place,
    x_ticks: Sequence[float],
    y_ticks: Sequence[float],
    x_range: tuple[float, float],
    chart: Chart,
    size: tuple[int, int],
) -> str:
    (width, height), parts = size, []
    for y in y_ticks:
        (left, up), (right, _) = place(x_range[0], y), place(x_range[1], y)
        parts.append(f'<path d="M{left:.1f} {up:.1f}H{right:.1f}" class="grid"/>')
        parts.append(
            f'<text x="{left - 8:.1f}" y="{up + 4:.1f}" text-anchor="end">{number(y, 3)}</text>'
        )
    for x in x_ticks:
        if x_range[0] <= x <= x_range[1]:
            across, up = place(x, y_ticks[0])
            parts.append(
                f'<text x="{across:.1f}" y="{up + 18:.1f}" text-anchor="middle">'
                f"{number(x, 3)}</text>"
            )
    middle = 0.5 * (LEFT + width - RIGHT)
    parts.append(
        f'<text x="{middle}" y="{height - 6}" text-anchor="middle">{escape(chart.x.title)}</text>'
        f'<text transform="translate(13 {0.5 * (TOP + height - BOTTOM)}) rotate(-90)" '
        f'text-anchor="middle">{escape(chart.y.title)}</text>'
    )
    return "".join(parts)


def _at(point: tuple[float, float]) -> str:
    return f"{point[0]:.1f},{point[1]:.1f}"


def ticks(low: float, high: float) -> list[float]:
    """A few round numbers from at most ``low`` to at least ``high``."""
    rough = (high - low) / TICKS
    power = 10.0 ** math.floor(math.log10(rough))
    step = next(power * part for part in (1.0, 2.0, 5.0, 10.0) if power * part >= rough * 0.999)
    first, last = math.floor(low / step + 1e-9), math.ceil(high / step - 1e-9)
    return [round(step * n, 12) for n in range(first, last + 1)]
