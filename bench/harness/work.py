"""One row, made in a worker: build the timetable of the trial, plan and check, or bound.

Whatever a planner raises is for its row to say: it ends nothing.
"""

from __future__ import annotations

import contextlib
import math
import platform
import socket
import time
from typing import Any

from machine import processor

import adr_opt
from adr_opt.common.errors import InputError, MissingExtra
from adr_opt.common.processors import usable_cores
from adr_opt.common.tolerance import meets, rounded_down
from adr_opt.mission.problem import Problem, problem_of
from adr_opt.mission.result import Result, versions
from adr_opt.problem.instance import Instance
from adr_opt.run import front
from adr_opt.run.methods import BOUNDS
from adr_opt.run.warm_up import practice_problem
from adr_opt.study import Place, WorkerDied

from .methods import Method
from .trials import BoundCall, Trial, Wanted

LONGEST_MESSAGE = 300
WARM_LIMIT_S = 20.0


class _Kept:
    """What this process found out; sent to a cluster with this module, it is empty there."""

    def __init__(self) -> None:
        self.warm: set[object] = set()
        self.environment: dict[str, Any] = {}
        self.problems: dict[tuple[bool, bool], Problem] = {}

    def __reduce__(self) -> tuple[Any, ...]:
        return _Kept, ()


_kept = _Kept()


def environment() -> dict[str, Any]:
    """Host, processor, number of cores, Python and packages of this process."""
    if not _kept.environment:
        _kept.environment.update(
            host=socket.gethostname(),
            processor=processor(),
            cores=usable_cores(),
            python=platform.python_version(),
            versions="; ".join(f"{name} {number}" for name, number in versions().items()),
        )
    return dict(_kept.environment)


class Rows:
    """Rows of one process, of which those of a trial share its timetable."""

    def __init__(self) -> None:
        self._trial: Trial | None = None
        self._problem: Problem | Exception | None = None
        self._build: dict[str, float] = {}
        self._best = -math.inf

    def __reduce__(self) -> tuple[Any, ...]:
        return Rows, ()

    def row(self, wanted: Wanted, place: Place) -> dict[str, Any]:
        """What comes of a method or a bound on a trial."""
        self._go_to(wanted.trial)
        facts = {"environment": environment(), **self._build}
        if isinstance(self._problem, Exception):
            return {**facts, "outcome": "raised", "message": _sentence(self._problem)}
        problem = self._problem
        assert problem is not None
        kind = problem.connecting.is_listed, problem.alone is None
        warm_s = warm_up(wanted.what, *kind)
        facts["warm_s"] = warm_s
        if isinstance(wanted.what, BoundCall):
            best = max(self._best, wanted.best)
            return facts | _bound(wanted.seed, wanted.what, problem, best)
        facts |= _plan(wanted.seed, wanted.what, _as_new(problem))
        if facts["outcome"] == "legal":
            self._best = max(self._best, facts["objective"])
        return facts

    def _go_to(self, trial: Trial) -> None:
        if self._trial == trial:
            return
        self._trial, self._best = trial, -math.inf
        began, cpu_began = time.perf_counter(), time.process_time()
        try:
            self._problem = problem_of(trial.instance(), threads=1)
            for mission in self._problem.missions:
                mission.rules  # noqa: B018  builds the timetable
        except Exception as error:
            self._problem = error
        self._build = {
            "build_s": time.perf_counter() - began,
            "build_cpu_s": time.process_time() - cpu_began,
        }


def failed(wanted: Wanted, error: Exception) -> dict[str, Any]:
    """The row of a method that has killed its process, twice; other errors end the run."""
    if not isinstance(error, WorkerDied):
        raise error
    return {
        "environment": environment(),
        "outcome": "died",
        "message": "its worker process died, twice",
    }


def _as_new(problem: Problem) -> Problem:
    """The same problem on the same timetable, without other results of earlier methods."""
    timetables = [mission.timetable for mission in problem.missions]
    return Problem(problem.instance, threads=1, timetables=timetables)


def practise(method: Method | BoundCall, place: Place) -> str | None:
    """Compile and load a method in this process; how it fails, if it does.

    Raises
    ------
    MissingExtra
        A package is not installed.
    """
    try:
        _solve_small(method)
    except MissingExtra as error:
        raise InputError(f"{method.name}: {error}") from None
    except (Exception, SystemExit) as error:
        return (
            f"{method.name}: fails on the practice mission "
            f"{_small(False, False).instance.name} ({_sentence(error)}); its rows will say what "
            "becomes of it"
        )
    return None


def killed(method: Method | BoundCall, error: Exception) -> str | None:
    """What kills a process when it is practised will kill it there, and have a row for it."""
    if not isinstance(error, WorkerDied):
        raise error
    return None


def warm_up(method: Method | BoundCall, drifts: bool = False, campaign: bool = False) -> float:
    """See that nothing of a method is compiled while its clock runs; seconds that it took.

    Where nodes drift, or there are several chasers, there is more to compile.
    """
    if (method, drifts, campaign) in _kept.warm:
        return 0.0
    began = time.perf_counter()
    with contextlib.suppress(Exception):  # its row will say so, with the clock running
        _solve_small(method, drifts, campaign)
    _kept.warm.add((method, drifts, campaign))
    return time.perf_counter() - began


def _small(drifts: bool, campaign: bool) -> Problem:
    kind = drifts, campaign
    if kind not in _kept.problems:
        _kept.problems[kind] = (
            practice_problem(drifts, campaign)
            if campaign or drifts
            else problem_of(adr_opt.generate("tiny", 0, zones=2), threads=1)
        )
    return _kept.problems[kind]


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


def _plan(seed: int, method: Method, mission: Problem) -> dict[str, Any]:
    began, cpu_began = time.perf_counter(), time.process_time()
    try:
        result = front.solve(
            mission, method.name, time_limit=method.limit_s, seed=seed, **method.values()
        )
    except MissingExtra:
        raise
    except (Exception, SystemExit) as error:
        planning_s = time.perf_counter() - began
        return {"outcome": "raised", "message": _sentence(error), "planning_s": planning_s}
    facts = {
        "planning_s": time.perf_counter() - began,
        "planning_cpu_s": time.process_time() - cpu_began,
    }
    began = time.perf_counter()
    try:
        facts |= _judged(mission.instance, result)
    except Exception as error:  # what came back is no result at all
        facts |= {"outcome": "illegal", "message": _sentence(error)}
    return facts | {"check_s": time.perf_counter() - began}


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


class _Met:
    """Enough once the bound proves that nothing beats the best plan known."""

    def __init__(self, best: float, step: float) -> None:
        self._best = best
        self._step = step

    def __call__(self, incumbent: float, bound: float) -> bool:
        return meets(self._best, rounded_down(bound, self._step))

    def remaining_s(self) -> float:
        return math.inf


def _bound(seed: int, call: BoundCall, mission: Problem, best: float) -> dict[str, Any]:
    facts: dict[str, Any] = {}
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
        facts["upper_bound"] = result.upper_bound if math.isfinite(result.upper_bound) else None
        facts["status"] = result.status
    except (Exception, SystemExit) as error:
        facts["message"] = _sentence(error)
    return facts | {"planning_s": time.perf_counter() - began}


def _sentence(error: BaseException) -> str:
    said = " ".join(str(error).split())
    return f"{type(error).__name__}: {said}"[:LONGEST_MESSAGE]
