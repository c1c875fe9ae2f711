"""The page of a trade-off: bands of plans and bounds over budgets and durations."""

from __future__ import annotations

import math
from collections.abc import Sequence

from ...analysis.trade.axes import KINDS
from ...analysis.trade.frontier import Ending
from ...analysis.trade.points import Point, Tradeoff
from ...common.constants import DAY_S
from ...common.wording import counted, status_words
from ...plan.palette import CHASERS
from .charts import Line, chart
from .plain import page, row, section
from .tables import table
from .text import NOTHING, fixed, number

TITLES = {kind.name: kind.title for kind in KINDS.values()}

FRONTIER = "Least ΔV against the last day"

NOTE = (
    "The line is what the best plan found collects, the band reaches up to what is proven that no "
    "plan exceeds, or to all prizes where nothing is proven; where the band is gone, the plan is "
    "optimal (of the model)."
)


FRONTIER_NOTE = (
    "Of plans that collect the most, the least ΔV that known orders take to be over by a day. The "
    "cost has the price of time besides."
)


def traded_page(tradeoff: Tradeoff, endings: Sequence[Ending] = ()) -> str:
    """The HTML of the page.

    Parameters
    ----------
    tradeoff : Tradeoff
    endings : sequence of Ending
        Its frontier, where there is one.
    """
    instance = tradeoff.instance
    parts, most = [], math.fsum(target.prize for target in instance.targets)
    for axis in tradeoff.axes:
        other = "delta-v" if axis.kind == "duration" else "duration"
        rows = tradeoff.along(axis.kind)
        lines = [
            _line(
                points, axis.kind, _named(other, value, len(rows)), CHASERS[at % len(CHASERS)], most
            )
            for at, (value, points) in enumerate(rows.items())
        ]
        said = f"Prize and bound against {TITLES[axis.kind]}"
        parts.append(section(said, NOTE, chart(lines, TITLES[axis.kind], "prize", said)))
    if endings:
        parts.append(section(FRONTIER, FRONTIER_NOTE, _frontier_chart(endings)))
    parts.append(section("Points", "", _table(tradeoff)))
    if endings:
        parts.append(section("Sooner or cheaper", "", _frontier_table(endings)))
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


def _line(points: tuple[Point, ...], kind: str, name: str, colour: str, most: float) -> Line:
    there = [point for point in points if math.isfinite(point.prize)]
    return Line(
        name,
        [value_of(point, kind) for point in there],
        [point.prize for point in there],
        colour,
        dots=True,
        below=[point.upper_bound if math.isfinite(point.upper_bound) else most for point in there],
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


FRONTIER_HEADINGS = ("tank m/s", "prize", "last day", "ΔV m/s", "cost")


def ending_cells(ending: Ending) -> tuple[str, ...]:
    """A plan on the frontier as texts under :data:`FRONTIER_HEADINGS`."""
    return (
        number(ending.tank_m_s, 3), number(ending.prize, 3), fixed(ending.last_s / DAY_S, 2),
        fixed(ending.delta_v_m_s, 1), fixed(ending.cost, 1),
    )  # fmt: skip


def _frontier_chart(endings: Sequence[Ending]) -> str:
    tanks = list(dict.fromkeys(ending.tank_m_s for ending in endings))
    lines = []
    for at, tank_m_s in enumerate(tanks):
        own = [ending for ending in endings if ending.tank_m_s == tank_m_s]
        name = "plans" if len(tanks) == 1 else _named("delta-v", tank_m_s, len(tanks))
        days = [ending.last_s / DAY_S for ending in own]
        spent = [ending.delta_v_m_s for ending in own]
        lines.append(Line(name, days, spent, CHASERS[at % len(CHASERS)], step=True, dots=True))
    return chart(lines, "last day", "ΔV [m/s]", FRONTIER)


def _frontier_table(endings: Sequence[Ending]) -> str:
    kinds = ("n",) * len(FRONTIER_HEADINGS)
    rows = (row(zip(kinds, ending_cells(each), strict=True)) for each in endings)
    return table(FRONTIER, zip(FRONTIER_HEADINGS, kinds, strict=True), rows)
