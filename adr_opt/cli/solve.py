"""``solve``: plan a mission."""

from __future__ import annotations

import click

from ..errors import InputError
from .output import emit, emit_json, emit_rich, say, terminal_width
from .parameters import (
    check_out,
    instance_argument,
    json_option,
    parse_assignments,
    quiet_option,
    run_options,
)


@click.command("solve")
@instance_argument
@click.option("--method", metavar="NAME", help="Planner; 'methods' lists them and the default.")
@click.option(
    "--time-limit", type=float, metavar="S", help="Wall time, the timetable included; 10 s."
)
@run_options
@click.option("--policy", metavar="FILE", help="Short for --option policy=FILE.")
@click.option("--decode", metavar="HOW", help="Short for --option decode=HOW.")
@click.option("--repair", is_flag=True, help="Keep the legal beginning of an illegal --start.")
@click.option("--bound", "bound_name", metavar="NAME", help="Bound to run beside the planner.")
@click.option("--out", metavar="FILE", help="Plan file to write.")
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
    policy: str | None,
    decode: str | None,
    repair: bool,
    bound_name: str | None,
    out: str | None,
    as_json: bool,
    quiet: bool,
) -> int:
    """Plan the mission of INSTANCE and show its timeline.

    Ctrl-C asks for the best plan so far; twice, it aborts. Exit status 1: no plan.
    """
    from .. import front
    from ..instance import load
    from ..plan import load_plan
    from ..planner import BOUNDS, PLANNERS
    from ..wording import status_words
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

    result = work(
        lambda stop, progress: front.run(
            PLANNERS, instance, method, time_limit=time_limit, seed=seed, stop=stop,
            progress=progress, start=start, repair=repair, jobs=jobs, iterations=iterations,
            bound=bound_name, margin=margin, options=options, building=progress.building,
            sizing=progress.sizing,
        ),
        live=wanted(as_json, quiet),
        quiet=quiet,
    )  # fmt: skip
    if not quiet:
        for note in result.notes:
            say(f"note: {note}")
    if result.plan is None:
        if as_json:
            reference = {"name": instance.name, "sha256": instance.sha256}
            emit_json({"instance": reference, "margin": margin, **result.to_dict()})
        if not quiet:
            say(f"no plan: {method} ended with status {result.status}")
        return 1
    not_written: InputError | None = None
    if out is not None:
        try:
            result.plan.save(out)
            if not quiet:
                status = status_words(result.plan.status)
                say(f"wrote {out}: objective {result.objective:g}, {status}")
        except InputError as error:
            not_written = error
    if not as_json:
        from .timeline import summary, timeline

        emit_rich(timeline(instance, result.plan, terminal_width()))
        emit(summary(instance, result.plan))
    if as_json or not_written is not None:
        emit(result.plan.to_json())
    if not_written is not None:
        # It may have taken hours: what cannot be kept is at least said.
        raise InputError(f"{not_written}; the plan is on standard output instead")
    return 1 if result.status == "infeasible" else 0
