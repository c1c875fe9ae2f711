"""Plans of the points of a trade-off, each with its instance."""

from __future__ import annotations

from collections.abc import Iterator

from ...legs.nearest_pairs import neighbours
from ...mission.certified import certify_routes
from ...mission.problem import Problem
from ...plan.plan import Plan
from ...problem.instance import Instance
from .axes import tanks_of
from .points import Point, Tradeoff
from .shared import Shared

METHOD = "tradeoff"
"""Method stated in plans that points take over from their neighbours."""


def plans_of(made: Tradeoff) -> Iterator[tuple[int, Instance, Plan]]:
    """Place, instance and plan of each point that has one, in the order of the points.

    Parameters
    ----------
    made : Tradeoff
    """
    tanks = tanks_of(made.instance, made.axes)
    longest_s = max((point.duration_s for point in made.points), default=0.0)
    shared = Shared(made.instance, longest_s, tanks=tanks)
    for at, point in enumerate(made.points):
        if point.routes:
            problem = shared.problem(point.limits)
            plan = _plan(problem, point)
            if plan is not None:
                yield at, problem.instance, plan


def ask_few(problem: Problem) -> None:
    """Leave the timetable to be computed on demand: a few routes do not need all of it."""
    for mission in problem.missions:
        if problem.connecting.may_be_on_demand and not mission.has_timetable:
            mission.ask(neighbours(problem.instance, 1))


def _plan(problem: Problem, point: Point) -> Plan | None:
    ask_few(problem)
    return certify_routes(
        problem,
        point.methods[-1] if point.methods else METHOD,
        point.routes,
        seed=0,
        runtime_s=point.runtime_s,
        upper_bound=problem.worth(point.upper_bound),
    ).plan
