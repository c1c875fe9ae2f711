"""Cards of plans, routes and legs."""

from __future__ import annotations

from typing import TYPE_CHECKING

from ...common.card import Card, CardTable, days, order_words
from ...common.wording import counted

if TYPE_CHECKING:
    from ...plan.plan import Leg, Plan, Route

HEADS = (
    "chaser",
    "from",
    "to",
    "leg",
    "leaves day",
    "arrives day",
    "free day",
    "ΔV m/s",
    "left m/s",
)


def legs_table(routes: tuple[Route, ...]) -> CardTable:
    """All legs, in order, with times in days."""
    rows, number = [], 0
    for route in routes:
        for leg in route.legs:
            number += 1
            rows.append(
                (
                    route.chaser,
                    leg.origin,
                    leg.destination,
                    f"{number}",
                    days(leg.leaves_s),
                    days(leg.arrival_s),
                    days(leg.done_s),
                    f"{leg.spent_m_s:,.1f}",
                    f"{leg.delta_v_left_m_s:,.1f}",
                )
            )
    table = CardTable(HEADS, rows, texts=3)
    if len(routes) > 1:
        return table
    return CardTable(HEADS[1:], [row[1:] for row in rows], texts=2)


def certified(plan: Plan) -> tuple[str, ...]:
    """Prize, cost and proven quality of a plan."""
    bound = "" if plan.upper_bound is None else f" of at most {plan.upper_bound:g}"
    return (
        f"prize {plan.objective:g}{bound}",
        plan.status,
        counted(len(plan.legs), "leg"),
        f"{plan.delta_v_m_s:,.1f} m/s",
    )


def details_of(plan: Plan) -> tuple[tuple[str, str], ...]:
    """Further details of a plan, for pages."""
    details = [
        ("order" if len(plan.routes) < 2 else route.chaser, order_words(names) or "stays")
        for route, names in zip(plan.routes, plan.orders.values(), strict=True)
    ]
    if plan.cost_bound is not None:
        details.append(("cost", f"{plan.cost:,.6g} of at least {plan.cost_bound:,.6g}"))
    left_out = plan.unvisited
    if left_out:
        why: dict[str, int] = {}
        for one in left_out:
            why[one.reason] = why.get(one.reason, 0) + 1
        said = ", ".join(f"{reason} {count}" for reason, count in sorted(why.items()))
        details.append(("left out", f"{counted(len(left_out), 'target')}: {said}"))
    details += [("note", note) for note in plan.notes]
    return tuple(details)


def of_plan(plan: Plan) -> Card:
    """The card of a plan."""
    said = f"for {plan.instance.name!r} by {plan.method!r}"
    return Card("Plan", said, certified(plan), details_of(plan), (legs_table(plan.routes),))


def of_route(route: Route) -> Card:
    """The card of a route."""
    names = order_words(leg.destination for leg in route.legs)
    facts = (counted(len(route.legs), "leg"), *((names,) if names else ()))
    return Card("Route", f"of {route.chaser!r}", facts, (), (legs_table((route,)),))


def of_leg(leg: Leg) -> Card:
    """The card of a leg; on a page, with its burns."""
    facts = [
        leg.kind,
        f"leaves on day {days(leg.leaves_s)}",
        f"arrives on day {days(leg.arrival_s)}",
        f"{leg.spent_m_s:,.1f} m/s",
        f"{leg.delta_v_left_m_s:,.1f} m/s left",
    ]
    if leg.removal_burns:
        facts.append("with a tow")
    burns = [(burn.phase, f"{burn.time_s:,.1f}", f"{burn.size_m_s:,.3f}") for burn in leg.all_burns]
    tables = (CardTable(("burn", "time s", "ΔV m/s"), burns),) if burns else ()
    return Card("Leg", f"{leg.origin!r} → {leg.destination!r}", tuple(facts), (), tables)
