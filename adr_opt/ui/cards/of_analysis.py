"""Cards of trade-offs, priced orders, comparisons and replanning."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

from ...common.card import Card, CardTable, days, days_words, order_words
from ...common.wording import counted
from .of_plan import legs_table

if TYPE_CHECKING:
    from ...analysis.comparison import Comparison
    from ...analysis.priced import PricedOrder, PricedRoute
    from ...analysis.replan.replanned import Replanned
    from ...analysis.trade.points import Point, Tradeoff

MENDED = {
    "leave-out": "mended without",
    "refuel": "repaired by refuelling before",
    "swap": "repaired by going later to",
}
MOST_MENDINGS = 3

DRIVES = {"thrust": "N", "isp": "Isp s"}
"""Headings of further columns of a trade-off, where they are varied."""


def of_tradeoff(made: Tradeoff) -> Card:
    """The card of a trade-off; on a page, with its points and their orders."""
    varied = " and ".join(
        f"{axis.kind} ({counted(len(axis.values), 'value')})" for axis in made.axes
    )
    facts = (
        varied,
        counted(len(made.points), "point"),
        f"{made.proven} proven",
        f"{made.runtime_s:.3g} s",
    )
    drives = [kind for kind in DRIVES if any(axis.kind == kind for axis in made.axes)]
    rows = [
        (
            *(f"{point.value(kind):g}" for kind in drives),
            f"{point.delta_v_m_s:,.6g}",
            days(point.duration_s),
            *_prizes(point),
            f"{point.visits}",
            f"{point.cost:,.1f}" if math.isfinite(point.cost) else "–",
            point.status,
        )
        for point in made.points
    ]
    heads = (
        *(DRIVES[kind] for kind in drives),
        "ΔV m/s",
        "days",
        "prize",
        "at most",
        "visits",
        "cost",
        "status",
    )
    return Card(
        "Tradeoff", f"of {made.instance.name!r}", facts, (), (CardTable(heads, rows, texts=0),)
    )


def _prizes(point: Point) -> tuple[str, str]:
    return tuple(
        f"{value:g}" if math.isfinite(value) else "–" for value in (point.prize, point.upper_bound)
    )  # type: ignore[return-value]


def of_point(point: Point) -> Card:
    """The card of a point."""
    prize, bound = _prizes(point)
    facts = [f"prize {prize} of at most {bound}", point.status]
    if len(point.routes) == 1 and point.routes[0]:
        facts.append(order_words(point.routes[0]))
    said = f"at {point.delta_v_m_s:g} m/s and {days_words(point.duration_s)}"
    said += f", {point.thrust_n:g} N" if point.thrust_n is not None else ""
    said += f", {point.isp_s:g} s" if point.isp_s is not None else ""
    return Card("Point", said, tuple(facts))


def of_priced_order(priced: PricedOrder) -> Card:
    """The card of priced orders."""
    facts = [f"prize {priced.objective:g}", "can be flown" if priced.holds else "breaks"]
    details = []
    for route in priced.routes:
        details.append((route.chaser, order_words(route.order) or "stays"))
        if not route.holds:
            details.append(("breaks", f"leg {len(route.legs) + 1} {route.reason}"))
            ways = dict.fromkeys((MENDED[each.kind], each.body) for each in route.remedies)
            details += list(ways)[:MOST_MENDINGS]
    if priced.lacking:
        details.append(("required, and lacking", ", ".join(priced.lacking)))
    return Card("PricedOrder", f"on {priced.instance.name!r}", tuple(facts), tuple(details))


def of_priced_route(route: PricedRoute) -> Card:
    """The card of the flyable part of a chaser's order."""
    facts = [f"{len(route.legs)} of {counted(len(route.order), 'leg')}"]
    facts.append("can be flown" if route.holds else f"leg {len(route.legs) + 1} {route.reason}")
    return Card(
        "PricedRoute", f"of {route.chaser!r}", tuple(facts), (("order", order_words(route.order)),)
    )


def of_comparison(made: Comparison) -> Card:
    """The card of a comparison of plans."""
    rows = [
        (
            side.name,
            side.method,
            side.status,
            f"{side.objective:g}",
            f"{side.visits}",
            f"{side.delta_v_m_s:,.1f}",
            days(side.end_s),
            f"{side.violations}",
        )
        for side in made.sides
    ]
    heads = ("plan", "method", "status", "prize", "visits", "ΔV m/s", "ends day", "violations")
    return Card(
        "Comparison",
        f"on {made.instance.name!r}",
        (counted(len(made.sides), "plan"),),
        (),
        (CardTable(heads, rows, texts=3),),
    )


def of_replanned(made: Replanned) -> Card:
    """The card of a replanned rest of a mission."""
    facts = [
        f"prize {made.prize_before:g} before, {made.prize_after:g} now",
        f"{counted(made.kept, 'leg')} kept",
        f"{made.runtime_s:.3g} s",
    ]
    details = [
        (what, ", ".join(names))
        for what, names in (
            ("gained", made.gained),
            ("dropped", made.dropped),
            ("lost", made.lost),
            ("missed", made.missed),
            ("given up", made.given_up),
        )
        if names
    ]
    details += [("note", note) for note in made.notes]
    tables = () if made.plan is None else (legs_table(made.plan.routes),)
    return Card("Replanned", f"on {made.instance.name!r}", tuple(facts), tuple(details), tables)
