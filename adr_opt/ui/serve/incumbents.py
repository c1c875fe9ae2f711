"""The best plan so far of a running planner, made a plan about once a second."""

from __future__ import annotations

import threading
import time
from collections.abc import Callable
from contextlib import suppress
from types import TracebackType
from typing import Self

from ...mission.certified import certify_routes
from ...mission.problem import Problem, Routes
from ...plan.plan import Plan
from .looks import PlanningOrder

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
        """The plan of routes; None where they are none, as those of half a plan are."""
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
