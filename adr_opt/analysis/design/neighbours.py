"""What designs say of each other: plans that others can fly as well, bounds that hold for less."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import replace

from ...mission.certified import certify_routes
from ...mission.problem import problem_of
from ..priced import price
from .designs import Design
from .point import DesignPoint
from .work import DesignWork

TRIES = 3
"""Most plans of other designs that are tried for one design, the best first."""

INCLUDING = ("launches", "kits", "budget")
"""Kinds of which a larger value allows all plans of a smaller one."""

SURELY = 1e-9
"""Relative difference between worths that counts."""


def with_neighbours(work: DesignWork, points: Sequence[DesignPoint]) -> list[DesignPoint]:
    """Points with bounds and plans of other designs, where those are better and hold for them.

    A bound holds for each design with fewer launches, fewer kits or a smaller budget that is the
    same otherwise. The plans of designs that differ in one value are timed anew on the instance of
    a design; where they can be flown within its budget the best of them counts.
    """
    tight = [
        replace(
            point,
            bound=max(point.worth, min(other.bound for other in points if includes(other, point))),
        )
        for point in points
    ]
    return [_with_best_plan(work, point, tight) for point in tight]


def includes(larger: DesignPoint, smaller: DesignPoint) -> bool:
    """Whether every plan of one design is one of another by what is varied; so of itself."""
    values, others = dict(larger.design.values), dict(smaller.design.values)
    return all(
        value == others[kind] or (kind in INCLUDING and value > others[kind])
        for kind, value in values.items()
    )


def _with_best_plan(
    work: DesignWork, point: DesignPoint, points: Sequence[DesignPoint]
) -> DesignPoint:
    rules = point.instance.transfer.max_leg_s, point.instance.mission.mission_separation_s
    if any(rule is not None for rule in rules) or not math.isfinite(point.worth):
        return point  # orders without their times say little there
    better = [
        other
        for other in points
        if other.plan is not None
        and _is_near(other.design, point.design)
        and point.worth * (1.0 + SURELY) < other.worth <= point.bound * (1.0 + SURELY)
    ]
    better.sort(key=lambda other: (-other.worth, other.euros))
    for other in better[:TRIES]:
        assert other.plan is not None
        flown = {name: order for name, order in other.plan.orders.items() if order}
        made = _flown(work, point, flown)
        if made is not None and made.worth > point.worth:
            return made
    return point


def _is_near(one: Design, other: Design) -> bool:
    pairs = zip(one.values, other.values, strict=True)
    return sum(first != second for first, second in pairs) == 1


def _flown(
    work: DesignWork, point: DesignPoint, orders: Mapping[str, tuple[str, ...]]
) -> DesignPoint | None:
    """A point with the orders of another design; None if it cannot fly or pay them."""
    instance = point.instance
    if not orders.keys() <= {chaser.name for chaser in instance.chasers}:
        return None
    if not price(instance, orders, mend=False).holds:
        return None
    problem = problem_of(instance)
    problem.do_without()
    routes = [orders.get(chaser.name, ()) for chaser in instance.chasers]
    made = certify_routes(problem, work.method, routes, seed=work.seed, runtime_s=0.0)
    if made.plan is None or work.prices.of_plan(instance, made.plan) > point.design.budget:
        return None
    return work.point(point.design, instance, made.plan, point.bound, point.runtime_s, point.cpu_s)
