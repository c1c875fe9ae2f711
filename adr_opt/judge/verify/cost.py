"""Check of a lower bound on ΔV: no walk that is worth enough, or set of walks, takes less.

Walks are those of :mod:`.walk_questions`, and pay for their ΔV, that of tows included, and, where
that has a price, for the time until they end. A plan that is worth W or more and costs less than C
counts more than λ W − C at a price λ of worth, and its routes are walks. So if no walk of a single
chaser that is worth as much counts as much, there is no such plan.

Of several chasers the walks pay multipliers π and cuts σ besides, once each for all routes of a
plan together: it counts more than λ W − C − Σ π − Σ σ, and there is no such plan if the most of
their walks add up to no more.
"""

from __future__ import annotations

from fractions import Fraction
from typing import NamedTuple

from ...legs.connection_finder import ConnectionFinder
from ...plan.certificate import Certificate, ProvenCost, ProvenWalks
from ...plan.plan import Plan
from ...problem.chasers import Chaser
from ...problem.drives import drive_of
from ...problem.instance import Instance
from ..check.towed import towed_bodies
from .claim import difference_of, remembered, worths_of
from .legs import legs_of
from .lists import Lists
from .walk_questions import Paying, WalkAnswer, refuted, walk_question, walks_reach

SLACK, LEAST_SLACK = Fraction(1, 10**10), Fraction(1, 2**50)
"""Share by which the worth of walks may fall short, to cover rounding in sums of prizes, and its
least value where that share would admit plans of other worth."""

RELATIVE = 1e-6
"""Relative tolerance between costs."""


class CostVerdict(NamedTuple):
    """The findings.

    Attributes
    ----------
    bound : float or None
        What no plan that collects as much costs less than, if that was verified [m/s].
    labels : int
    reasons : tuple of str
        Claims that do not follow.
    """

    bound: float | None
    labels: int
    reasons: tuple[str, ...]


NOTHING = CostVerdict(None, 0, ())


def why_unverifiable(instance: Instance) -> str | None:
    """Why the cost of an instance cannot be verified yet; None if it can."""
    if instance.objective.cost != "delta-v":
        return "the cost is not ΔV"
    if instance.mission.mission_separation_s is not None:
        return "missions are flown one after another"
    return None


def judged_cost(
    instance: Instance,
    plan: Plan | None,
    certificate: Certificate,
    connecting: ConnectionFinder,
    lists: Lists,
) -> CostVerdict:
    """Verify the cost part of a certificate, and what a plan states about its cost.

    Parameters
    ----------
    instance : Instance
    plan : Plan or None
        None for the bound alone.
    certificate : Certificate
        Names bodies of the instance.
    connecting : ConnectionFinder
    lists : Lists
        Where lists of closed labels may be, and are noted.
    """
    cost = certificate.cost
    if cost is None:
        return NOTHING
    obstacle = why_unverifiable(instance)
    if obstacle is not None:
        return CostVerdict(None, 0, (f"the cost part cannot be verified yet: {obstacle}",))
    least, labels = _least_worth(instance, certificate, cost), 0
    worth = Fraction(cost.per_prize) * least
    paid = [Fraction(each) for each in cost.multipliers.values()]
    paid += [Fraction(cut.multiplier) for cut in cost.cuts]
    # Who stays where it is counts nothing.
    paid += [len(walks.chasers) * max(Fraction(walks.most), Fraction(0)) for walks in cost.walks]
    if cost.walks and Fraction(cost.bound) > worth - sum(paid):
        why = f"its walks do not prove that no plan costs less than {cost.bound:g} m/s"
        return CostVerdict(None, 0, (why,))
    paying = Paying(instance.time_m_s_per_s)
    claims = [
        _Claim(
            walks,
            max(Fraction(walks.most), Fraction(0)),
            paying,
            f"a walk of {{}} comes to {walks.most:g} m/s less what it costs",
        )
        for walks in cost.walks
    ]
    if not cost.walks and cost.bound > 0.0:  # nothing costs less than nothing
        paying = Paying(instance.time_m_s_per_s, worths_of(instance, certificate), least)
        names = tuple(chaser.name for chaser in instance.chasers)
        walks = ProvenWalks(chasers=names, most=0.0, neighbourhoods=cost.neighbourhoods)
        said = f"a walk that is worth enough may cost less than {cost.bound:g} m/s"
        claims = [_Claim(walks, worth - Fraction(cost.bound), paying, said)]
    for claim in claims:

        def answer(chaser: Chaser, own: ConnectionFinder, claim: _Claim = claim) -> WalkAnswer:
            question = walk_question(
                legs_of(instance, chaser, own),
                _counts(instance, certificate, cost, chaser),
                remembered(instance, claim.walks.neighbourhoods),
                claim.most - _spent(instance, chaser, own),
                certificate.delta_v_slot_m_s,
                cost.cuts,
                claim.paying,
            )
            return walks_reach(question, lists)

        made, _, reason = refuted(instance, claim.walks.chasers, connecting, claim.said, answer)
        labels += made
        if reason is not None:
            return CostVerdict(None, labels, (reason,))
    return CostVerdict(cost.bound, labels, tuple(_compared(plan, cost)))


class _Claim(NamedTuple):
    """A claim on walks: the amount that none reaches, their payments, and a message if one does."""

    walks: ProvenWalks
    most: Fraction
    paying: Paying
    said: str


def _least_worth(instance: Instance, certificate: Certificate, cost: ProvenCost) -> Fraction:
    """Least worth of the plans that the claim is about."""
    required = sum(target.required for target in instance.targets)
    least = Fraction(cost.prize) + required * Fraction(certificate.required_worth)
    # Beside large prizes a share of them is more than a small one: who collects less is not meant.
    other = Fraction(difference_of(instance, certificate)) / 2
    return least - min(SLACK * abs(least), max(other, LEAST_SLACK * abs(least)))


def _counts(
    instance: Instance, certificate: Certificate, cost: ProvenCost, chaser: Chaser
) -> list[Fraction]:
    """Value of a service of each body: its worth at the price, less its tow and multiplier."""
    price = Fraction(cost.per_prize)
    counts = [price * each for each in worths_of(instance, certificate)]
    for name, multiplier in cost.multipliers.items():
        counts[instance.names.index(name)] -= Fraction(multiplier)
    drive = drive_of(chaser, instance.targets)
    for name, tow in towed_bodies(instance, instance.orbits(), drive).items():
        counts[instance.names.index(name)] -= Fraction(tow.delta_v_m_s)
    return counts


def _spent(instance: Instance, chaser: Chaser, connecting: ConnectionFinder) -> Fraction:
    """ΔV that walks pay on the first leg for a tank not full at the start; plans do not pay it."""
    if chaser.is_launched:  # no leg leads onto its first target
        return Fraction(0)
    return Fraction(connecting.spent_m_s(instance.names.index(chaser.start_name)))


def _compared(plan: Plan | None, cost: ProvenCost) -> list[str]:
    """Claims of a plan beyond what was verified."""
    if plan is None or plan.cost_bound is None:
        return []
    if plan.objective < cost.prize * (1.0 - RELATIVE):
        return [f"the cost part is about plans that collect {cost.prize:.15g}; this one does not"]
    follows = f"none costs less than {cost.bound:.15g} m/s"
    if plan.cost < cost.bound * (1.0 - RELATIVE):
        return [f"the plan costs {plan.cost:.15g} m/s, but {follows}: one of them is wrong"]
    if plan.cost_bound > cost.bound * (1.0 + RELATIVE):
        stated = f"the plan states the bound {plan.cost_bound:.15g} m/s on its cost"
        return [f"{stated}; it only follows that {follows}"]
    return []
