"""Check of a least ΔV: that no walk worth enough takes less.

Walks are those of :mod:`.walks`, and pay for their ΔV and, where that has a price, for the time
until they end. A plan that is worth W or more and costs less than C counts more than λ W − C at a
price λ of worth, and it is a walk. So if no walk that is worth as much counts as much, there is no
such plan.
"""

from __future__ import annotations

from fractions import Fraction
from typing import NamedTuple

from ...legs.connection_finder import ConnectionFinder
from ...plan.certificate import Certificate, ProvenCost
from ...plan.plan import Plan
from ...problem.instance import Instance
from .claim import remembered, worths_of
from .legs import legs_of
from .walks import LeastWorth, walks_reach

SLACK = Fraction(1, 10**10)
"""Share by which a walk may be worth less, so that no rounding of a sum of prizes counts."""

RELATIVE = 1e-6
"""Share of a bound up to which costs are the same."""


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
    """Why the cost of an instance is not yet verifiable; None if it is."""
    if len(instance.chasers) > 1:
        return "there are several chasers"
    if instance.objective.cost != "delta-v":
        return "it is not ΔV"
    if instance.mission.mission_separation_s is not None:
        return "missions are one after another"
    if any(target.removal != "visit" for target in instance.targets):
        return "targets are removed by kits or tows"
    return None


def judged_cost(
    instance: Instance, plan: Plan | None, certificate: Certificate, connecting: ConnectionFinder
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
    """
    cost = certificate.cost
    if cost is None:
        return NOTHING
    obstacle = why_unverifiable(instance)
    if obstacle is not None:
        return CostVerdict(None, 0, (f"the cost part is not yet verifiable: {obstacle}",))
    reached, labels = _walks_cost_less(instance, certificate, cost, connecting)
    if reached:
        said = f"a walk that is worth enough may cost less than {cost.bound:g} m/s"
        return CostVerdict(None, labels, (f"{said}, but the certificate says that none does",))
    return CostVerdict(cost.bound, labels, tuple(_compared(plan, cost)))


def _walks_cost_less(
    instance: Instance, certificate: Certificate, cost: ProvenCost, connecting: ConnectionFinder
) -> tuple[bool, int]:
    """Whether a walk worth enough costs less than the bound, and how many labels that took."""
    if cost.bound <= 0.0:
        return False, 0  # nothing costs less than nothing
    (chaser,) = instance.chasers
    legs = legs_of(instance, chaser, connecting)
    worths, price = worths_of(instance, certificate), Fraction(cost.per_prize)
    required = sum(target.required for target in instance.targets)
    least = Fraction(cost.prize) + required * Fraction(certificate.required_worth)
    least -= SLACK * abs(least)
    # Walks pay on their first leg for what the tank lacks at the start, and plans do not.
    most = Fraction(cost.bound) + Fraction(
        connecting.spent_m_s(instance.names.index(chaser.start_name))
    )
    answer = walks_reach(
        legs, [price * each for each in worths], remembered(instance, cost.neighbourhoods),
        price * least - most, certificate.delta_v_slot_m_s,
        paying=LeastWorth(worths, least, instance.time_m_s_per_s),
    )  # fmt: skip
    return answer.reached, answer.labels


def _compared(plan: Plan | None, cost: ProvenCost) -> list[str]:
    """Claims of a plan beyond what was verified."""
    if plan is None or plan.cost_bound is None:
        return []
    if plan.objective < cost.prize * (1.0 - RELATIVE):
        return [f"the cost part is on plans that collect {cost.prize:.15g}, and this one does not"]
    follows = f"none costs less than {cost.bound:.15g} m/s"
    if plan.cost < cost.bound * (1.0 - RELATIVE):
        return [f"the plan costs {plan.cost:.15g} m/s, but {follows}: one of them is wrong"]
    if plan.cost_bound > cost.bound * (1.0 + RELATIVE):
        stated = f"the plan states the bound {plan.cost_bound:.15g} m/s on its cost"
        return [f"{stated}; it only follows that {follows}"]
    return []
