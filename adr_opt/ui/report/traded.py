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
from ..plot.chart import Chart, ChartAxis, Line
from ..plot.studies import named, tradeoff_chart
from .charts import drawn
from .plain import page, row, section
from .tables import table
from .text import NOTHING, fixed, number

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
    parts = []
    for axis in tradeoff.axes:
        made = tradeoff_chart(tradeoff, axis.kind)
        said = f"Prize and bound against {made.x.title}"
        parts.append(section(said, NOTE, drawn(made, said)))
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


HEADINGS = ("ΔV m/s", "days", "prize", "bound", "gap", "status", "visits", "cost", "by", "s")

VARIED = {"propellant": "kg", "thrust": "N", "isp": "Isp s"}
"""Headings of further columns, of what is varied besides."""


def headings(tradeoff: Tradeoff) -> tuple[str, ...]:
    """Headings of a table of points: of what is varied besides, and :data:`HEADINGS`."""
    return (*(VARIED[kind] for kind in _varied(tradeoff)), *HEADINGS)


def cells(tradeoff: Tradeoff, point: Point) -> tuple[str, ...]:
    """A point as texts, under :func:`headings`."""
    return (*(number(point.value(kind), 4) for kind in _varied(tradeoff)), *_results(point))


def _varied(tradeoff: Tradeoff) -> list[str]:
    kinds = {axis.kind for axis in tradeoff.axes}
    return [kind for kind in VARIED if kind in kinds]


def _results(point: Point) -> tuple[str, ...]:
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
    titles = headings(tradeoff)
    kinds = ["" if title in ("status", "by") else "n" for title in titles]
    rows = (row(zip(kinds, cells(tradeoff, point), strict=True)) for point in tradeoff.points)
    return table("Points", zip(titles, kinds, strict=True), rows)


FRONTIER_HEADINGS = ("tank m/s", "prize", "last day", "ΔV m/s", "cost")


def ending_cells(ending: Ending) -> tuple[str, ...]:
    """A plan on the frontier as texts, under :data:`FRONTIER_HEADINGS`."""
    return (
        number(ending.tank_m_s, 3),
        number(ending.prize, 3),
        fixed(ending.last_s / DAY_S, 2),
        fixed(ending.delta_v_m_s, 1),
        fixed(ending.cost, 1),
    )


def _frontier_chart(endings: Sequence[Ending]) -> str:
    tanks = list(dict.fromkeys(ending.tank_m_s for ending in endings))
    lines = []
    for at, tank_m_s in enumerate(tanks):
        own = [ending for ending in endings if ending.tank_m_s == tank_m_s]
        name = "plans" if len(tanks) == 1 else named(KINDS["delta-v"], tank_m_s)
        lines.append(
            Line(
                name=name,
                colour=CHASERS[at % len(CHASERS)],
                step=True,
                dots=True,
                x=[ending.last_s / DAY_S for ending in own],
                y=[ending.delta_v_m_s for ending in own],
            )
        )
    return drawn(Chart(tuple(lines), ChartAxis("last day"), ChartAxis("ΔV [m/s]")), FRONTIER)


def _frontier_table(endings: Sequence[Ending]) -> str:
    kinds = ("n",) * len(FRONTIER_HEADINGS)
    rows = (row(zip(kinds, ending_cells(each), strict=True)) for each in endings)
    return table(FRONTIER, zip(FRONTIER_HEADINGS, kinds, strict=True), rows)
