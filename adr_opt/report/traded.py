"""The page of a trade-off: bands of plans and bounds over budgets and durations."""

from __future__ import annotations

import math

from ..analysis.trade.axes import KINDS
from ..analysis.trade.points import Point, Tradeoff
from ..kernels.constants import DAY_S
from ..plot.palette import CHASERS
from ..wording import counted, status_words
from .charts import Line, chart
from .plain import page, row, section
from .tables import table
from .text import NOTHING, fixed, number

TITLES = {kind.name: kind.title for kind in KINDS.values()}

NOTE = (
    "The line is what the best plan found collects, the band reaches up to what is proven that no "
    "plan exceeds; where the band is gone, the plan is optimal (of the model)."
)


def traded_page(tradeoff: Tradeoff) -> str:
    """The HTML of the page."""
    instance = tradeoff.instance
    parts = []
    for axis in tradeoff.axes:
        other = "delta-v" if axis.kind == "duration" else "duration"
        rows = tradeoff.along(axis.kind)
        lines = [
            _line(points, axis.kind, _named(other, value, len(rows)), CHASERS[at % len(CHASERS)])
            for at, (value, points) in enumerate(rows.items())
        ]
        said = f"Prize and bound against {TITLES[axis.kind]}"
        parts.append(section(said, NOTE, chart(lines, TITLES[axis.kind], "prize", said)))
    parts.append(section("Points", "", _table(tradeoff)))
    under = (
        f"{counted(len(tradeoff.points), 'point')}, {tradeoff.proven} proven · "
        f"{tradeoff.runtime_s:.1f} s, {tradeoff.cpu_s:.1f} s of processors"
    )
    return page("Trade-off", instance.name, under, parts)


def _named(kind: str, value: float, rows: int) -> str:
    if rows == 1:
        return "plans, and up to the bound"
    return f"{KINDS[kind].name} {number(value / KINDS[kind].scale, 3)} {KINDS[kind].unit}"


def value_of(point: Point, kind: str) -> float:
    """The limit of a point that is varied, in the unit that people give it in."""
    return point.value(kind) / KINDS[kind].scale


def _line(points: tuple[Point, ...], kind: str, name: str, colour: str) -> Line:
    there = [point for point in points if math.isfinite(point.prize)]
    top = max((point.prize for point in there), default=0.0)
    return Line(
        name,
        [value_of(point, kind) for point in there],
        [point.prize for point in there],
        colour,
        dots=True,
        below=[point.upper_bound if math.isfinite(point.upper_bound) else top for point in there],
    )


HEADINGS = ("ΔV m/s", "days", "prize", "bound", "gap", "status", "visits", "cost", "by", "s")


def cells(point: Point) -> tuple[str, ...]:
    """A point as texts under :data:`HEADINGS`."""
    there, bounded = math.isfinite(point.prize), math.isfinite(point.upper_bound)
    gap = NOTHING
    if there and bounded:
        gap = f"{(point.upper_bound - point.prize) / (point.upper_bound or 1.0):.1%}"
    return (
        number(point.delta_v_m_s, 3),
        number(point.duration_s / DAY_S, 4),
        number(point.prize, 3) if there else NOTHING,
        number(point.upper_bound, 3) if bounded else NOTHING,
        gap,
        status_words(point.status),
        str(point.visits),
        NOTHING if math.isnan(point.cost) else fixed(point.cost, 1),
        ", ".join(point.methods) or "its neighbours",
        fixed(point.runtime_s, 1),
    )


def _table(tradeoff: Tradeoff) -> str:
    kinds = ("n", "n", "n", "n", "n", "", "n", "n", "", "n")
    rows = (row(zip(kinds, cells(point), strict=True)) for point in tradeoff.points)
    return table("Points", zip(HEADINGS, kinds, strict=True), rows)
