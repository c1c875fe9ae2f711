"""The page of a trade-off: bands of plans and bounds over budgets and durations."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence

from ...analysis.trade.frontier import Ending
from ...analysis.trade.points import Point, Tradeoff
from ...common.constants import DAY_S
from ...common.wording import counted, status_words
from ...plan.palette import CHASERS
from ..plot.chart import Chart, ChartAxis, Line
from ..plot.fronts import named, tradeoff_chart
from .charts import drawn
from .plain import page, section, table_of
from .text import NOTHING, fixed, number

FRONTIER = "Least ΔV against the last day"

NOTE = (
    "The line is the prize of the best plan found; the band reaches up to the proven bound, or to "
    "all prizes if nothing is proven; without a band, the plan is optimal (of the model)."
)


FRONTIER_NOTE = (
    "Among plans that collect the most, the least ΔV with which known orders end by a day. The "
    "cost includes the price of time."
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


VARIED = {"propellant": "kg", "thrust": "N", "isp": "Isp s"}
"""Headings of further columns for other varied limits."""


def _gap(point: Point) -> str:
    if not (math.isfinite(point.prize) and math.isfinite(point.upper_bound)):
        return NOTHING
    return f"{(point.upper_bound - point.prize) / (point.upper_bound or 1.0):.1%}"


def _if_finite(value: float) -> str:
    return number(value, 3) if math.isfinite(value) else NOTHING


POINT_COLUMNS: dict[str, Callable[[Point], str]] = {
    "ΔV m/s": lambda point: number(point.delta_v_m_s, 3),
    "days": lambda point: number(point.duration_s / DAY_S, 4),
    "prize": lambda point: _if_finite(point.prize),
    "bound": lambda point: _if_finite(point.upper_bound),
    "gap": _gap,
    "status": lambda point: status_words(point.status),
    "visits": lambda point: str(point.visits),
    "cost": lambda point: NOTHING if math.isnan(point.cost) else fixed(point.cost, 1),
    "by": lambda point: ", ".join(point.methods) or "its neighbours",
    "s": lambda point: fixed(point.runtime_s, 1),
}
"""Columns of a point, as texts."""


def point_columns(tradeoff: Tradeoff) -> dict[str, Callable[[Point], str]]:
    """Columns of a table of points: other varied limits, and :data:`POINT_COLUMNS`."""
    kinds = {axis.kind for axis in tradeoff.axes}

    def _value(kind: str) -> Callable[[Point], str]:
        return lambda point: number(point.value(kind), 4)

    varied = {title: _value(kind) for kind, title in VARIED.items() if kind in kinds}
    return varied | POINT_COLUMNS


def _table(tradeoff: Tradeoff) -> str:
    columns = [
        (title, "" if title in ("status", "by") else "n", tell)
        for title, tell in point_columns(tradeoff).items()
    ]
    return table_of("Points", columns, ((point,) for point in tradeoff.points))


FRONTIER_COLUMNS: dict[str, Callable[[Ending], str]] = {
    "tank m/s": lambda ending: number(ending.tank_m_s, 3),
    "prize": lambda ending: number(ending.prize, 3),
    "last day": lambda ending: fixed(ending.last_s / DAY_S, 2),
    "ΔV m/s": lambda ending: fixed(ending.delta_v_m_s, 1),
    "cost": lambda ending: fixed(ending.cost, 1),
}
"""Columns of a plan on the frontier, as texts."""


def _frontier_chart(endings: Sequence[Ending]) -> str:
    tanks = list(dict.fromkeys(ending.tank_m_s for ending in endings))
    lines = []
    for at, tank_m_s in enumerate(tanks):
        own = [ending for ending in endings if ending.tank_m_s == tank_m_s]
        name = "plans" if len(tanks) == 1 else named(["delta-v"], [tank_m_s])
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
    columns = [(title, "n", tell) for title, tell in FRONTIER_COLUMNS.items()]
    return table_of(FRONTIER, columns, ((ending,) for ending in endings))
