"""Runs over the points of a trade-off, each from known results, on one core or several."""

from __future__ import annotations

import math
import multiprocessing
import os
import time
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import FIRST_COMPLETED, Future, ProcessPoolExecutor, wait
from dataclasses import dataclass, replace
from typing import Any, NamedTuple

from ...common.cluster import Calls, LocalPool, Workers
from ...common.errors import InputError
from ...common.processors import usable_cores
from ...common.stop import MaxRuntime, Stop
from ...common.tolerance import meets
from ...mission.problem import Problem
from ...problem.instance import Instance
from ...run.front import DEFAULT_METHOD, DEFAULT_TIME_LIMIT_S, solve
from ...run.method_call import refuse_unable, spec_of
from .axes import Axis, PointLimits, Tanks, grid, tanks_of
from .points import Impossible, KnownPoints, Point, Tradeoff
from .results import ResultsFile, columns_for
from .resumed import take_in
from .shared import Shared, slack_m_s, variant

QUICK = "beam"
"""Planner of the first pass over all points, where it supports the instance."""

Told = Callable[[Point, "KnownPoints"], None]


@dataclass(frozen=True)
class Settings:
    """Settings of a run, without instance and point.

    Attributes
    ----------
    method : str
    time_limit_s : float
        For each run [s].
    seed : int
    quick : str or None
        Planner of the first pass.
    """

    method: str
    time_limit_s: float
    seed: int
    quick: str | None

    def __str__(self) -> str:
        return f"method {self.method}, {self.time_limit_s:g} s, seed {self.seed}"


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


def tradeoff(  # noqa: PLR0913
    instance: Instance,
    axes: Sequence[Axis],
    *,
    method: str = DEFAULT_METHOD,
    time_limit: float = DEFAULT_TIME_LIMIT_S,
    seed: int = 0,
    jobs: int = 1,
    cluster: str | None = None,
    path: str | os.PathLike[str] | None = None,
    stop: Stop | None = None,
    told: Told = lambda point, board: None,
) -> Tradeoff:
    """Plans and bounds of an instance over budgets and durations.

    Every point gets a quick plan first, which counts for all larger points too. Then ``method``
    runs where plan and bound do not meet yet, the largest point of each plateau first: its bound
    counts for all smaller ones. It begins with the best plan known, and ends when that meets the
    least bound known.

    Parameters
    ----------
    instance : Instance
    axes : sequence of Axis
        What is varied: one for a curve, two for a surface.
    method : str
        Name of a planner; bounds come from those that prove, as "auto" and "exact".
    time_limit : float
        Wall time of each run [s].
    seed : int
    jobs : int
        Processes, each with one run at a time; 0 for one per core. With one all
        happens in this process.
    cluster : str, optional
        Address of a Dask scheduler whose workers make the runs instead, as
        :func:`adr_opt.common.cluster.client_of` takes it.
    path : path, optional
        File of the results, see :mod:`.results`: what is in it is not run again.
    stop : Stop, optional
        Ends all of it early.
    told : callable
        Called with each run's point and what is known of all points then.

    Raises
    ------
    InputError
        The axes, the method, or the file do not fit.
    """
    began, cpu_began = time.perf_counter(), time.process_time()
    MaxRuntime(time_limit)
    if jobs < 0:
        raise InputError(f"jobs = {jobs}: must be 0, for all cores, or more")
    if jobs != 1 and cluster is not None:
        raise InputError("jobs and a cluster exclude each other; leave one of them out")
    limits = grid(instance, axes)
    tanks = tanks_of(instance, axes)
    for each in limits:
        variant(instance, each, tanks=tanks)  # what is not valid is refused before any work
    shared = Shared(instance, max(each.duration_s for each in limits), tanks=tanks)
    problem = shared.problem(limits[0])
    refuse_unable(problem, spec_of(method))
    settings = Settings(method, time_limit, seed, _quick(problem, method))
    file = (
        None
        if path is None
        else ResultsFile(path, instance.sha256, str(settings), columns_for(axes))
    )
    board, ran = KnownPoints(limits, slack_m_s(instance)), dict[PointLimits, set[str]]()
    if file is not None and file.found:
        known = Shared(instance, shared.longest_s, tanks=tanks)
        ran = take_in(board, file.found, known.problem, {method, QUICK})
    jobs = jobs or usable_cores()
    runner: _Here | _Beside = _Here(shared, settings)
    work = _Work(instance, shared.longest_s, tanks, settings)
    if cluster is not None:
        runner = _Beside(work, Workers(cluster))
    elif jobs > 1:
        # A fork of a process with threads may wait for a lock that is never released.
        processes = ProcessPoolExecutor(jobs, multiprocessing.get_context("spawn"))
        runner = _Beside(work, LocalPool(processes, jobs))
    with runner:
        for quick in (True, False):
            for point, used in runner.run(board, ran, quick=quick, stop=stop):
                try:
                    board.add(point)
                except Impossible as error:
                    if file is None or not file.found:
                        raise
                    raise InputError(
                        f"{path}: a bound of this file lies below what a plan collects that is "
                        f"found now ({str(error).partition(':')[0]}); name another file"
                    ) from error
                if file is not None:
                    file.append(point, used)
                told(point, board)
    held = dict(tanks.values) if tanks.limit == "propellant_kg" else {}
    points = tuple(
        replace(board.points[each], propellant_kg=held.get(each.delta_v_m_s)) for each in limits
    )
    cpu_s = time.process_time() - cpu_began + runner.elsewhere_s
    made = Tradeoff(instance, tuple(axes), points, time.perf_counter() - began, cpu_s)
    if file is not None and not _is_over(stop):
        file.finish(made)
    return made


def _quick(problem: Problem, method: str) -> str | None:
    """Planner of the first pass; None if it is just ``method``."""
    try:
        quick = spec_of(QUICK)
    except InputError:
        return None
    plans = len(problem.missions) == 1 and problem.missions[0].rules.loads is None
    return QUICK if method != QUICK and (plans or quick.several) else None


def _is_over(stop: Stop | None) -> bool:
    return stop is not None and stop.remaining_s() <= 0.0


def _next(
    board: KnownPoints, ran: dict[PointLimits, set[str]], method: str, quick: bool
) -> PointLimits | None:
    """The next point to run; None if none is left."""
    done = {limits for limits, methods in ran.items() if method in methods}
    if not quick:
        return next(board.open(done), None)
    waiting = [each for each, point in board.points.items() if not point.proven]
    return next((each for each in waiting if each not in done), None)


def run_point(
    problem: Problem,
    settings: Settings,
    known: Point,
    *,
    quick: bool,
    alone: bool,
    stop: Stop | None,
) -> Point:
    """Run one point.

    Parameters
    ----------
    problem : Problem
    settings : Settings
    known : Point
        What is known of it.
    quick : bool
        Whether it is the first pass.
    alone : bool
        Whether the method may use all cores.
    stop : Stop, optional
    """
    method = settings.quick if quick and settings.quick is not None else settings.method
    planner = spec_of(method)
    more: dict[str, Any] = {}
    if planner.starts and any(known.routes):
        routes = known.routes if len(problem.missions) > 1 else known.routes[0]
        more = {"start": routes, "repair": True}
    if not alone and planner.uses_cores:
        more["jobs"] = 1
    began, cpu_began = time.perf_counter(), time.process_time()
    result = solve(
        problem,
        method,
        time_limit=settings.time_limit_s,
        seed=settings.seed,
        stop=_Reached(known.upper_bound, stop),
        **more,
    )
    plan = result.plan
    routes = tuple(tuple(problem.names[j] for j in route) for route in result.routes)
    stations = problem.instance.station_names
    upper_bound = result.upper_bound
    if result.status == "infeasible":
        upper_bound = -math.inf
    elif result.status == "optimal":
        upper_bound = result.objective  # to what can be told apart
    return Point(
        known.delta_v_m_s,
        known.duration_s,
        prize=result.objective,
        upper_bound=min(upper_bound, problem.total_prize),
        visits=sum(name not in stations for route in routes for name in route),
        cost=math.nan if plan is None else plan.cost,
        routes=routes,
        methods=(method,),
        runtime_s=time.perf_counter() - began,
        cpu_s=time.process_time() - cpu_began,
        thrust_n=known.thrust_n,
        isp_s=known.isp_s,
    )


class _Here:
    """Runs in this process, one after another."""

    elsewhere_s = 0.0

    def __init__(self, shared: Shared, settings: Settings) -> None:
        self._shared, self._settings = shared, settings

    def __enter__(self) -> _Here:
        return self

    def __exit__(self, *_: object) -> None:
        return None

    def run(
        self,
        board: KnownPoints,
        ran: dict[PointLimits, set[str]],
        *,
        quick: bool,
        stop: Stop | None,
    ) -> Iterator[tuple[Point, str]]:
        """Runs of a pass, each chosen after the previous one is recorded."""
        method = self._settings.quick if quick else self._settings.method
        while method is not None and not _is_over(stop):
            limits = _next(board, ran, method, quick)
            if limits is None:
                return
            ran.setdefault(limits, set()).add(method)
            point = run_point(
                self._shared.problem(limits),
                self._settings,
                board.points[limits],
                quick=quick,
                alone=True,
                stop=stop,
            )
            yield point, method


class _Work(NamedTuple):
    """Data that worker processes need to run points."""

    instance: Instance
    longest_s: float
    tanks: Tanks
    settings: Settings

    @property
    def key(self) -> tuple[str, float, Tanks, Settings]:
        """Identity of the work; instances with given connections cannot be compared."""
        return self.instance.sha256, self.longest_s, self.tanks, self.settings


_mine: tuple[Any, Shared] | None = None
"""Key of this process's latest work, and the data shared by its points."""


def _run_there(work: _Work, known: Point, quick: bool) -> Point:
    global _mine
    if _mine is None or _mine[0] != work.key:
        _mine = work.key, Shared(work.instance, work.longest_s, tanks=work.tanks)
    problem = _mine[1].problem(known.limits)
    return run_point(problem, work.settings, known, quick=quick, alone=False, stop=None)


class _Beside:
    """Concurrent runs in workers, which keep the data shared by points."""

    def __init__(self, work: _Work, calls: Calls) -> None:
        self._work, self._calls = work, calls
        self.elsewhere_s = 0.0

    def __enter__(self) -> _Beside:
        return self

    def __exit__(self, *_: object) -> None:
        self._calls.close()

    def run(
        self,
        board: KnownPoints,
        ran: dict[PointLimits, set[str]],
        *,
        quick: bool,
        stop: Stop | None,
    ) -> Iterator[tuple[Point, str]]:
        """Runs of a pass, the next one starting as soon as one has ended."""
        settings = self._work.settings
        method = settings.quick if quick else settings.method
        running: set[Future[Point]] = set()
        while method is not None:
            while len(running) < self._calls.count and not _is_over(stop):
                limits = _next(board, ran, method, quick)
                if limits is None:
                    break
                ran.setdefault(limits, set()).add(method)
                known = board.points[limits]
                running.add(self._calls.submit(_run_there, self._work, known, quick))
            if not running:
                return
            done, running = wait(running, return_when=FIRST_COMPLETED)
            for each in done:
                point = self._calls.result(each)
                self.elsewhere_s += point.cpu_s
                yield point, method
