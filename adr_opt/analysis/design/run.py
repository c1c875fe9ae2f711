"""One design: planned with floors, bounded with worths alone, and its set evaluated."""

from __future__ import annotations

import time
from collections.abc import Mapping, Sequence
from typing import Any

from ...mission.certified import certify_routes
from ...mission.problem import Problem
from ...mission.result import Result
from ...plan.plan import Plan
from ...problem.instance import Instance
from ...run.front import solve
from ...run.method_call import spec_of
from ...run.reused_timetable import Reused
from ...study import Place
from .budget import cut_to_budget
from .designs import Design
from .point import DesignPoint
from .spending import Spending
from .work import DesignWork, targets_of


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
    """The problem of an instance, plans of it whatever they cost, and the bound."""
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
    return solve(
        problem, work.method, time_limit=work.time_limit_s, seed=work.seed, stop=place.stop, **more
    )


def _within(work: DesignWork, problem: Problem, plan: Plan, budget: float) -> Plan | None:
    """A plan of the problem's instance with the orders of another, within a budget."""
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
