"""Checks of a plan's totals: model, objective, cost, and claims of optimality.

The common step of prizes decides whether an objective is optimal. It is worked out once more here:
see :mod:`adr_opt.common.tolerance` for what planners know.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from fractions import Fraction

from ...common.constants import DAY_S, SLACK_S
from ...plan.plan import FORMER_MODEL, Plan
from ...problem.instance import Instance
from .shared import expense, launch_times, over_s
from .violation import (
    DELTA_V_TOLERANCE_M_S,
    EXPENSE_TOLERANCE,
    OBJECTIVE_TOLERANCE,
    TIME_TOLERANCE_S,
    Violation,
)

MOST_STEPS = 2**46
"""Maximum number of steps in the sum of worths; beyond it, steps are not used."""

SHARE = 1e-11
"""Relative tolerance between objectives in that case, as a share of the sum of all prizes."""


SAFE = 1.0 - 1e-6
"""Share of the difference within which a bound must lie, to cover rounding."""


def is_met(objective: float, bound: float, difference: float) -> bool:
    """Whether no better objective fits within a bound.

    Parameters
    ----------
    objective, bound : float
    difference : float
        See :func:`difference_of`.
    """
    return bound - objective <= SAFE * difference


def collected(instance: Instance, plan: Plan) -> float:
    """Sum of the prizes of the targets that a plan visits.

    Of a prize that falls the first that its service does not outlast. A service with a tow ends
    when the tow does that follows it at once.
    """
    ends: dict[str, float] = {}
    for leg in plan.legs:
        towed_s = 0.0 if leg.tow is None else leg.tow.end_s - leg.tow.start_s
        ends.setdefault(leg.destination, leg.end_s + towed_s)
    found = []
    for target in instance.targets:
        if target.name in ends:
            levels = [
                prize
                for until_s, prize in target.prize_until or ()
                if ends[target.name] <= until_s + SLACK_S
            ]
            found.append(max(levels, default=target.prize))
    return math.fsum(found)


def difference_of(instance: Instance) -> float:
    """Least difference between two unequal objectives.

    All prizes, as they are written, are whole numbers of such steps. Where there are too many steps
    objectives count as equal that differ by less than :data:`SHARE` of the sum.
    """
    prizes = [prize for target in instance.targets for prize in target.prizes]
    written = [Fraction(repr(prize)) for prize in prizes if prize > 0.0]
    if not written:
        return 0.0
    total = sum(written)
    parts = math.lcm(*(prize.denominator for prize in written))
    step = Fraction(math.gcd(*(int(prize * parts) for prize in written)), parts)
    required = sum(target.required for target in instance.targets)
    if (1 + required) * (total + step) <= MOST_STEPS * step:
        return float(step)
    return SHARE * float(total)


def check_model(plan: Plan) -> Iterator[Violation]:
    """Refuse drift legs planned by the former model, in which phasing cost nothing."""
    if plan.has_former_drifts:
        yield Violation(
            None,
            "model",
            f"its drift legs were planned with version {plan.model} of the model, in which phasing "
            "was free; plan again",
        )


def check_totals(instance: Instance, plan: Plan) -> Iterator[Violation]:
    """Check the objective, the certificate and the list of unvisited targets."""
    prize = {target.name: target.greatest_prize for target in instance.targets}
    visited = {leg.destination for leg in plan.legs} & set(prize)
    difference = difference_of(instance)
    objective = collected(instance, plan)
    if abs(plan.objective - objective) > _off(objective, difference):
        yield Violation(
            None,
            "objective",
            f"objective = {plan.objective!r}, but the prizes sum to {objective!r}",
        )
    together = 0
    for chaser in instance.chasers:
        limits = {chaser.max_targets, len(prize)}
        if all(target.removal == "kit" for target in instance.targets):
            limits.add(chaser.kits)
        together += min(limit for limit in limits if limit is not None)
    least = math.fsum(sorted(prize.values(), reverse=True)[:together])
    if plan.upper_bound is not None:
        least = min(least, plan.upper_bound)
        if plan.objective > plan.upper_bound + _off(plan.upper_bound, difference):
            yield Violation(
                None, "bound", f"objective {plan.objective!r} exceeds bound {plan.upper_bound!r}"
            )
        gap = 0.0
        if plan.upper_bound > 0.0:
            gap = (plan.upper_bound - plan.objective) / plan.upper_bound
        slack = OBJECTIVE_TOLERANCE
        if plan.upper_bound > 0.0:
            slack = _off(plan.upper_bound, difference) / plan.upper_bound
        if plan.gap is None or abs(plan.gap - gap) > slack:
            yield Violation(None, "gap", f"gap = {plan.gap!r}, but it is {gap!r}")
    elif plan.gap is not None:
        yield Violation(None, "gap", "a gap is stated without an upper bound")
    # Nothing can be worth more than all prizes, whether a bound is stated or not.
    met = is_met(plan.objective, least, difference)
    if plan.status == "optimal" and not met:
        yield Violation(
            None,
            "status",
            f"optimal is stated, but the bound is {least!r}, not met: objectives differ by "
            f"{difference:g}",
        )
    elif plan.status == "feasible" and met:
        yield Violation(
            None, "status", f"feasible is stated, but the bound of {least!r} is met: it is optimal"
        )
    elif plan.status in ("infeasible", "unknown") and plan.legs:
        yield Violation(None, "status", f"{plan.status} is stated, but the plan has legs")
    stated = [entry.target for entry in plan.unvisited]
    for name in sorted(set(prize) - visited - set(stated)):
        yield Violation(None, "unvisited", f"{name!r} is neither visited nor listed")
    for name in sorted({name for name in stated if stated.count(name) > 1}):
        yield Violation(None, "unvisited", f"{name!r} is listed more than once")
    for name in sorted(set(stated) & visited):
        yield Violation(None, "unvisited", f"{name!r} is listed, but the plan visits it")
    for name in sorted(set(stated) - set(prize)):
        yield Violation(None, "unvisited", f"{name!r} is not a target of the instance")


def _off(figure: float, difference: float) -> float:
    """Tolerance of a figure, smaller than the least difference between objectives."""
    return min(OBJECTIVE_TOLERANCE * abs(figure), 0.25 * difference)


def check_cost(instance: Instance, plan: Plan) -> Iterator[Violation]:
    """Check the cost, as the instance counts it, and the claims about it."""
    if instance.objective.cost == "expense":
        cost = expense(instance, plan)
        slack = EXPENSE_TOLERANCE * cost
    elif instance.objective.cost == "duration":
        cost, slack = max([0.0, *(over_s(leg) for leg in plan.legs)]), TIME_TOLERANCE_S
    else:
        tows = [leg.tow.delta_v_m_s for leg in plan.legs if leg.tow is not None]
        cost = sum(leg.delta_v_m_s for leg in plan.legs) + sum(tows) + _time_m_s(instance, plan)
        slack = DELTA_V_TOLERANCE_M_S * (len(plan.legs) + len(tows))
    if abs(plan.cost - cost) > slack:
        yield Violation(None, "cost", f"cost = {plan.cost!r}, but it is {cost!r}")
    bound = plan.cost_bound
    if bound is not None:
        if plan.cost < bound - OBJECTIVE_TOLERANCE * abs(bound):
            yield Violation(
                None, "cost-bound", f"cost {plan.cost!r} is less than the bound {bound!r}"
            )
        gap = (plan.cost - bound) / plan.cost if plan.cost > 0.0 else 0.0
        if plan.cost_gap is None or abs(plan.cost_gap - gap) > OBJECTIVE_TOLERANCE:
            yield Violation(None, "cost-gap", f"cost_gap = {plan.cost_gap!r}, but it is {gap!r}")
        if plan.cost_status is None:
            yield Violation(None, "cost-status", "a bound of the cost is stated without a status")
    elif plan.cost_gap is not None:
        yield Violation(None, "cost-gap", "a gap of the cost is stated without a bound")
    # Nothing costs less than nothing, whether a bound is stated or not.
    most = max(0.0, bound or 0.0)
    met = plan.cost <= most + OBJECTIVE_TOLERANCE * most
    if plan.cost_status == "optimal" and not met:
        yield Violation(
            None, "cost-status", f"optimal is stated, but the bound is {most!r}, not met"
        )
    elif plan.cost_status == "feasible" and met:
        yield Violation(
            None,
            "cost-status",
            f"feasible is stated, but the bound of {most!r} is met: it is optimal",
        )
    elif plan.cost_status in ("infeasible", "unknown") and plan.legs:
        yield Violation(None, "cost-status", f"{plan.cost_status} is stated, but the plan has legs")


def _time_m_s(instance: Instance, plan: Plan) -> float:
    """Cost of the chasers' days, each from its availability to the end of its last leg.

    Where missions are separated, from the launch, whose time is a choice. A day has the price that
    the instance states, or else the ΔV resolution over the days of the mission. Plans of the former
    model were made before that, and given costs have no known unit.
    """
    mission_days = instance.mission.duration_s / DAY_S
    price = instance.objective.time_m_s_per_day
    if price is None:
        if plan.model == FORMER_MODEL or instance.transfer.given is not None or not mission_days:
            return 0.0
        price = instance.transfer.delta_v_resolution_m_s / mission_days
    launches, first = launch_times(instance), instance.chasers[0]
    chasers = {chaser.name: chaser for chaser in instance.chasers}
    over: dict[str, float] = {}
    since = {name: each.available_s[0] for name, each in chasers.items()} | launches
    for route in plan.routes:
        name = chasers.get(route.chaser, first).name
        for leg in route.legs:
            over[name] = max(over.get(name, 0.0), over_s(leg))
        if route.legs and instance.mission.mission_separation_s is not None:
            since[name] = route.legs[0].departure_s
    flown_s = sum(end - since[name] for name, end in over.items())
    return price * flown_s / DAY_S
