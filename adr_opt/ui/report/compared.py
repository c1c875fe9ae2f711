"""The page that compares plans."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

from ...analysis.comparison import Comparison, Difference, LegPair, Side
from ...common.constants import DAY_S
from ...common.wording import counted, proof_words
from ...plan.palette import CHASERS
from ...plan.plan import Leg, Plan
from ...plan.routes import several
from ...problem.instance import Instance
from ..plot.budget import LEFT, budget_chart
from ..plot.chart import DAYS, Chart, ChartAxis, Line
from .charts import drawn
from .plain import page, row, section, table_of
from .tables import Column, table
from .text import NOTHING, clock, fixed, number

WORDS = {"same": "the same", "retimed": "other time or cost", "moved": "at another place"}


def compared_page(comparison: Comparison) -> str:
    """The HTML of the page."""
    instance, plans = comparison.instance, comparison.plans
    colours = dict(zip(plans, CHASERS * len(plans), strict=False))
    visits = Chart(
        tuple(_visits(instance, plan, name, colours[name]) for name, plan in plans.items()),
        DAYS,
        ChartAxis("visits"),
    )
    parts = [
        section("Side by side", "", _sides(comparison)),
        section(
            "Visits against time",
            "Serviced targets.",
            drawn(visits, "Visits of each plan against time"),
        ),
    ]
    if not several(instance):
        made = {name: budget_chart(instance, plan) for name, plan in plans.items()}
        lines = (
            replace(chart.series[0], name=name, colour=colours[name])
            for name, chart in made.items()
        )
        left = replace(next(iter(made.values())), series=tuple(lines))
        parts.append(
            section(
                LEFT,
                "A step down at every burn, and up at every refuelling.",
                drawn(left, "ΔV left of each plan"),
            )
        )
    first = next(iter(plans))
    parts += [
        section(f"{each.name} against {first}", _said(each), _legs(comparison, each))
        for each in comparison.differences
    ]
    under = f"{instance.name} · {counted(len(plans), 'plan')}"
    return page("Plans compared", instance.name, under, parts)


def _visits(instance: Instance, plan: Plan, name: str, colour: str) -> Line:
    """Number of finished services against days."""
    stations = instance.station_names
    ends = sorted(leg.end_s / DAY_S for leg in plan.legs if leg.destination not in stations)
    return Line(name=name, colour=colour, step=True, x=[0.0, *ends], y=range(len(ends) + 1))


FIGURES: dict[str, Callable[[Side], str]] = {
    "prize": lambda side: number(side.objective, 3),
    "bound, stated": lambda side: _unless_none(side.upper_bound, lambda bound: number(bound, 3)),
    "gap, stated": lambda side: _unless_none(side.gap, lambda gap: f"{gap:.1%}"),
    "status, stated": lambda side: proof_words(side.status, side.cost_status),
    "visits": lambda side: str(side.visits),
    "required": lambda side: str(side.required),
    "ΔV m/s": lambda side: fixed(side.delta_v_m_s, 1),
    "cost": lambda side: fixed(side.cost, 1),
    "cost bound, stated": lambda side: _unless_none(side.cost_bound, lambda cost: fixed(cost, 1)),
    "cost gap, stated": lambda side: _unless_none(side.cost_gap, lambda gap: f"{gap:.1%}"),
    "refuellings": lambda side: str(side.refuellings),
    "end": lambda side: clock(side.end_s),
    "violations": lambda side: str(side.violations),
    "method": lambda side: side.method,
}
"""Totals of a plan as texts."""


def _unless_none(value: float | None, tell: Callable[[float], str]) -> str:
    return NOTHING if value is None else tell(value)


def _sides(comparison: Comparison) -> str:
    headings = (("figure", ""), *((name, "n") for name in comparison.plans))
    rows = (
        row((("", title), *(("n", tell(side)) for side in comparison.sides)))
        for title, tell in FIGURES.items()
    )
    return table("Plans side by side", headings, rows)


def _said(difference: Difference) -> str:
    if difference.same:
        return "All legs are the same."
    parts = []
    for words, names in (("gains", difference.gained), ("loses", difference.lost)):
        if names:
            parts.append(f"{words} {counted(len(names), 'target')}: {', '.join(names)}")
    for what in ("retimed", "moved"):
        count = sum(pair.what == what for pair in difference.pairs)
        if count:
            parts.append(f"{counted(count, 'leg')} {WORDS[what]}")
    return "; ".join(parts) + "."


def _legs(comparison: Comparison, difference: Difference) -> str:
    whose = several(comparison.instance)
    columns: list[Column | bool] = [
        whose and ("chaser", "", lambda pair: pair.chaser),
        ("destination", "", lambda pair: pair.destination),
        ("leg", "n", lambda pair: _of_leg(pair.first, 0)),
        ("departs", "n", lambda pair: _of_leg(pair.first, 1)),
        ("ΔV m/s", "n", lambda pair: _of_leg(pair.first, 2)),
        ("leg there", "n", lambda pair: _of_leg(pair.other, 0)),
        ("departs there", "n", lambda pair: _of_leg(pair.other, 1)),
        ("ΔV there", "n", lambda pair: _of_leg(pair.other, 2)),
        ("more ΔV", "n", more),
        ("difference", "", told),
    ]
    pairs = ((pair,) for pair in difference.pairs)
    return table_of(f"Legs of {difference.name}", columns, pairs, lambda pair: pair.what)


def _of_leg(numbered: tuple[int, Leg] | None, which: int) -> str:
    """Number, departure or ΔV of a leg."""
    if numbered is None:
        return NOTHING
    at, leg = numbered
    return (str(at), clock(leg.departure_s), fixed(leg.delta_v_m_s, 1))[which]


def told(pair: LegPair) -> str:
    """Description of a pair of legs."""
    if pair.what == "only":
        return "only there" if pair.first is None else "only in the first"
    return WORDS[pair.what]


def more(pair: LegPair) -> str:
    """Extra cost of the leg in the other plan over the first one."""
    if pair.first is None or pair.other is None:
        return NOTHING
    added = pair.other[1].delta_v_m_s - pair.first[1].delta_v_m_s
    return f"+{fixed(added, 1)}" if added > 0.0 else fixed(added, 1)
