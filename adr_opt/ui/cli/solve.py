"""``solve``: plan a mission."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from typing import TYPE_CHECKING, Any

import click

from ...common.errors import InputError
from ...common.wording import status_words
from .certificates import certificate_option, check_certificate, save_certificate
from .flown import flight_line, flown_plan, no_fly_option, refined_plan
from .output import emit, emit_json, emit_rich, say, terminal_width
from .parameters import (
    check_out,
    instance_argument,
    json_option,
    parse_assignments,
    quiet_option,
    run_options,
)
from .refining_loop import Refining, refine_options, run_refined, save_refined, tell_refined

if TYPE_CHECKING:
    from ...fly.refine.loop import RefinedResult
    from ...plan.plan import Plan


@click.command("solve")
@instance_argument
@click.option("--method", metavar="NAME", help="Planner; 'methods' lists them and the default.")
@click.option(
    "--time-limit", type=float, metavar="S", help="Wall time, the timetable included; 10 s."
)
@run_options
@click.option(
    "--memory",
    "memory_gib",
    type=float,
    metavar="GIB",
    help="Most memory of the timetable; beyond it, the nearest pairs alone. 2 GiB.",
)
@click.option("--policy", metavar="FILE", help="Short for --option policy=FILE.")
@click.option("--decode", metavar="HOW", help="Short for --option decode=HOW.")
@click.option("--repair", is_flag=True, help="Keep the legal beginning of an illegal --start.")
@click.option("--bound", "bound_name", metavar="NAME", help="Bound to run beside the planner.")
@click.option("--out", metavar="FILE", help="Plan file to write.")
@certificate_option
@refine_options
@no_fly_option
@json_option
@quiet_option
def command(
    instance_path: str,
    method: str | None,
    time_limit: float | None,
    seed: int,
    iterations: int | None,
    margin: float,
    jobs: int | None,
    start_path: str | None,
    assignments: tuple[str, ...],
    memory_gib: float | None,
    policy: str | None,
    decode: str | None,
    repair: bool,
    bound_name: str | None,
    out: str | None,
    certificate_path: str | None,
    no_fly: bool,
    as_json: bool,
    quiet: bool,
    **refining_options: Any,
) -> int:
    """Plan the mission of INSTANCE and show its timeline.

    When it ends, the plan is flown in mean motion on the true orbits, after the time limit: the
    last line says what its legs took and what each tank has left.

    Ctrl-C asks for the best plan so far; twice, it aborts. Exit status 1: no plan, or with --refine
    none that holds.
    """
    from ...analysis.grids import grid_advice
    from ...mission.problem import problem_of
    from ...plan.plan import load_plan
    from ...problem.instance import load
    from ...run import front
    from ...run.methods import BOUNDS, PLANNERS
    from .live import wanted
    from .work import work

    method = method or front.DEFAULT_METHOD
    time_limit = front.DEFAULT_TIME_LIMIT_S if time_limit is None else time_limit
    if bound_name is not None:
        front.method_of(bound_name, BOUNDS)
    if repair and start_path is None:
        raise InputError("--repair mends a start plan, but none is given; give one with --start")
    for name, value in (("policy", policy), ("decode", decode)):
        if value is not None:
            assignments = (*assignments, f"{name}={value}")
    options = parse_assignments(front.method_of(method), assignments)
    instance = load(instance_path)
    start = None if start_path is None else load_plan(start_path)
    check_out(out, instance_path)
    check_certificate(
        certificate_path,
        instance,
        method,
        bound_name,
        instance_path,
        start_path,
        margin=margin,
        out=out,
        refine=bool(refining_options["refine"]),
    )
    refining = Refining(**refining_options)
    refining.check(instance_path, out)
    given = front.RunOptions(
        time_limit, seed, start, repair, jobs, iterations, bound_name, margin, memory_gib, options
    )
    looped: RefinedResult | None = None
    live, problem = wanted(as_json, quiet), problem_of(instance)
    if refining.refine:
        looped = work(
            lambda stop, progress: run_refined(
                instance, method, refining, progress, quiet, stop=stop, wanted=given
            ),
            live=live, quiet=quiet,
        )  # fmt: skip
        result = looped.result
    else:
        result = work(
            lambda stop, progress: front.run(
                PLANNERS, problem, method, given, stop=stop, progress=progress,
                building=progress.building, sizing=progress.sizing,
            ),
            live=live, quiet=quiet,
        )  # fmt: skip
    if not quiet:
        for note in result.notes:
            say(f"note: {note}")
    if result.plan is None:
        if looped is not None and as_json:
            tell_refined(looped, as_json)
        elif as_json:
            reference = {"name": instance.name, "sha256": instance.sha256}
            emit_json({"instance": reference, "margin": margin, **result.to_dict()})
        if not quiet:
            why = f"{method} ended with status {result.status}" if looped is None else looped.reason
            say(f"no plan: {why}")
        if certificate_path is not None and result.status == "infeasible":
            save_certificate(certificate_path, instance, result, quiet)
        return 1
    plan = result.plan
    if looped is not None:
        looped = refined_plan(instance, looped)
        plan = looped.plan or plan
    unsaved = _first_trouble(partial(_save_plan, plan, out, quiet))
    is_kept = out is not None and unsaved is None
    others = _first_trouble(
        *(() if looped is None else (partial(save_refined, looped, refining.refined_out, quiet),)),
        *(() if certificate_path is None else
          (partial(save_certificate, certificate_path, instance, result, quiet),)),
    )  # fmt: skip
    not_written = unsaved or others
    if not quiet and looped is None and problem.has_timetable:
        advice = grid_advice(problem, plan)
        if advice is not None:
            say(f"note: {advice}")
    if not as_json:
        from .timeline import by_chaser, summary, timelines

        for table in timelines(instance, plan, terminal_width()):
            emit_rich(table)
        for sentence in by_chaser(instance, plan):
            emit(sentence)
        emit(summary(instance, plan))
    if looped is not None:
        tell_refined(looped, as_json)
    elif not no_fly:
        # The plan is safe by now, whatever becomes of its flight.
        plan, flight = flown_plan(instance, plan)
        if plan.flown is not None and is_kept:
            lacking = _first_trouble(partial(_save_plan, plan, out, quiet=True))
            if lacking is not None and not quiet:
                say(f"the plan is written, but not what its flight came to: {lacking}")
        if not as_json:
            emit(flight_line(flight))
    if (as_json and looped is None) or (not_written is not None and not is_kept):
        emit(plan.to_json())
    if not_written is not None:
        # It may have taken hours: what cannot be kept is at least said.
        place = f"in {out}" if is_kept else "on standard output instead"
        raise InputError(f"{not_written}; the plan is {place}")
    failed = result.status == "infeasible" if looped is None else not looped.holds
    return 1 if failed else 0


def _save_plan(plan: Plan, out: str | None, quiet: bool) -> None:
    if out is None:
        return
    plan.save(out)
    if not quiet:
        say(f"wrote {out}: objective {plan.objective:g}, {status_words(plan.status)}")


def _first_trouble(*steps: Callable[[], None]) -> InputError | None:
    """Take all steps, and tell what was wrong with the first one with which something was."""
    trouble: InputError | None = None
    for step in steps:
        try:
            step()
        except InputError as error:
            trouble = trouble or error
    return trouble
