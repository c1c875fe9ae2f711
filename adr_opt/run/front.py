"""Entry points of planners and bounds: solve or bound an instance."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import replace
from functools import partial
from itertools import chain
from typing import Any

from ..common.errors import InputError
from ..common.progress import Progress, Relayed, silent
from ..common.stop import AnyOf, MaxIterations, MaxRuntime, Stop
from ..legs.connection_finder import estimate
from ..legs.families.low_thrust import too_weak
from ..legs.families.registry import registered_of
from ..legs.timetable_size import TABLE_BYTES, Size, too_large
from ..mission.problem import AnyProblem, Problem, Routes, problem_of
from ..mission.result import Result, noted, proven_of
from ..plan.plane_drift import drift_warning
from ..problem.instance import Instance
from ..problem.least_time import too_short
from ..problem.support import follows_all
from . import by_masses
from .course import RunCourse
from .method_call import (
    FALLBACK,
    Prepared,
    is_tour,
    method_of,
    prepare,
    refuse_unable,
    spec_of,
    warm_up,
)
from .method_spec import named
from .methods import BOUNDS, PLANNERS
from .run_options import (
    DEFAULT_BOUND,
    DEFAULT_BOUND_TIME_LIMIT_S,
    DEFAULT_METHOD,
    DEFAULT_TIME_LIMIT_S,
    RunOptions,
    Start,
)
from .side_by_side import together
from .start_plan import start_destinations
from .table_budget import ask_for_rows, candidates, has_first_routes, may_go_without, no_table

__all__ = [
    "DEFAULT_BOUND",
    "DEFAULT_BOUND_TIME_LIMIT_S",
    "DEFAULT_METHOD",
    "DEFAULT_TIME_LIMIT_S",
    "RunOptions",
    "bound",
    "method_of",
    "run",
    "solve",
    "spec_of",
    "warm_up",
]


SHORT_S = 3.0
"""Time limit below which no timetable is built if a plan can be made without one [s]."""

WRITING_S, WRITING_SHARE = 1e-4, 0.4
"""Time reserved per body to make the legs and explain targets left out [s], and its largest share
of the time limit."""


def solve(  # noqa: PLR0913
    instance: AnyProblem,
    method: str = DEFAULT_METHOD,
    *,
    time_limit: float = DEFAULT_TIME_LIMIT_S,
    seed: int = 0,
    stop: Stop | None = None,
    progress: Progress = silent,
    start: Start | None = None,
    repair: bool = False,
    jobs: int | None = None,
    iterations: int | None = None,
    bound: str | None = None,
    margin: float = 0.0,
    memory_gib: float | None = None,
    **method_options: Any,
) -> Result:
    """Plan a mission.

    Parameters
    ----------
    instance : Instance, path, dict, Mission or Problem
        The path of an instance file is loaded, a dictionary taken for its content. The latter two
        bring their timetables along.
    method : str
        Name of an installed planner.
    time_limit : float
        Wall time, the timetable included, ``math.inf`` for no limit [s]. Quick planners end by
        themselves. Where it is too short for the timetable, planning uses that of the nearest
        pairs, and a note says so; see :mod:`.table_budget`. Time spent compiling does not count.
    seed : int
    stop : Stop, optional
        A further criterion; planning ends at whichever comes first.
    progress : callable
        Called with incumbent and bound whenever one improves.
    start : Plan or sequence of int or str, optional
        A plan, or its bodies by number or name, to start from, for planners that take one; for
        several chasers a sequence of such sequences.
    repair : bool
        Start from the legal beginning of ``start`` instead of refusing an illegal one.
    jobs : int, optional
        Cores to use, 0 for all, for planners that can use several.
    iterations : int, optional
        Maximum number of iterations: with it and without a time limit, work and result are the same
        on any machine.
    bound : str, optional
        Name of an installed bound to run beside the planner. Both stop when they meet; if one ends
        early, the other goes on to the limit. ``start`` and ``jobs`` are given to it too if it
        takes them, and ``iterations`` limits each of the two by itself; see
        :func:`.side_by_side.together`.
    margin : float
        Share of each tank that the plan holds in reserve, for effects that the model neglects. The
        bound of the result holds for plans with that reserve; its ``plan``, which belongs to the
        instance, then states no bound.
    memory_gib : float, optional
        Maximum memory of the timetable, beyond which it has only the nearest pairs; by default 2,
        or 70 % of free memory if that is less [GiB].
    **method_options
        Options of the planner, see ``python -m adr_opt methods``.

    Returns
    -------
    Result

    Raises
    ------
    InputError
        Unknown method or option, a value out of range, or an illegal start plan.
    """
    wanted = RunOptions(
        time_limit, seed, start, repair, jobs, iterations, bound, margin, memory_gib, method_options
    )
    return run(PLANNERS, instance, method, wanted, stop=stop, progress=progress)


def bound(  # noqa: PLR0913
    instance: AnyProblem,
    method: str = DEFAULT_BOUND,
    *,
    time_limit: float = DEFAULT_BOUND_TIME_LIMIT_S,
    seed: int = 0,
    stop: Stop | None = None,
    progress: Progress = silent,
    start: Start | None = None,
    jobs: int | None = None,
    iterations: int | None = None,
    margin: float = 0.0,
    **method_options: Any,
) -> Result:
    """Prove how much any plan of a mission can collect.

    Parameters
    ----------
    instance : Instance, path, dict, Mission or Problem
    method : str
        Name of an installed bound.
    start : Plan or sequence of int or str, optional
        A known plan, or its bodies by number or name, for bounds that can use one: worse plans need
        not be searched.
    margin : float
        Share of each tank that all plans hold in reserve: the bound does not cover other plans.
    time_limit, seed, stop, progress, jobs, iterations, **method_options
        As in :func:`solve`.

    Returns
    -------
    Result
        With or without a plan; its ``upper_bound`` is proven.

    Raises
    ------
    InputError
        As in :func:`solve`.
    """
    wanted = RunOptions(
        time_limit,
        seed,
        start,
        jobs=jobs,
        iterations=iterations,
        margin=margin,
        options=method_options,
    )
    return run(BOUNDS, instance, method, wanted, stop=stop, progress=progress)


def run(
    group: str,
    instance: AnyProblem,
    method: str,
    wanted: RunOptions,
    *,
    stop: Stop | None = None,
    progress: Progress = silent,
    building: Callable[[float], None] = lambda share: None,
    sizing: Callable[[Size], None] = lambda size: None,
) -> Result:
    """Run a planner or a bound: the common part of :func:`solve` and :func:`bound`.

    Parameters
    ----------
    group : str
        ``methods.PLANNERS`` or ``methods.BOUNDS``.
    instance : Instance, path, dict, Mission or Problem
    method : str
    wanted : RunOptions
    stop : Stop, optional
        A further criterion.
    progress : callable
        Called with incumbent and bound whenever one improves.
    building : callable
        Called with the share of the timetable that is built.
    sizing : callable
        Called with the size of a large timetable before it is built.

    Returns
    -------
    Result

    Raises
    ------
    InputError
        As of :func:`solve`.
    """
    course = RunCourse(progress)
    return course.kept(
        _by_masses(
            group,
            problem_of(instance),
            method,
            wanted,
            course,
            partial(_run, stop=stop, building=building, sizing=sizing),
        )
    )


def _by_masses(
    group: str,
    whole: Problem,
    method: str,
    wanted: RunOptions,
    progress: Progress,
    once: Callable[..., Result],
) -> Result:
    """Run a planner or a bound, on a relaxed problem as well where costs depend on the mass."""
    if not whole.depends_on_mass:
        return once(group, whole, method, wanted, progress=progress)
    if group == BOUNDS:
        heard = by_masses.bounds_only(progress)
        return by_masses.bounded(once(group, whole.relaxed, method, wanted, progress=heard))
    prover = wanted.bound or (DEFAULT_BOUND if spec_of(method, group).shows_evidence else None)

    def plan(limit_s: float) -> Result:
        limited = replace(wanted, time_limit=limit_s, bound=None)
        heard = Relayed(lambda known, _: progress(known, math.inf), progress)
        return once(group, whole, method, limited, progress=heard)

    def prove(limit_s: float, objective: float, routes: Routes) -> Result:
        start: Any = routes[0] if len(routes) == 1 else routes
        limited = replace(
            wanted, time_limit=limit_s, bound=None, repair=False, options={}, start=start or None
        )
        heard = by_masses.bounds_only(progress, objective)
        return once(BOUNDS, whole.relaxed, str(prover), limited, progress=heard)

    kept = whole.with_margin(wanted.margin) if wanted.margin else whole
    return by_masses.planned(kept, wanted.time_limit, plan, prove if prover else None)


def _run(
    group: str,
    whole: Problem,
    method: str,
    wanted: RunOptions,
    *,
    stop: Stop | None,
    progress: Progress,
    building: Callable[[float], None],
    sizing: Callable[[Size], None],
) -> Result:
    """Run a planner or a bound on a problem as it stands."""
    start, repair, jobs, bound = wanted.start, wanted.repair, wanted.jobs, wanted.bound
    MaxRuntime(wanted.time_limit)  # a wrong one is refused before anything is compiled
    memory_gib, iterations = wanted.memory_gib, wanted.iterations
    if memory_gib is not None and not memory_gib > 0.0:
        raise InputError(f"memory_gib = {memory_gib!r}: must be a number above 0")
    if wanted.margin:
        whole = whole.with_margin(wanted.margin)
    # Each side counts its own iterations, or the work of one would depend on the other's speed.
    limits = [] if iterations is None else [MaxIterations(iterations) for _ in range(2)]
    known, prover = spec_of(method, group), None
    refuse_unable(whole, known, group)
    if bound is not None:
        prover = spec_of(bound, BOUNDS)
        refuse_unable(whole, prover, BOUNDS)
    both_jobs = jobs if prover is not None and prover.uses_cores else None
    only_prover = both_jobs is not None and not known.uses_cores
    its_jobs = None if only_prover else jobs
    prepared = prepare(
        group,
        method,
        seed=wanted.seed,
        starts=start is not None,
        repair=repair,
        options=wanted.options,
        jobs=its_jobs,
    )
    destinations = start_destinations(whole, () if start is None else start, repair=repair)
    others = () if stop is None else (stop,)
    drifts, tours = whole.connecting.is_listed, is_tour(whole, known)
    if tours and start is not None:
        raise InputError("start: a campaign planned as a tour takes no start plan; leave it out")
    bare = tours or (known.orders_all and bound is None and may_go_without(whole))
    if drifts and not whole.has_timetable and not bare:
        _announce(whole.instance, sizing)
    writing_s = min(WRITING_S * len(whole.names), WRITING_SHARE * wanted.time_limit)
    criteria: list[Stop] = [MaxRuntime(max(wanted.time_limit - writing_s, 1e-9)), *others]
    begun = None
    if known.begins and start is None and not (bare or whole.has_timetable):
        begun = _begun(whole, named(known.begins), wanted.seed, AnyOf(*criteria), progress)
        bare = begun is not None and bound is None and wanted.time_limit < SHORT_S
    elif group == PLANNERS and start is None and not (bare or prepared.on_demand):
        prepared, destinations = _at_once(whole, prepared, wanted.time_limit, progress)
    # Some methods look at all pairs by themselves: what they prove is proven of all.
    of_all = known.bounds_all_pairs
    hasty = of_all and group == BOUNDS and whole.alone is not None
    chosen = (
        no_table(whole)
        if bare
        else candidates(
            whole,
            wanted.time_limit,
            first=list(chain.from_iterable(destinations)) if group == PLANNERS or of_all else None,
            interrupted=lambda: stop is not None and stop.remaining_s() <= 0.0,
            building=building,
            table_bytes=TABLE_BYTES if memory_gib is None else memory_gib * 2.0**30,
            hasty=hasty,
            on_demand=prepared.on_demand or prepared.hurried,
        )
    )
    progress(-math.inf, math.inf)
    if not chosen.all and not hasty and (chosen.none or (group == BOUNDS and not of_all)):
        return chosen.nothing(method, wanted.seed)
    if start is not None:
        prepared = prepared.beginning_from(whole, destinations, repair)
    elif begun is not None:
        prepared = replace(prepared, arguments={**prepared.arguments, "start": begun})
    elif prepared.begun and known.starts:
        begins = prepared.beginning_from(whole, destinations, repair=True)
        prepared = replace(prepared, arguments=begins.arguments)
    if bound is None or prover is None or not chosen.all:
        planned = prepared(whole, AnyOf(*criteria, *limits[:1]), progress)
        return _beyond_the_model(whole, chosen.of_the_whole(planned, of_all=of_all))
    proving = prepare(BOUNDS, bound, seed=wanted.seed, jobs=both_jobs)
    if start is not None and prover.starts:
        proving = proving.beginning_from(whole, destinations, repair)
    result = together(whole, prepared, proving, AnyOf(*criteria), progress, limits)
    return _beyond_the_model(whole, result)


def _begun(
    problem: Problem, begins: Callable[..., Any], seed: int, stop: Stop, progress: Progress
) -> Routes | None:
    """First routes of a problem without a timetable, by a function of the method."""
    problem.do_without()
    try:
        found: Routes | None = begins(problem, seed=seed, stop=stop, progress=progress)
    finally:
        problem.forget_tables()
    return found


def _at_once(
    problem: Problem, prepared: Prepared, limit_s: float, progress: Progress
) -> tuple[Prepared, tuple[tuple[str, ...], ...]]:
    """A call that begins from routes found before a large timetable, and their bodies.

    Where there is no time for the timetable there are no other routes.
    """
    quick = spec_of(FALLBACK)
    none: tuple[tuple[str, ...], ...] = tuple(() for _ in problem.missions)
    if not has_first_routes(problem, limit_s) or not follows_all(problem.instance, quick.follows):
        return prepared, none
    if limit_s < SHORT_S:
        return replace(prepared, hurried=True), none
    ask_for_rows(problem)
    try:
        routes: Routes = named(quick.quick)(problem)
    finally:
        problem.forget_tables()
    progress(problem.shown(problem.collected(chain.from_iterable(routes))), math.inf)
    names = tuple(tuple(problem.names[j] for j in route) for route in routes)
    return replace(prepared, begun=routes), names


def _announce(instance: Instance, sizing: Callable[[Size], None]) -> None:
    """Announce the size of a large timetable before it is built.

    Raises
    ------
    InputError
        There is not enough memory for the long transfers. A part of the targets would be no help:
        which ones are near changes while one waits.
    """
    size = estimate(instance)
    if instance.transfer.max_drift_s > 0.0 and not size.fits:
        raise InputError(too_large(instance, size))
    if size.is_large:
        sizing(size)


def _beyond_the_model(problem: Problem, result: Result) -> Result:
    """A result with notes on the margin and on what the model neglects."""
    if problem.depends_on_mass:  # what is proven of the heaviest chaser is proven of no other
        result = by_masses.unproven(problem, result)
    notes, plan = _of_what_is_proven(problem, result.upper_bound), result.plan
    if plan is not None and (problem.margin or problem.connecting.corrections):
        # A plan file is read together with its instance, whose tanks may be used to the end, and
        # whose connections cost what the model says.
        plan = proven_of(problem, plan.objective).of(plan)
    drift = None if plan is None else drift_warning(problem.instance, plan)
    quickest = None if registered_of(problem.instance) else too_short(problem.instance)
    idle = plan is not None and not plan.legs
    weak = too_weak(problem.instance) if idle and problem.instance.has_low_thrust else None
    notes += [said for said in (drift, quickest, weak) if said is not None]
    return noted(replace(result, plan=plan), notes)


def _of_what_is_proven(problem: Problem, upper_bound: float) -> list[str]:
    """The note for a bound that holds for the model but not for the instance."""
    corrections, notes, of, other = problem.connecting.corrections, [], "", "that does not"
    if corrections:
        notes.append(f"connections are corrected by the costs of refined legs: {corrections}")
        of, other = " of the corrected connections", "of the model's connections"
    if problem.margin:
        reserves = sorted({each.reserve_m_s for each in problem.missions})
        listed = " or ".join(f"{reserve:g}" for reserve in reserves)
        kept = f"{100.0 * problem.margin:g} % of each tank ({listed} m/s)"
        of += f" that keeps back {kept}"
        if not math.isfinite(upper_bound):
            notes.append(f"{kept} is kept back")
    if of and math.isfinite(upper_bound):
        notes.append(f"no plan{of} collects more than {upper_bound:.6g}; one {other} may")
    return notes
