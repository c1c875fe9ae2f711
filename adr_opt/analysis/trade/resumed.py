"""Resumption of a trade-off: rows of a results file, validated against the instance.

Plans are flown anew: their routes say what they collect and cost, whatever else a row states.
Bounds are taken at the word of the file, as far as no plan contradicts them.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Collection, Iterable
from dataclasses import replace
from itertools import chain

from ...common.errors import InputError
from ...judge.admit import admit
from ...mission.build_legs import legs
from ...mission.problem import Problem
from ...plan.expense import cost_of_routes
from ...plan.plan import MODEL, InstanceReference, Plan, Route, Unvisited
from .axes import PointLimits
from .plans import ask_few
from .points import Impossible, KnownPoints, Point

METHOD = "from-file"
"""Method of plans made here, which are internal."""


def take_in(
    board: KnownPoints,
    rows: Iterable[tuple[str, Point]],
    problem: Callable[[PointLimits], Problem],
    methods: Collection[str],
) -> dict[PointLimits, set[str]]:
    """Add the rows of a file to the known points.

    Parameters
    ----------
    board : KnownPoints
        Rows of points that it has not are passed over.
    rows : iterable of (str, Point)
        Where each row stands, for errors, and what it says.
    problem : callable
        What is planned at a point.
    methods : collection of str
        Those that may have been run.

    Returns
    -------
    dict of PointLimits to set of str
        The methods that were run for each point.

    Raises
    ------
    InputError
        A row cannot be true; the sentence says which and why.
    """
    ran: dict[PointLimits, set[str]] = {}
    for where, point in sorted(rows, key=lambda row: row[1].limits):
        if point.limits not in board.points:
            continue
        strange = [method for method in point.methods if method not in methods]
        if strange:
            raise InputError(f"{where}: {strange[0]!r} is not a method of this trade-off; {OTHER}")
        try:
            board.add(flown(point, problem(point.limits)))
        except Impossible:
            raise InputError(
                f"{where}: a bound of the file lies below what a plan of it collects, so that one "
                f"of the two was changed; {OTHER}"
            ) from None
        except InputError as error:
            raise InputError(f"{where}: {error}; {OTHER}") from None
        ran.setdefault(point.limits, set()).update(point.methods)
    return ran


OTHER = "name another file"


def flown(point: Point, problem: Problem) -> Point:
    """The point with prize and cost of its routes.

    Raises
    ------
    InputError
        They name no bodies, or cannot be flown within its limits; or there are none, and yet a
        prize.
    """
    bound = min(point.upper_bound, problem.total_prize)
    if not point.routes:
        if point.prize != -math.inf:
            raise InputError(f"the prize {point.prize:g} is stated of no routes")
        return replace(point, upper_bound=bound, visits=0, cost=math.nan)
    if len(point.routes) != len(problem.missions):
        raise InputError(
            f"there are {len(point.routes)} routes for {len(problem.missions)} chasers"
        )
    plan = _plan(point, problem)
    stations = problem.instance.station_names
    return replace(
        point,
        prize=plan.objective,
        upper_bound=bound,
        visits=sum(leg.destination not in stations for leg in plan.legs),
        cost=plan.cost,
    )


def _plan(point: Point, problem: Problem) -> Plan:
    """The plan of its routes at their best schedules, judged like any other."""
    instance = problem.instance
    priced = []
    ask_few(problem)
    for mission, route in zip(problem.missions, point.routes, strict=True):
        moves = mission.numbers(route).tolist()
        priced.append(Route(chaser=mission.chaser.name, legs=legs(mission, moves)))
    names = list(chain.from_iterable(point.routes))
    number = {name: at for at, name in enumerate(problem.names)}
    ends_s = [leg.free_s for route in priced for leg in route.legs]
    left = [target.name for target in instance.targets if target.name not in set(names)]
    plan = Plan(
        model=MODEL,
        instance=InstanceReference(name=instance.name, sha256=problem.sha256),
        method=METHOD,
        seed=0,
        status="feasible",
        objective=problem.prizes([number[name] for name in names], ends_s),
        cost=cost_of_routes(instance, priced),
        runtime_s=0.0,
        routes=tuple(priced),
        unvisited=tuple(Unvisited(target=name, reason="not-considered") for name in left),
    )
    admitted = admit(instance, plan, unjudged=True)
    if not admitted.holds:
        raise InputError(f"the routes cannot be flown: {admitted.violations[0]}")
    return plan
