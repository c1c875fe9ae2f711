"""Trade-offs: a study of the points of some axes, each run chosen from what is known so far."""

from __future__ import annotations

import os
import time
from collections import defaultdict
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import replace

from ...common.errors import InputError
from ...common.stop import MaxRuntime, Stop
from ...judge.admit import AnyPlan, admit
from ...mission.problem import Problem
from ...problem.instance import Instance
from ...run.front import DEFAULT_METHOD, DEFAULT_TIME_LIMIT_S
from ...run.method_call import refuse_unable, spec_of
from ...study import Run, check_jobs
from .axes import Axis, PointLimits, grid, own_limits, tanks_of
from .point_runs import PointRun, PointRuns
from .points import Impossible, KnownPoints, Point, Tradeoff
from .shared import slack_m_s, variant

QUICK = "beam"
"""Planner of the first pass over all points, where it supports the instance."""

Told = Callable[[Point, "KnownPoints"], None]


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
    starts: Sequence[AnyPlan] = (),
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
        :func:`adr_opt.study.cluster.client_of` takes it.
    path : path, optional
        File of the runs, see :mod:`adr_opt.study.file`: what is in it is not run again.
    starts : sequence of Plan
        Plans of the instance that are there already. Their orders are timed anew at each point,
        before any run; and the limits of the instance are a point, too, if drives are not varied.
    stop : Stop, optional
        Ends all of it early; a run that it cuts short does not count.
    told : callable
        Called with each run's point and what is known of all points then.

    Raises
    ------
    InputError
        The axes, the method, the file or a plan do not fit, or a plan is not legal.
    """
    began = time.perf_counter()
    MaxRuntime(time_limit)
    check_jobs(jobs, cluster)
    given = dict.fromkeys(tuple(admit(instance, each).plan.orders.values()) for each in starts)
    limits = grid(instance, axes)
    if given:
        axes, limits = own_limits(instance, axes, limits)
    tanks = tanks_of(instance, axes)
    for each in limits:
        variant(instance, each, tanks=tanks)  # what is not valid is refused before any work
    runs = PointRuns(instance, max(each.duration_s for each in limits), tanks, time_limit, seed)
    problem = runs.shared.problem(limits[0])
    refuse_unable(problem, spec_of(method))
    board, ran = KnownPoints(limits, slack_m_s(instance)), defaultdict[str, set[PointLimits]](set)

    def add(point: Point) -> None:
        try:
            board.add(point)
        except Impossible as error:
            if not running.has_rows:
                raise
            raise InputError(
                f"{path}: a bound of this file lies below what a plan collects that is "
                f"found now ({str(error).partition(':')[0]}); name another file"
            ) from error
        told(point, board)

    quick, cpu_s = _quick(problem, method), 0.0
    with Run(runs.study(method), path, jobs=jobs, cluster=cluster, stop=stop) as running:
        _take_in(board, running, ran, dict.fromkeys((quick or method, method)), path)
        for point in runs.given(limits, given):
            add(point)
        passes = [] if quick is None else [_pass(board, ran[quick], quick, quick=True)]
        for groups in (*passes, _pass(board, ran[method], method, quick=False)):
            for _, point in running.rows(groups):
                cpu_s += point.cpu_s
                add(point)
    propellants_kg = dict(tanks.values) if tanks.limit == "propellant_kg" else {}
    points = tuple(
        replace(board.points[each], propellant_kg=propellants_kg.get(each.delta_v_m_s))
        for each in limits
    )
    return Tradeoff(instance, tuple(axes), points, time.perf_counter() - began, cpu_s)


def _quick(problem: Problem, method: str) -> str | None:
    """Planner of the first pass; None if it is just ``method``."""
    try:
        quick = spec_of(QUICK)
    except InputError:
        return None
    plans = len(problem.missions) == 1 and problem.missions[0].rules.loads is None
    return QUICK if method != QUICK and (plans or quick.several) else None


def _take_in(
    board: KnownPoints,
    running: Run[PointRun, Point],
    ran: dict[str, set[PointLimits]],
    methods: Iterable[str],
    path: str | os.PathLike[str] | None,
) -> None:
    """Add the rows of the file to the known points.

    Raises
    ------
    InputError
        A row cannot be true; the sentence says which and why.
    """
    for limits in sorted(board.points):
        for method in methods:
            point = running.known(PointRun(method, board.points[limits]))
            if point is None:
                continue
            try:
                board.add(point)
            except Impossible:
                raise InputError(
                    f"{path}: a bound in the file is below the prize of one of its plans, so one "
                    "of the two was changed; name another file"
                ) from None
            ran[method].add(limits)


def _pass(
    board: KnownPoints, ran: set[PointLimits], method: str, *, quick: bool
) -> Iterator[tuple[PointRun]]:
    """Runs of a planner over points, each chosen when it can begin."""
    while True:
        if quick:
            waiting = (each for each, point in board.points.items() if not point.proven)
            limits = next((each for each in waiting if each not in ran), None)
        else:
            limits = next(board.open(ran), None)
        if limits is None:
            return
        ran.add(limits)
        yield (PointRun(method, board.points[limits]),)
