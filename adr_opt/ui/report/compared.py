"""The page that compares plans."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

from ...analysis.comparison import Comparison, Difference, LegPair, Side
from ...common.constants import DAY_S
from ...common.wording import counted, status_words
from ...plan.palette import CHASERS
from ...plan.plan import Leg, Plan
from ...plan.routes import several
from ...problem.instance import Instance
from ..plot.budget import LEFT, budget_chart
from ..plot.chart import DAYS, Chart, ChartAxis, Line
from .charts import drawn
from .plain import page, row, section
from .tables import table
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
            "Targets whose service is over.",
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


FIGURES = (
    "prize",
    "bound, stated",
    "gap, stated",
    "status, stated",
    "visits",
    "required",
    "ΔV m/s",
    "cost",
    "refuellings",
    "end",
    "violations",
    "method",
)


def figures(side: Side) -> tuple[str, ...]:
    """Totals of a plan as texts, in the order of :data:`FIGURES`."""
    return (
        number(side.objective, 3),
        NOTHING if side.upper_bound is None else number(side.upper_bound, 3),
        NOTHING if side.gap is None else f"{side.gap:.1%}",
        status_words(side.status),
        str(side.visits),
        str(side.required),
        fixed(side.delta_v_m_s, 1),
        fixed(side.cost, 1),
        str(side.refuellings),
        clock(side.end_s),
        str(side.violations),
        side.method,
    )


def _sides(comparison: Comparison) -> str:
    headings = (("figure", ""), *((name, "n") for name in comparison.plans))
    columns = [figures(side) for side in comparison.sides]
    rows = (
        row((("", title), *(("n", column[at]) for column in columns)))
        for at, title in enumerate(FIGURES)
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
    headings = (
        *((("chaser", ""),) if whose else ()),
        ("destination", ""),
        ("leg", "n"),
        ("departs", "n"),
        ("ΔV m/s", "n"),
        ("leg there", "n"),
        ("departs there", "n"),
        ("ΔV there", "n"),
        ("more ΔV", "n"),
        ("difference", ""),
    )
    return table(f"Legs of {difference.name}", headings, _rows(difference, whose))


def _rows(difference: Difference, whose: bool) -> Iterator[str]:
    for pair in difference.pairs:
        cells = [("", pair.chaser)] if whose else []
        cells += [("", pair.destination), *_cells(pair.first), *_cells(pair.other)]
        cells += [("n", more(pair)), ("", told(pair))]
        yield row(cells, pair.what)


def _cells(numbered: tuple[int, Leg] | None) -> list[tuple[str, str]]:
    if numbered is None:
        return [("n", NOTHING)] * 3
    at, leg = numbered
    return [("n", str(at)), ("n", clock(leg.departure_s)), ("n", fixed(leg.delta_v_m_s, 1))]


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
