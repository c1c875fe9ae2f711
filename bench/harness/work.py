"""One task, done in a worker: build the timetable, plan, check, bound.

Nothing leaves this module but plain data: an exception of a planner may not survive its journey
from one process to another, and a row that says what happened does.
"""

from __future__ import annotations

import contextlib
import math
import sys
import time
from collections.abc import Callable
from dataclasses import dataclass, field
from functools import cache
from typing import Any

import adr_opt
from adr_opt.common.errors import MissingExtra
from adr_opt.common.tolerance import meets, rounded_down
from adr_opt.mission.problem import Problem, problem_of
from adr_opt.mission.result import Result
from adr_opt.problem.instance import Instance
from adr_opt.run import front
from adr_opt.run.methods import BOUNDS
from adr_opt.run.warm_up import practice_problem

from .environment import environment
from .methods import Method
from .trials import BoundCall, Task, Trial

Tell = Callable[[str, dict[str, Any]], None]
"""Hears of everything finished at once: ``("row", …)``, ``("bound", …)`` or ``("spent", …)``."""

LONGEST_MESSAGE = 300
WARM_LIMIT_S = 20.0

_warm: set[object] = set()


@dataclass
class Spent:
    """Breakdown of a task's time [s]."""

    warm: float = 0.0
    build: float = 0.0
    planning: float = 0.0
    check: float = 0.0
    bound: float = 0.0
    begun: float = field(default_factory=time.perf_counter)

    def to_dict(self) -> dict[str, float]:
        """The parts, and the whole as ``task``."""
        parts = {name: getattr(self, name) for name in PARTS}
        return {**parts, "task": time.perf_counter() - self.begun}


PARTS = ("warm", "build", "planning", "check", "bound")


def work(task: Task, tell: Tell) -> None:
    """Do a task; every row is told as soon as it is finished."""
    spent = Spent()
    began, cpu_began = time.perf_counter(), time.process_time()
    try:
        problem = problem_of(task.trial.instance(), threads=1)
        for mission in problem.missions:
            mission.rules  # noqa: B018  builds the timetable
    except Exception as error:
        for method in task.methods:
            tell("row", _row(task, method, outcome="raised", message=_sentence(error)))
        if task.bound is not None:
            tell("bound", {**_bound_row(task.trial, task.bound), "message": _sentence(error)})
        return
    spent.build, build_cpu_s = time.perf_counter() - began, time.process_time() - cpu_began
    best, kind = task.best, (problem.connecting.is_listed, problem.alone is None)
    for method in task.methods:
        spent.warm += warm_up(method, *kind)
        row = _plan(task, method, _as_new(problem), spent)
        row |= {"build_s": spent.build, "build_cpu_s": build_cpu_s}
        if row["outcome"] == "legal":
            best = max(best, row["objective"])
        tell("row", row)
    if task.bound is not None:
        spent.warm += warm_up(task.bound, *kind)
        tell("bound", _bound(task.trial, task.seed, task.bound, problem, best, spent))
    tell("spent", spent.to_dict())


def _as_new(problem: Problem) -> Problem:
    """The same problem on the same timetable, without other results of earlier methods."""
    timetables = [mission.timetable for mission in problem.missions]
    return Problem(problem.instance, threads=1, timetables=timetables)


def preflight(methods: tuple[Method | BoundCall, ...]) -> str | None:
    """Compile and load every method in this process; which package is missing, if any.

    What a planner raises otherwise, or returns, is for its rows to say: the run goes on.
    """
    for method in methods:
        try:
            _solve_small(method)
        except MissingExtra as error:
            return f"{method.name}: {error}"
        except (Exception, SystemExit) as error:
            print(
                f"{method.name}: fails on the practice mission "
                f"{_small(False, False).instance.name} ({_sentence(error)}); its rows will say "
                "what becomes of it",
                file=sys.stderr,
            )
        _warm.add((method, False, False))
    return None


def warm_up(method: Method | BoundCall, drifts: bool = False, campaign: bool = False) -> float:
    """See that nothing of a method is compiled while its clock runs; seconds that it took.

    Where nodes drift, or there are several chasers, there is more to compile.
    """
    if (method, drifts, campaign) in _warm:
        return 0.0
    began = time.perf_counter()
    with contextlib.suppress(Exception):  # its row will say so, with the clock running
        _solve_small(method, drifts, campaign)
    _warm.add((method, drifts, campaign))
    return time.perf_counter() - began


@cache
def _small(drifts: bool, campaign: bool) -> Problem:
    if campaign or drifts:
        return practice_problem(drifts, campaign)
    return problem_of(adr_opt.generate("tiny", 0, zones=2), threads=1)


def _solve_small(method: Method | BoundCall, drifts: bool = False, campaign: bool = False) -> None:
    mission = _small(drifts, campaign)
    if isinstance(method, BoundCall):
        options = {"jobs": 1} if front.spec_of(method.name, BOUNDS).uses_cores else {}
        front.bound(mission, method.name, time_limit=WARM_LIMIT_S, iterations=3, **options)
        return
    result = front.solve(
        mission, method.name, time_limit=WARM_LIMIT_S, iterations=3, **method.values()
    )
    if not isinstance(result, Result):
        raise TypeError(_no_result(result))
    if result.plan is not None:
        adr_opt.check(mission.instance, result.plan)


def _no_result(given: Any) -> str:
    return f"returned {type(given).__name__}, not a Result"


def _plan(task: Task, method: Method, mission: Problem, spent: Spent) -> dict[str, Any]:
    began, cpu_began = time.perf_counter(), time.process_time()
    try:
        result = front.solve(
            mission, method.name, time_limit=method.limit_s, seed=task.seed, **method.values()
        )
    except (Exception, SystemExit) as error:
        planning_s = time.perf_counter() - began
        spent.planning += planning_s
        message = _sentence(error)
        return _row(task, method, outcome="raised", message=message, planning_s=planning_s)
    planning_s = time.perf_counter() - began
    planning_cpu_s = time.process_time() - cpu_began
    spent.planning += planning_s
    began = time.perf_counter()
    try:
        facts = _judged(mission.instance, result)
    except Exception as error:  # what came back is no result at all
        facts = {"outcome": "illegal", "message": _sentence(error)}
    check_s = time.perf_counter() - began
    spent.check += check_s
    return _row(
        task, method, planning_s=planning_s, planning_cpu_s=planning_cpu_s, check_s=check_s, **facts
    )


def _judged(instance: Instance, result: Any) -> dict[str, Any]:
    """The facts of a plan, and whether it may count: ``check`` decides, nothing else."""
    if not isinstance(result, Result):
        return {"outcome": "illegal", "message": _no_result(result)}
    plan = result.plan
    if plan is None:
        return {"outcome": "illegal", "message": f"returned no plan, status {result.status!r}"}
    violations = adr_opt.check(instance, plan)
    number = {name: index for index, name in enumerate(instance.names)}
    to_station = [leg.destination in instance.station_names for leg in plan.legs]
    return {
        "outcome": "illegal" if violations else "legal",
        "message": str(violations[0])[:LONGEST_MESSAGE] if violations else None,
        "violations": len(violations),
        "status": plan.status,
        "visits": len(to_station) - sum(to_station),
        "refuellings": sum(to_station),
        "objective": plan.objective,
        "delta_v_m_s": plan.delta_v_m_s,
        "duration_used_s": max((leg.end_s for leg in plan.legs), default=0.0),
        "runtime_s": plan.runtime_s,
        "upper_bound": plan.upper_bound,
        "sha256": plan.instance.sha256,
        "sequence": " / ".join(
            " ".join(str(number.get(leg.destination, -1)) for leg in route.legs)
            for route in plan.routes
        ),
    }


def _row(task: Task, method: Method, **facts: Any) -> dict[str, Any]:
    trial = task.trial
    return {
        "suite": trial.suite,
        "field": trial.field,
        "iteration": trial.iteration,
        "zones": trial.zones,
        "method": method.key,
        "seed": task.seed,
        "environment": environment(),
        **facts,
    }


class _Met:
    """Enough once the bound proves that nothing beats the best plan known."""

    def __init__(self, best: float, step: float) -> None:
        self._best = best
        self._step = step

    def __call__(self, incumbent: float, bound: float) -> bool:
        return meets(self._best, rounded_down(bound, self._step))

    def remaining_s(self) -> float:
        return math.inf


def _bound(
    trial: Trial, seed: int, call: BoundCall, mission: Problem, best: float, spent: Spent
) -> dict[str, Any]:
    row = _bound_row(trial, call)
    options = {"jobs": 1} if front.spec_of(call.name, BOUNDS).uses_cores else {}
    began = time.perf_counter()
    try:
        result = front.bound(
            mission,
            call.name,
            time_limit=call.limit_s,
            seed=seed,
            stop=_Met(best, mission.prize_step),
            **options,
        )
        row["upper_bound"] = result.upper_bound if math.isfinite(result.upper_bound) else None
        row["status"] = result.status
    except (Exception, SystemExit) as error:
        row["message"] = _sentence(error)
    row["planning_s"] = time.perf_counter() - began
    spent.bound += row["planning_s"]
    return row


def _bound_row(trial: Trial, call: BoundCall) -> dict[str, Any]:
    return {
        "suite": trial.suite,
        "field": trial.field,
        "iteration": trial.iteration,
        "zones": trial.zones,
        "method": call.name,
        "limit_s": call.limit_s,
        "environment": environment(),
    }


def _sentence(error: BaseException) -> str:
    said = " ".join(str(error).split())
    return f"{type(error).__name__}: {said}"[:LONGEST_MESSAGE]
