"""One design: planned with floors, bounded with worths alone, and its set evaluated."""

from __future__ import annotations

import math
import time
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from ...common.stop import Stop
from ...mission.certified import certify_routes
from ...mission.problem import Problem
from ...mission.result import Result
from ...plan.plan import Plan
from ...plan.routes import routes_of
from ...problem.instance import Instance
from ...run.front import solve
from ...run.method_call import spec_of
from ...run.reused_timetable import Reused
from .budget import cut_to_budget
from .designs import Design, designed
from .point import DesignPoint
from .prices import Prices
from .rating import Rating

ROUNDED = 1e-9
"""Relative excess of a worth over its bound that sums of floats may cause."""


class BrokenBound(RuntimeError):
    """A plan avoids more than a bound that claims to be proven: a method is wrong."""


@dataclass(frozen=True)
class DesignWork:
    """Data from which each design is run, in this process or elsewhere.

    Attributes
    ----------
    instance : Instance
        That designs vary, with targets of known worth alone.
    rating : Rating
    prices : Prices
    method : str
    time_limit_s : float
        Of the plan, and again of the bound [s].
    seed : int
    """

    instance: Instance
    rating: Rating
    prices: Prices
    method: str
    time_limit_s: float
    seed: int

    def instance_of(self, design: Design) -> Instance:
        """The instance of a design, with floors as prizes and without launches beyond its budget.

        Raises
        ------
        InputError
            A value is not valid.
        """
        made = self.prices.applied(designed(self.instance, design))
        budget = design.value("budget")
        if budget is not None:
            made = self.prices.affordable(made, budget)
        return self.rating.planned(made)

    def point(
        self,
        design: Design,
        instance: Instance,
        plan: Plan | None,
        bound: float,
        runtime_s: float = 0.0,
        cpu_s: float = 0.0,
    ) -> DesignPoint:
        """A design with a plan, evaluated.

        Raises
        ------
        BrokenBound
            The plan avoids more than the bound.
        """
        chosen = () if plan is None else _targets(instance, plan)
        worth = self.rating.worth_of(instance, chosen)
        if worth > bound * (1.0 + ROUNDED):
            raise BrokenBound(
                f"at {design.title} a plan avoids {worth!r}, more than the bound {bound!r}: a "
                "method is broken, please report it"
            )
        flown = () if plan is None else routes_of(instance, plan)
        return DesignPoint(
            design, instance, plan,
            floor=self.rating.floor_of(instance, chosen),
            worth=worth,
            bound=max(bound, worth),
            euros=0.0 if plan is None else self.prices.of_plan(instance, plan),
            launches=sum(bool(each.legs) for each in flown),
            removals=len(chosen),
            runtime_s=runtime_s,
            cpu_s=cpu_s,
        )  # fmt: skip


def run_design(
    work: DesignWork, design: Design, *, alone: bool = False, stop: Stop | None = None
) -> DesignPoint:
    """Plan, bound and evaluate a design.

    Parameters
    ----------
    work : DesignWork
    design : Design
    alone : bool
        Whether methods may use all cores.
    stop : Stop, optional

    Raises
    ------
    InputError
        The design or the method does not fit.
    """
    began, cpu_began = time.perf_counter(), time.process_time()
    instance = work.instance_of(design)
    budget = design.value("budget") or math.inf
    plan, bound = None, 0.0
    if work.prices.least(instance) <= budget:
        tables = Reused()
        problem = tables.problem(instance)
        first = _solved(work, problem, None, alone=alone, stop=stop)
        last, plans = first, [first.plan]
        if work.rating.worths is not None:
            rated = tables.problem(work.rating.bounded(instance))
            last = _solved(work, rated, first.plan, alone=alone, stop=stop)
            plans.append(last.plan)
        if last.status != "infeasible":
            bound = min(last.upper_bound * work.rating.step, work.rating.most)
        within = [_within(work, problem, made, budget) for made in plans if made is not None]
        fit = [made for made in within if made is not None]
        plan = max(fit, key=lambda made: _merit(work, instance, made), default=None)
    return work.point(
        design, instance, plan, bound, time.perf_counter() - began,
        time.process_time() - cpu_began,
    )  # fmt: skip


def _solved(
    work: DesignWork, problem: Problem, known: Plan | None, *, alone: bool, stop: Stop | None
) -> Result:
    method = spec_of(work.method)
    more: dict[str, Any] = {}
    if method.starts and known is not None and known.legs:
        routes = _in_order(problem.instance, known.orders)
        more = {"start": routes if len(routes) > 1 else routes[0], "repair": True}
    if not alone and method.uses_cores:
        more["jobs"] = 1
    return solve(
        problem, work.method, time_limit=work.time_limit_s, seed=work.seed, stop=stop, **more
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
    if len(instance.chasers) == 1:  # an only chaser, whatever it is called
        return (tuple(next(iter(orders.values()), ())),)
    return tuple(tuple(orders.get(chaser.name, ())) for chaser in instance.chasers)


def _merit(work: DesignWork, instance: Instance, plan: Plan) -> tuple[float, float]:
    worth = work.rating.worth_of(instance, _targets(instance, plan))
    return worth, -work.prices.of_plan(instance, plan)


def _targets(instance: Instance, plan: Plan) -> tuple[str, ...]:
    return tuple(body for body in plan.destinations if body not in instance.station_names)
