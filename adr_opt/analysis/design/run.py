"""One design: planned with floors, bounded with worths alone, and its set evaluated.

Plans are cut down to a budget: the last targets of routes, or whole launches, are left out.
"""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from ...common.stop import AnyOf, Proven
from ...mission.certified import certify_routes
from ...mission.problem import Problem
from ...mission.result import Result
from ...plan.plan import Plan
from ...plan.routes import routes_of
from ...problem.instance import Instance
from ...run.front import solve
from ...run.method_call import spec_of
from ...run.reused_timetable import Reused
from ...study import Place
from .designs import Design
from .prices import CampaignPrices, Legs, Spending
from .rating import Rating
from .results import DesignPoint
from .work import DesignWork, targets_of


@dataclass(frozen=True)
class _Cut:
    """A shorter route of one chaser, with its saving and its loss of worth."""

    chaser: str
    legs: Legs
    saved: float
    lost: float


def cut_to_budget(
    instance: Instance, plan: Plan, prices: CampaignPrices, rating: Rating, budget: float
) -> dict[str, tuple[str, ...]] | None:
    """Orders of a plan cut down to a budget; None if nothing is left.

    The cut that loses the least for each euro is made first, or else the one that loses the least;
    the better outcome of both counts. The beginning of a route can be flown
    as before, so that only the ends of routes are cut, and whole routes.

    Parameters
    ----------
    instance : Instance
        With the prices applied.
    plan : Plan
    prices : CampaignPrices
    rating : Rating
    budget : float
        [euros].

    Returns
    -------
    dict of str to tuple of str, or None
        Bodies in order, by name of the chaser.
    """
    best: dict[str, Legs] | None = None
    most = -math.inf
    for order in (_by_ratio, _by_loss):
        routes = _cut(instance, plan, prices, rating, budget, order)
        if routes is not None and any(routes.values()):
            chosen = [body for legs in routes.values() for body in _targets(instance, legs)]
            worth = rating.worth_of(instance, chosen)
            if worth > most:
                best, most = routes, worth
    if best is None:
        return None
    return {name: tuple(body for body, _ in legs) for name, legs in best.items()}


def _by_ratio(cut: _Cut) -> tuple[float, float]:
    return cut.lost / cut.saved, cut.lost


def _by_loss(cut: _Cut) -> tuple[float, float]:
    return cut.lost, -cut.saved


def _cut(
    instance: Instance,
    plan: Plan,
    prices: CampaignPrices,
    rating: Rating,
    budget: float,
    order: Callable[[_Cut], tuple[float, float]],
) -> dict[str, Legs] | None:
    """Routes after as many cuts as the budget asks for, the first in order each time."""
    routes: dict[str, Legs] = {
        flown.chaser.name: flown.spent for flown in routes_of(instance, plan)
    }
    while _euros(instance, routes, prices) > budget:
        cuts = [
            cut
            for name, legs in routes.items()
            if legs
            for cut in _cuts(instance, routes, name, prices, rating)
        ]
        if not cuts:
            return None
        best = min(cuts, key=order)
        routes[best.chaser] = best.legs
    return routes


def _euros(instance: Instance, routes: Mapping[str, Legs], prices: CampaignPrices) -> float:
    return math.fsum(
        prices.of_route(instance, chaser, routes[chaser.name])
        for chaser in instance.chasers
        if chaser.name in routes
    )


def _cuts(
    instance: Instance,
    routes: Mapping[str, Legs],
    name: str,
    prices: CampaignPrices,
    rating: Rating,
) -> list[_Cut]:
    """Shorter routes of a chaser that cost less: one target less, or none at all."""
    chaser = next(each for each in instance.chasers if each.name == name)
    legs = routes[name]
    shorter: list[Legs] = [()]
    if chaser.end == "anywhere":
        shorter.append(_without_last_target(instance, legs))
    required = {target.name for target in instance.targets if target.required}
    spent, there = prices.of_route(instance, chaser, legs), _targets(instance, legs)
    others = [
        body
        for other, flown in routes.items()
        if other != name
        for body in _targets(instance, flown)
    ]
    before = rating.worth_of(instance, (*others, *there))
    found = []
    for rest in shorter:
        left = _targets(instance, rest)
        saved = spent - prices.of_route(instance, chaser, rest)
        if saved > 0.0 and required.isdisjoint(set(there) - set(left)):
            lost = before - rating.worth_of(instance, (*others, *left))
            found.append(_Cut(name, rest, saved, lost))
    return found


def _without_last_target(instance: Instance, legs: Legs) -> Legs:
    """The legs before the last target, without stations that would then be superfluous."""
    rest = list(legs)
    while rest and rest[-1][0] in instance.station_names:
        rest.pop()
    rest = rest[:-1]
    while rest and rest[-1][0] in instance.station_names:
        rest.pop()
    return rest


def _targets(instance: Instance, legs: Sequence[tuple[str, float]]) -> list[str]:
    return [body for body, _ in legs if body not in instance.station_names]


def run_design(work: DesignWork, design: Design, place: Place) -> DesignPoint:
    """Plan, bound and evaluate a design.

    Parameters
    ----------
    work : DesignWork
    design : Design
    place : Place

    Raises
    ------
    InputError
        The design or the method does not fit.
    """
    began, cpu_began = time.perf_counter(), time.process_time()
    allowed = work.spending(design)
    budget = design.budget
    instance = work.rating.planned(work.priced(design) if allowed is None else allowed.planned)
    plan, bound = None, 0.0
    if allowed is not None:
        problem, plans, bound = _found(work, instance, allowed, place)
        within = [_within(work, problem, made, budget) for made in plans]
        fit = [made for made in within if made is not None]
        plan = max(fit, key=lambda made: _merit(work, instance, made), default=None)
    return work.point(
        design, instance, plan, bound, time.perf_counter() - began, time.process_time() - cpu_began
    )


def _found(
    work: DesignWork, instance: Instance, allowed: Spending, place: Place
) -> tuple[Problem, list[Plan], float]:
    """The problem of an instance, its plans regardless of budget, and the bound."""
    rating = work.rating
    tables = Reused()
    problem = tables.problem(instance)
    found = [_solved(work, problem, None, place)]
    if rating.worths is not None or allowed.bounded != allowed.planned:
        fewer = tables.problem(rating.bounded(allowed.bounded))
        found.append(_solved(work, fewer, found[0].plan, place))
    bound = 0.0
    if found[0].status != "infeasible":
        # Fewer launches may be too few for required targets, which says nothing of more.
        fits = found[-1].status != "infeasible"
        proven = found[-1].upper_bound * rating.step if fits else 0.0
        bound = min(max(proven, allowed.beyond), rating.most)
    return problem, [each.plan for each in found if each.plan is not None], bound


def _solved(work: DesignWork, problem: Problem, known: Plan | None, place: Place) -> Result:
    method = spec_of(work.method)
    more: dict[str, Any] = {}
    routes = () if known is None else _in_order(problem.instance, known.orders)
    if method.starts and any(routes):
        more = {"start": routes if len(routes) > 1 else routes[0], "repair": True}
    if not place.alone and method.uses_cores:
        more["jobs"] = 1
    stop = Proven() if place.stop is None else AnyOf(place.stop, Proven())
    return solve(
        problem, work.method, time_limit=work.time_limit_s, seed=work.seed, stop=stop, **more
    )


def _within(work: DesignWork, problem: Problem, plan: Plan, budget: float) -> Plan | None:
    """A plan of the problem with the orders of another plan, within a budget."""
    instance = problem.instance
    if work.prices.of_plan(instance, plan) > budget:
        orders = cut_to_budget(instance, plan, work.prices, work.rating, budget)
        if orders is None:
            return None
    elif plan.instance.is_of(instance):
        return plan
    else:
        orders = plan.orders
    routes = _in_order(instance, orders)
    made = certify_routes(problem, plan.method, routes, seed=plan.seed, runtime_s=plan.runtime_s)
    if made.plan is None or work.prices.of_plan(instance, made.plan) > budget:
        return None
    return made.plan


def _in_order(
    instance: Instance, orders: Mapping[str, Sequence[str]]
) -> tuple[tuple[str, ...], ...]:
    """Orders of all chasers as sequences, in the order of the instance."""
    if len(instance.chasers) == len(orders) == 1:  # an only chaser, whatever it is called
        return (tuple(next(iter(orders.values()))),)
    return tuple(tuple(orders.get(chaser.name, ())) for chaser in instance.chasers)


def _merit(work: DesignWork, instance: Instance, plan: Plan) -> tuple[float, float]:
    worth = work.rating.worth_of(instance, targets_of(instance, plan))
    return worth, -work.prices.of_plan(instance, plan)
