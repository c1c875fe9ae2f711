"""Cards of plans, routes, legs, results, refined plans and certificates."""

from __future__ import annotations

import itertools
import math
from collections.abc import Callable
from typing import TYPE_CHECKING

from ...common.card import Card, CardTable, days, order_words
from ...common.wording import counted, proof_words

if TYPE_CHECKING:
    from ...fly.refine.loop import RefinedResult
    from ...mission.result import Result
    from ...plan.certificate import Certificate
    from ...plan.plan import Leg, Plan, Route
    from ...plan.refined_plan import RefinedLeg, RefinedPlan


def of_result(result: Result) -> Card:
    """The card of a result: prize, proof, and the order by names."""
    plan, bounded = result.plan, math.isfinite(result.upper_bound)
    facts = []
    if plan is not None:
        facts.append(f"prize {result.objective:g}")
    if bounded:
        facts.append(f"at most {result.upper_bound:g}")
    facts.append(result.status if plan is None else proof_words(result.status, plan.cost_status))
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
    columns: dict[str, Callable[[RefinedLeg], str]] = {
        "from": lambda leg: leg.origin,
        "to": lambda leg: leg.destination,
        "leg": lambda leg: f"{leg.leg}",
        "arrives day": lambda leg: days(leg.arrival_s),
        "planned m/s": lambda leg: f"{leg.planned_delta_v_m_s:,.1f}",
        "flown m/s": lambda leg: f"{leg.flown_delta_v_m_s:,.1f}",
        "off m": lambda leg: f"{leg.residual_m:.1e}",
    }
    table = CardTable.of(((leg,) for leg in refined.legs), columns, texts=2)
    details = tuple((f"leg {one.leg} is missing", one.reason) for one in refined.missing)
    said = f"for {refined.instance.name!r}"
    return Card("RefinedPlan", said, facts, details, (table,))


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
        "no plan keeps all rules" if bound is None else f"no plan collects more than {bound:g}",
        counted(len(certificate.multipliers), "multiplier"),
        counted(len(certificate.walks), "kind of walks", "kinds of walks"),
    )
    said = f"for {certificate.instance.name!r} by {certificate.method!r}"
    return Card("Certificate", said, facts)


def legs_table(routes: tuple[Route, ...]) -> CardTable:
    """All legs, in order, with times in days."""
    columns: dict[str, Callable[[str, int, Leg], str]] = {
        "chaser": lambda chaser, at, leg: chaser,
        "from": lambda chaser, at, leg: leg.origin,
        "to": lambda chaser, at, leg: leg.destination,
        "leg": lambda chaser, at, leg: f"{at}",
        "leaves day": lambda chaser, at, leg: days(leg.leaves_s),
        "arrives day": lambda chaser, at, leg: days(leg.arrival_s),
        "free day": lambda chaser, at, leg: days(leg.done_s),
        "ΔV m/s": lambda chaser, at, leg: f"{leg.spent_m_s:,.1f}",
        "left m/s": lambda chaser, at, leg: f"{leg.delta_v_left_m_s:,.1f}",
    }
    if len(routes) < 2:
        del columns["chaser"]
    numbers = itertools.count(1)
    legs = ((route.chaser, next(numbers), leg) for route in routes for leg in route.legs)
    return CardTable.of(legs, columns, texts=3 if len(routes) > 1 else 2)


def certified(plan: Plan) -> tuple[str, ...]:
    """Prize, cost and proven quality of a plan."""
    bound = "" if plan.upper_bound is None else f" of at most {plan.upper_bound:g}"
    return (
        f"prize {plan.objective:g}{bound}",
        proof_words(plan.status, plan.cost_status),
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
        gap = "" if plan.cost_gap is None else f", gap {plan.cost_gap:.1%}"
        details.append(("cost", f"{plan.cost:,.6g} of at least {plan.cost_bound:,.6g}{gap}"))
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
    burns = [
        (burn.phase, f"{burn.time_s:,.1f}", f"{burn.size_m_s:,.3f}") for burn in leg.all_impulses
    ]
    tables = (CardTable(("burn", "time s", "ΔV m/s"), burns),) if burns else ()
    return Card("Leg", f"{leg.origin!r} → {leg.destination!r}", tuple(facts), (), tables)
