"""Cards of trade-offs, designs, priced orders, comparisons, replanning and rehearsals."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import TYPE_CHECKING

from ...common.card import Card, CardTable, days_words, order_words
from ...common.wording import counted
from .of_plan import legs_table

if TYPE_CHECKING:
    from ...analysis.comparison import Comparison, Side
    from ...analysis.design import DesignPoint, DesignStudy
    from ...analysis.priced import PricedOrder, PricedRoute
    from ...analysis.rehearse.rehearsals import Rehearsals
    from ...analysis.replan.replanned import Replanned
    from ...analysis.trade.points import Point, Tradeoff


def of_design_study(study: DesignStudy) -> Card:
    """The card of a study; on a page, with its points."""
    from ..report.designs import design_columns

    varied = " and ".join(
        f"{axis.kind} ({counted(len(axis.values), 'value')})" for axis in study.axes
    )
    facts = (
        varied,
        f"{len(study.points)} of {counted(study.wanted, 'design')}",
        f"{len(study.front)} on the front",
        f"{study.runtime_s:.3g} s",
    )
    table = CardTable.of(enumerate(study.points), design_columns(study), texts=0)
    return Card("DesignStudy", f"of {study.instance.name!r}", facts, (), (table,))


def of_design_point(point: DesignPoint) -> Card:
    """The card of a point."""
    bound = f"{point.bound:,.6g}" if math.isfinite(point.bound) else "–"
    facts = (
        f"{point.worth:,.6g} avoided of at most {bound}",
        f"{point.euros / 1e6:,.2f} million euros",
        counted(point.launches, "launch", "launches"),
        counted(point.removals, "removal"),
    )
    return Card("DesignPoint", f"at {point.design.title}", facts)


def of_rehearsals(made: Rehearsals) -> Card:
    """The card of rehearsals; on a page, with the reasons of losses."""
    told = made.to_dict()
    facts = [counted(len(made.outcomes), "rehearsal"), f"by {made.policy}"]
    if made.outcomes:
        facts.append(f"prize {told['prize']['mean']:.4g} of {made.plan.objective:g} planned")
    losses = tuple((reason, f"{mean:.3g} targets") for reason, mean in told["losses"].items())
    return Card("Rehearsals", f"of {made.instance.name!r}", tuple(facts), losses)


MENDED = {
    "leave-out": "mended without",
    "refuel": "repaired by refuelling before",
    "swap": "repaired by going later to",
}
MOST_MENDINGS = 3


def of_tradeoff(made: Tradeoff) -> Card:
    """The card of a trade-off; on a page, with its points."""
    from ..report.traded import point_columns

    varied = " and ".join(
        f"{axis.kind} ({counted(len(axis.values), 'value')})" for axis in made.axes
    )
    facts = (
        varied,
        counted(len(made.points), "point"),
        f"{made.proven} proven",
        f"{made.runtime_s:.3g} s",
    )
    table = CardTable.of(((point,) for point in made.points), point_columns(made), texts=0)
    return Card("Tradeoff", f"of {made.instance.name!r}", facts, (), (table,))


def _prize(value: float) -> str:
    return f"{value:g}" if math.isfinite(value) else "–"


def of_point(point: Point) -> Card:
    """The card of a point."""
    said = f"prize {_prize(point.prize)} of at most {_prize(point.upper_bound)}"
    facts = [said, point.status]
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
    from ..report.compared import FIGURES

    facts = (counted(len(made.sides), "plan"),)
    columns: dict[str, Callable[[Side], str]] = {"plan": lambda side: side.name, **FIGURES}
    table = CardTable.of(((side,) for side in made.sides), columns)
    return Card("Comparison", f"on {made.instance.name!r}", facts, (), (table,))


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
