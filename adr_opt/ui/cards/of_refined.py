"""Cards of refined plans and of certificates."""

from __future__ import annotations

from typing import TYPE_CHECKING

from ...common.card import Card, CardTable, days
from ...common.wording import counted

if TYPE_CHECKING:
    from ...fly.refine.loop import RefinedResult
    from ...plan.certificate import Certificate
    from ...plan.refined_plan import RefinedPlan


def of_refined(refined: RefinedPlan) -> Card:
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
    tables = () if made.refined is None else of_refined(made.refined).tables
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
