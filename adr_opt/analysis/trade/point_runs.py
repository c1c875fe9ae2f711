"""Runs at the points of a trade-off, the rows of its study: a planner at a point.

A row has routes and a bound. Routes from a file are flown anew, whatever else it states; a bound is
what the run wrote that the file is of, unless a plan contradicts it.
"""

from __future__ import annotations

import math
import time
from collections.abc import Iterable, Iterator, Sequence
from contextlib import suppress
from dataclasses import dataclass, replace
from functools import cached_property
from itertools import product
from typing import Any, NamedTuple

from ...common.errors import InputError
from ...common.stop import Stop
from ...common.tolerance import meets
from ...judge.admit import admit
from ...mission.certified import certify_routes
from ...mission.problem import Problem
from ...plan.plan import Plan
from ...problem.instance import Instance
from ...run.front import solve
from ...run.method_call import spec_of
from ...study import Place, Study
from .axes import PointLimits, Tanks
from .plans import ask_few
from .points import Point, Routes
from .shared import Shared

METHOD = "from-file"
"""Method stated in internal plans."""

GIVEN = "given"
"""Stated of points in the place of a planner where the plan was there already."""

INFEASIBLE = "infeasible"
"""Placeholder for the bound of a point without any plan."""


class PointRun(NamedTuple):
    """A planner at a point.

    Attributes
    ----------
    method : str
    known : Point
        What is known of the point, from which the planner begins and at which it ends; the limits
        of the point are all of it that the row is known by.
    """

    method: str
    known: Point

    def key(self) -> dict[str, Any]:
        """The method and the limits, as JSON data."""
        limits = self.known.limits._asdict()
        return {"method": self.method} | {
            name: value for name, value in limits.items() if value is not None
        }


@dataclass(frozen=True)
class PointRuns:
    """Common data of all runs at the points of an instance.

    Attributes
    ----------
    instance : Instance
    longest_s : float
        The longest duration of all points [s].
    tanks : Tanks
        What is varied of tanks.
    time_limit_s : float
        For each run [s].
    seed : int
    """

    instance: Instance
    longest_s: float
    tanks: Tanks
    time_limit_s: float
    seed: int

    def study(self, method: str) -> Study[PointRun, Point]:
        """The study whose rows are these runs.

        Parameters
        ----------
        method : str
            That runs where plan and bound do not meet yet.
        """
        settings = f"method {method}, {self.time_limit_s:g} s, seed {self.seed}"
        return Study(
            "tradeoff",
            1,
            self.row,
            {"instance": self.instance.sha256, "settings": settings},
            key=PointRun.key,
            to_json=_to_json,
            from_json=self._from_json,
        )

    def __reduce__(self) -> tuple[Any, ...]:
        # Another process builds timetables of its own.
        own = self.instance, self.longest_s, self.tanks, self.time_limit_s, self.seed
        return PointRuns, own

    @cached_property
    def shared(self) -> Shared:
        """The problems of points, with timetables for planning."""
        return Shared(self.instance, self.longest_s, tanks=self.tanks)

    @cached_property
    def _flown_alone(self) -> Shared:
        """The problems of points, for a few routes each."""
        return Shared(self.instance, self.longest_s, tanks=self.tanks)

    def row(self, run: PointRun, place: Place) -> Point:
        """Result of a planner at a point."""
        began, cpu_began = time.perf_counter(), time.process_time()
        method, known = run
        problem = self.shared.problem(known.limits)
        planner = spec_of(method)
        more: dict[str, Any] = {}
        if planner.starts and any(known.routes):
            routes = known.routes if len(problem.missions) > 1 else known.routes[0]
            more = {"start": routes, "repair": True}
        if not place.alone and planner.uses_cores:
            more["jobs"] = 1
        result = solve(
            problem,
            method,
            time_limit=self.time_limit_s,
            seed=self.seed,
            stop=_Reached(known.upper_bound, place.stop),
            **more,
        )
        plan = result.plan
        routes = tuple(tuple(problem.names[j] for j in route) for route in result.routes)
        upper_bound = result.upper_bound
        if result.status == "infeasible":
            upper_bound = -math.inf
        elif result.status == "optimal":
            upper_bound = result.objective  # to what can be told apart
        upper_bound = min(upper_bound, problem.total_prize)
        return replace(
            _point(run, routes, upper_bound, _visits(problem, routes)),
            prize=result.objective,
            cost=math.nan if plan is None else plan.cost,
            runtime_s=time.perf_counter() - began,
            cpu_s=time.process_time() - cpu_began,
        )

    def _from_json(self, run: PointRun, row: dict[str, Any]) -> Point:
        """The point of a row from a file, with prize and cost of its routes.

        Raises
        ------
        InputError
            They name no bodies, or cannot be flown within its limits.
        ValueError, TypeError, KeyError
            It is no such row.
        """
        routes, bound = row["routes"], row["upper_bound"]
        if not all(isinstance(name, str) for route in routes for name in route):
            raise ValueError("no names")
        stated = -math.inf if bound == INFEASIBLE else math.inf if bound is None else float(bound)
        runtime_s, cpu_s = float(row["runtime_s"]), float(row["cpu_s"])
        if math.isnan(stated) or not (0.0 <= runtime_s < math.inf and 0.0 <= cpu_s < math.inf):
            raise ValueError("the fields of the row are not numbers")
        routes = tuple(tuple(route) for route in routes)
        return replace(self._flown(run, routes, stated), runtime_s=runtime_s, cpu_s=cpu_s)

    def given(self, limits: Iterable[PointLimits], orders: Iterable[Routes]) -> Iterator[Point]:
        """Points at which orders of plans that are there already can be flown, timed anew."""
        for each, routes in product(limits, orders):
            with suppress(InputError):  # too little ΔV or time
                yield self._flown(PointRun(GIVEN, Point(**each._asdict())), routes, math.inf)

    def _flown(self, run: PointRun, routes: Routes, bound: float) -> Point:
        """The point of routes, flown anew; of none, the bound alone."""
        problem = self._flown_alone.problem(run.known.limits)
        bound = min(bound, problem.total_prize)
        point = _point(run, routes, bound, _visits(problem, routes))
        if not routes:
            return point
        if len(routes) != len(problem.missions):
            raise InputError(f"there are {len(routes)} routes for {len(problem.missions)} chasers")
        plan = _plan(routes, problem)
        return replace(point, prize=plan.objective, cost=plan.cost)


class _Reached:
    """Stops once a plan meets a bound known from elsewhere."""

    def __init__(self, upper_bound: float, stop: Stop | None) -> None:
        self._upper_bound, self._stop = upper_bound, stop

    def __call__(self, incumbent: float, bound: float) -> bool:
        """Whether to stop."""
        stopped = self._stop is not None and self._stop(incumbent, bound)
        return stopped or meets(incumbent, min(bound, self._upper_bound))

    def remaining_s(self) -> float:
        """Remaining time [s]."""
        return math.inf if self._stop is None else self._stop.remaining_s()


def _point(
    run: PointRun, routes: tuple[tuple[str, ...], ...], upper_bound: float, visits: int
) -> Point:
    known = run.known
    return Point(
        known.delta_v_m_s,
        known.duration_s,
        upper_bound=upper_bound,
        visits=visits,
        routes=routes,
        methods=(run.method,),
        thrust_n=known.thrust_n,
        isp_s=known.isp_s,
    )


def _visits(problem: Problem, routes: Sequence[Sequence[str]]) -> int:
    stations = problem.instance.station_names
    return sum(name not in stations for route in routes for name in route)


def _to_json(point: Point) -> dict[str, Any]:
    bound: float | str | None = point.upper_bound
    if math.isinf(point.upper_bound):
        bound = None if point.upper_bound > 0.0 else INFEASIBLE
    return {
        "routes": [list(route) for route in point.routes],
        "upper_bound": bound,
        "runtime_s": round(point.runtime_s, 3),
        "cpu_s": round(point.cpu_s, 3),
    }


def _plan(routes: tuple[tuple[str, ...], ...], problem: Problem) -> Plan:
    """The plan of routes at their best schedules, judged like any other."""
    ask_few(problem)
    plan = certify_routes(problem, METHOD, routes, seed=0, runtime_s=0.0).plan
    if plan is None:
        raise InputError("the routes do not form a plan: a required target or the end is missing")
    admitted = admit(problem.instance, plan, unjudged=True)
    if not admitted.holds:
        raise InputError(f"the routes cannot be flown: {admitted.violations[0]}")
    return plan
