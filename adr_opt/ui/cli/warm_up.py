"""``warm-up``: compile the kernels of methods in advance."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import click

from ...common.errors import InputError
from ...common.processors import usable_cores
from . import complete, param
from .output import emit, emit_json, say

if TYPE_CHECKING:
    from ...run.method_spec import MethodSpec
    from ...run.warm_up import PracticeKind

ENVIRONMENT = "environment"
"""Name for the kernels of the environment and its policies."""


@click.command("warm-up", short_help="Compile the kernels of methods once for all runs.")
@click.argument("methods", nargs=-1, metavar="[METHOD]...", shell_complete=complete.methods)
@param.count("--jobs", "N", "Number of processes; by default one for each core.")
@param.spoken
def command(methods: tuple[str, ...], jobs: int | None, as_json: bool, quiet: bool) -> int:
    """Compile the kernels of METHODs, by default of all planners and bounds.

    METHOD may also be environment, for the kernels that training calls.

    Compiled kernels are kept in a folder of the user, or in the one that ADR_OPT_CACHE_DIR names,
    and no run compiles them again until they change. Exit status 1: they cannot be kept.
    """
    from ...kernels.core import cache
    from ...run.methods import BOUNDS, PLANNERS, names

    known = dict.fromkeys((*names(PLANNERS), *names(BOUNDS), ENVIRONMENT))
    for method in methods:
        if method not in known:
            raise InputError(f"method {method!r} is unknown; use one of: {', '.join(known)}")
    if jobs is not None and jobs < 1:
        raise InputError(f"--jobs {jobs}: must be ≥ 1")
    wanted = list(dict.fromkeys(methods or known))
    say(
        f"compiling for {', '.join(wanted)}; kernels that are compiled already are skipped",
        unless=quiet,
    )
    rows = compile_for(wanted, jobs or usable_cores())
    trouble = next((row.pop("trouble") for row in rows if row.get("trouble")), None)
    for row in rows:
        row.pop("trouble", None)
        row.pop("files")
    folder = str(next(iter(cache.folders()), ""))
    if as_json:
        emit_json({"folder": folder, "trouble": trouble, "methods": rows})
    elif not quiet:
        for row in rows:
            emit(f"{row['method']:<16}{row['problem'] or _compiled(row['compiling_s'])}")
    if trouble is not None:
        say(f"compiled kernels cannot be kept: {trouble}")
        return 1
    if not (quiet or as_json):
        emit(f"kept in {folder}")
    return 0


def _compiled(seconds: float) -> str:
    return f"compiled in {seconds:.1f} s" if seconds > 0.0 else "was compiled already"


def _row(method: str, problem: Exception | None = None) -> dict[str, Any]:
    """Report of this process: time, problems, and files of its kernels."""
    from ...kernels.core import cache
    from ...kernels.core.compile import compiling_s

    said = None if problem is None else f"left out: {problem}"
    trouble = cache.trouble()
    return {
        "method": method,
        "compiling_s": compiling_s(),
        "problem": said,
        "trouble": trouble,
        "files": cache.used(),
    }


def compile_for(methods: list[str], jobs: int) -> list[dict[str, Any]]:
    """Compile the kernels of methods in parallel processes; one report each."""
    # First what all of them need, or each process would compile it anew.
    return [_common(), *_compile_all(methods, jobs)]


def _common() -> dict[str, Any]:
    """Compile timetables, rules, burns and low thrust, the check and the flight in mean motion."""
    from ...fly.flight.retargeted import practise
    from ...judge.check.verdict import check
    from ...legs.families.low_thrust import too_weak
    from ...mission.certified import certify
    from ...run.warm_up import practice_mission, thrusting_problem

    for drifts in (False, True):
        mission = practice_mission(drifts)
        plan = certify(mission, "practice", (1,), seed=0, runtime_s=0.0).plan
        if plan is not None:
            check(mission.instance, plan)
            practise(mission.instance, plan.legs[0])
        mission.timetable.matrices([0.0])
    electric = thrusting_problem()
    too_weak(electric.instance)
    plan = certify(electric.missions[0], "practice", (1,), seed=0, runtime_s=0.0).plan
    if plan is not None:
        check(electric.instance, plan)
    return _row("(all)")


def _compile_all(methods: list[str], jobs: int) -> list[dict[str, Any]]:
    """Compile for each method in its own process, several at a time."""
    import multiprocessing
    import signal
    from concurrent.futures import ProcessPoolExecutor

    with ProcessPoolExecutor(
        min(jobs, len(methods)),
        multiprocessing.get_context("spawn"),
        initializer=signal.signal,
        initargs=(signal.SIGINT, signal.SIG_DFL),
        max_tasks_per_child=1,
    ) as pool:
        return list(pool.map(_compile_one, methods))


def _is_for(kind: PracticeKind, spec: MethodSpec) -> bool:
    """Whether a method serves a kind of mission, and takes a start plan if the kind has one."""
    from ...problem.support import follows_all

    return (
        spec.starts >= kind.starts
        and spec.several >= kind.several
        and spec.on_demand >= kind.asks
        and spec.tours >= kind.tours
        and follows_all(kind.problem().instance, spec.follows)
    )


def _kinds() -> tuple[PracticeKind, ...]:
    """Missions and calls that reach kernels of their own."""
    from ...run.warm_up import PracticeKind

    return (
        PracticeKind(),
        PracticeKind(starts=True),
        PracticeKind(drifts=True),
        PracticeKind(drifts=True, starts=True),
        PracticeKind(asks=True),
        PracticeKind(several=True),
        PracticeKind(several=True, starts=True),
        PracticeKind(several=True, drifts=True),
        PracticeKind(several=True, asks=True),
        PracticeKind(tours=True),
        PracticeKind(thrusts=True),
        PracticeKind(thrusts=True, starts=True),
        PracticeKind(thrusts=True, several=True),
        PracticeKind(timed=True),
        PracticeKind(timed=True, tours=True),
    )


def _compile_one(method: str) -> dict[str, Any]:
    from ...run import front
    from ...run.methods import BOUNDS, PLANNERS, names

    if method == ENVIRONMENT:
        from ...learning.episodes import practise

        practise()
        return _row(method)
    problem = None
    for group in (PLANNERS, BOUNDS):
        if method in names(group):
            try:
                spec = front.spec_of(method, group)
                usual, *others = _kinds()
                problem = problem or front.warm_up(group, method, usual)
                for kind in others:
                    if _is_for(kind, spec):
                        front.warm_up(group, method, kind)
            except InputError as error:  # declared, and cannot be imported
                problem = error
    return _row(method, problem)
