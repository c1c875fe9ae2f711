"""Cards of plans, routes, legs, results, refined plans and certificates."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

from ...common.card import Card, CardTable, days, order_words
from ...common.wording import counted

if TYPE_CHECKING:
    from ...fly.refine.loop import RefinedResult
    from ...mission.result import Result
    from ...plan.certificate import Certificate
    from ...plan.plan import Leg, Plan, Route
    from ...plan.refined_plan import RefinedPlan


def of_result(result: Result) -> Card:
    """The card of a result: prize, proof, and the order by names."""
    plan, bounded = result.plan, math.isfinite(result.upper_bound)
    facts = []
    if plan is not None:
        facts.append(f"prize {result.objective:g}")
    if bounded:
        facts.append(f"at most {result.upper_bound:g}")
    facts.append(result.status)
    if plan is not None:
        facts += [counted(len(plan.legs), "leg"), f"{plan.delta_v_m_s:,.1f} m/s"]
    facts.append(f"{result.runtime_s:.3g} s")
    if plan is not None and len(plan.routes) == 1 and plan.destinations:
        facts.append(order_words(plan.destinations))
    said = f"of {result.method!r}"
    if plan is None:
        return Card("Result", said, tuple(facts), tuple(("note", each) for each in result.notes))
    said += f" on {plan.instance.name!r}"
    details = [each for each in details_of(plan) if each[0] != "note"]
    details += [("note", note) for note in result.notes]
    details += [(name, f"{count:g}") for name, count in result.counters.items()]
    return Card("Result", said, tuple(facts), tuple(details), (legs_table(plan.routes),))


def of_refined_plan(refined: RefinedPlan) -> Card:
    """The card of a refined plan; on a page, with planned and flown legs."""
    facts: tuple[str, ...] = (
        refined.status,
        counted(len(refined.legs), "leg"),
        f"planned {refined.planned_delta_v_m_s:,.1f} m/s",
        f"flown {refined.flown_delta_v_m_s:,.1f} m/s",
        refined.gravity,
    )
    if refined.ephemerides is not None:
        facts = (*facts, "onto ephemerides", f"holding {refined.holding_m_s:,.1f} m/s")
    rows = [
        (
            leg.origin,
            leg.destination,
            f"{leg.leg}",
            days(leg.arrival_s),
            f"{leg.planned_delta_v_m_s:,.1f}",
            f"{leg.flown_delta_v_m_s:,.1f}",
            f"{leg.residual_m:.1e}",
        )
        for leg in refined.legs
    ]
    heads = ("from", "to", "leg", "arrives day", "planned m/s", "flown m/s", "off m")
    details = tuple((f"leg {one.leg} is missing", one.reason) for one in refined.missing)
    said = f"for {refined.instance.name!r}"
    return Card("RefinedPlan", said, facts, details, (CardTable(heads, rows, texts=2),))


def of_refined_result(made: RefinedResult) -> Card:
    """The card of a plan refined until it holds."""
    facts = ["it holds" if made.holds else made.reason, counted(len(made.rounds), "round")]
    if made.plan is not None:
        facts.append(f"prize {made.plan.objective:g}")
    tables = () if made.refined is None else of_refined_plan(made.refined).tables
    details = tuple(("", str(each)) for each in made.rounds)
    return Card("RefinedResult", f"of {made.result.method!r}", tuple(facts), details, tables)


def of_certificate(certificate: Certificate) -> Card:
    """The card of a certificate."""
    bound = certificate.upper_bound
    facts = (
        "no plan keeps to all rules" if bound is None else f"no plan collects more than {bound:g}",
        counted(len(certificate.multipliers), "multiplier"),
        counted(len(certificate.walks), "kind of walks", "kinds of walks"),
    )
    said = f"for {certificate.instance.name!r} by {certificate.method!r}"
    return Card("Certificate", said, facts)


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
