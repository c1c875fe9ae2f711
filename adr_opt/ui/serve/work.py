"""Planning in a thread: one plan at a time, observable and stoppable, on an existing timetable."""

from __future__ import annotations

import math
import threading
import time
from collections.abc import Callable
from contextlib import suppress
from dataclasses import dataclass, field
from types import TracebackType
from typing import Any, Self

from ...common.errors import InputError
from ...common.stop import Interrupted, MaxRuntime
from ...mission.certified import certify_routes
from ...mission.problem import Problem, Routes
from ...mission.result import Result
from ...plan.plan import Plan
from ...problem.instance import Instance
from ...run import front
from ...run.course import Course
from ...run.method_call import method_of, spec_of
from ...run.methods import BOUNDS, PLANNERS
from ...run.reused_timetable import Reused
from ...run.start_plan import start_destinations
from .planning import (
    LONGEST_S,
    Done,
    Found,
    Phase,
    PlannedRun,
    PlanningOrder,
    PlanningProgress,
    ignored,
)

PAUSE_S = 1.0
"""Least interval between plans [s]."""

SHARE = 0.1
"""Maximum share of the time that is spent on making plans of routes."""


class IncumbentWatch:
    """Makes plans of the best routes so far, in a thread of its own, while a planner runs.

    Parameters
    ----------
    problem : Problem
        That is planned.
    order : PlanningOrder
    found : callable
        Called with each plan that is better than those before it.
    """

    def __init__(
        self, problem: Problem, order: PlanningOrder, found: Callable[[Plan], None]
    ) -> None:
        self._problem, self._order, self._found = problem, order, found
        self._routes: Routes | None = None
        self._best: Plan | None = None
        self._over = threading.Event()
        self._began = time.monotonic()
        self._thread = threading.Thread(target=self._watch, name="incumbents", daemon=True)

    def __enter__(self) -> Self:
        self._thread.start()
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        at: TracebackType | None,
    ) -> None:
        self._over.set()
        self._thread.join()

    def hear(self, routes: Routes) -> None:
        """Receive the best routes so far, from any thread."""
        self._routes = routes

    def _watch(self) -> None:
        pause_s, seen = PAUSE_S, None
        while not self._over.wait(pause_s):
            routes = self._routes
            if routes is None or routes == seen:
                continue
            seen, began = routes, time.monotonic()
            plan = self._plan(routes)
            if plan is not None and (self._best is None or _better(plan, self._best)):
                self._best = plan
                with suppress(Exception):  # not handed over: the next one is tried all the same
                    self._found(plan)
            pause_s = max(PAUSE_S, (time.monotonic() - began) / SHARE)

    def _plan(self, routes: Routes) -> Plan | None:
        """The plan of routes; None if the routes do not form a plan, as those of half a plan."""
        if len(routes) != len(self._problem.missions):
            return None
        try:
            return certify_routes(
                self._problem,
                self._order.method,
                routes,
                seed=self._order.seed,
                runtime_s=time.monotonic() - self._began,
            ).plan
        except Exception:  # of these routes; the next ones may do, and the run has its own result
            return None


def _better(plan: Plan, other: Plan) -> bool:
    return (plan.objective, -plan.cost) > (other.objective, -other.cost)


def check_order(order: PlanningOrder) -> None:
    """Refuse invalid parameters before anything starts.

    Raises
    ------
    InputError
        An unknown method or bound, or a time limit that is none.
    """
    MaxRuntime(order.time_limit_s)
    if order.time_limit_s > LONGEST_S:
        raise InputError(f"time limit = {order.time_limit_s:g}: must be at most {LONGEST_S:g} s")
    method_of(order.method, PLANNERS)
    if order.bound is not None:
        method_of(order.bound, BOUNDS)


@dataclass
class _Run:
    """A run, shared by its thread and its observers."""

    number: int
    order: PlanningOrder
    stop: Interrupted = field(default_factory=Interrupted)
    over: threading.Event = field(default_factory=threading.Event)
    phase: Phase = "waiting"
    began: float | None = None
    ended: float | None = None
    built: float = 1.0
    course: Course | None = None
    said: str = ""
    watch: IncumbentWatch | None = None

    def found(self, routes: Routes) -> None:
        """Receive the best routes so far."""
        if self.watch is not None:
            self.watch.hear(routes)

    def building(self, share: float) -> None:
        """Receive the share of the timetable that is built; the clock has started."""
        self._begin()
        self.phase, self.built = "timetable", share

    def __call__(self, incumbent: float, bound: float) -> None:
        """Receive an incumbent and a bound."""
        self._begin()
        self.phase, self.built = "planning", 1.0
        self._begin().hear(incumbent, bound)

    def settle(self, result: Result) -> None:
        """Adopt the final result, which may be below an earlier incumbent."""
        self._begin().settle(result.objective, result.upper_bound)

    @property
    def elapsed_s(self) -> float:
        """Time since the clock started [s]."""
        if self.began is None:
            return 0.0
        return (time.monotonic() if self.ended is None else self.ended) - self.began

    def progress(self) -> PlanningProgress:
        """Progress of the run."""
        points = () if self.course is None else tuple(self.course.points)
        last = points[-1] if points else (0.0, -math.inf, math.inf)
        return PlanningProgress(
            self.number,
            self.phase,
            self.stop.is_set,
            self.order.time_limit_s,
            self.elapsed_s,
            self.built,
            last[1],
            last[2],
            points,
            self.said,
        )

    def _begin(self) -> Course:
        if self.course is None:
            self.began, self.course = time.monotonic(), Course()
        return self.course


class Work:
    """Plans one instance after another.

    Parameters
    ----------
    done : callable
        Called with each instance and its result, in the thread of the run, before that is over.
    found : callable, optional
        Called with each instance and the best plan so far, about once a second.
    prepared : Event, optional
        Set when kernels are loaded; runs wait for it, as their clock stands still meanwhile.
    """

    def __init__(
        self, done: Done, found: Found = ignored, prepared: threading.Event | None = None
    ) -> None:
        self._done, self._found, self._prepared = done, found, prepared
        self._reused = Reused()
        self._lock = threading.Lock()
        self._run: _Run | None = None
        self._count = 0

    def progress(self) -> PlanningProgress:
        """Progress of the last run."""
        run = self._run
        return PlanningProgress() if run is None else run.progress()

    def begin(self, instance: Instance, order: PlanningOrder, known: Plan | None) -> int:
        """Plan, stopping any run in progress; returns the number of the run.

        Parameters
        ----------
        instance : Instance
        order : PlanningOrder
        known : Plan, optional
            To begin from, be it of a variant of the instance.

        Raises
        ------
        InputError
            The order is not valid; what runs goes on.
        """
        check_order(order)
        with self._lock:
            before = self._run
            if before is not None:
                before.stop.interrupt()
            self._count += 1
            run = self._run = _Run(self._count, order)
        threading.Thread(
            target=self._plan, args=(run, before, instance, known), name="planning", daemon=True
        ).start()
        return run.number

    def stop(self) -> None:
        """Ask the run for its best plan."""
        run = self._run
        if run is not None:
            run.stop.interrupt()

    def wait(self, seconds: float) -> bool:
        """Wait until nothing runs; returns whether that is the case."""
        run = self._run
        return run is None or run.over.wait(seconds)

    def prepare(self, *, drifts: bool) -> None:
        """Do nothing: the first run loads what it needs."""

    def close(self) -> None:
        """Do nothing: a finished thread has ended."""

    def _plan(self, run: _Run, before: _Run | None, instance: Instance, known: Plan | None) -> None:
        try:
            if before is not None:
                before.over.wait()
            if run.stop.is_set:
                run.said = "stopped before it began"
            else:
                run.phase = "compiling"
                if self._prepared is not None:
                    self._prepared.wait()
                try:
                    result = self._result(run, instance, known)
                except BaseException:
                    self._found(instance, None)
                    raise
                run.settle(result)
                made = PlannedRun(result.plan, result.status, tuple(result.notes))
                run.said = self._done(instance, made)
            run.phase = "done"
        except InputError as error:
            run.said, run.phase = str(error), "failed"
        except Exception as error:  # to be reported on the page
            run.said = f"{run.order.method} failed: {type(error).__name__}: {error}"
            run.phase = "failed"
        finally:
            run.ended = time.monotonic()
            run.over.set()

    def _result(self, run: _Run, instance: Instance, known: Plan | None) -> Result:
        order = run.order
        problem = self._reused.problem(instance)
        start: Any = None
        if order.goes_on and known is not None and spec_of(order.method).starts:
            names = set(instance.names)
            routes = [
                tuple(name for name in route if name in names)
                for route in start_destinations(problem, known, repair=True)
            ]
            if any(routes):
                start = routes if len(problem.missions) > 1 else routes[0]
        wanted = front.RunOptions(
            order.time_limit_s, order.seed, start, repair=start is not None, bound=order.bound
        )
        with IncumbentWatch(problem, order, lambda plan: self._found(instance, plan)) as run.watch:
            return front.run(
                PLANNERS,
                problem,
                order.method,
                wanted,
                stop=run.stop,
                progress=run,
                building=run.building,
            )
