"""``bound``: prove how much any plan of a mission can collect."""

from __future__ import annotations

import math

import click

from ...common.errors import InputError
from . import complete, param
from .certificates import certificate_option, check_certificate, save_certificate
from .output import emit
from .parameters import parse_assignments, run_options


@click.command("bound")
@param.instance
@param.word(
    "--method",
    "NAME",
    "Bound; 'methods' lists them and the default.",
    shell_complete=complete.bounds,
)
@param.time_limit("Wall-clock limit, timetable included; default 60 s.")
@run_options
@certificate_option
@param.spoken
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
    certificate_path: str | None,
    as_json: bool,
    quiet: bool,
) -> int:
    """Prove how much any plan of INSTANCE can collect.

    Ctrl-C stops with the best bound so far; a second one aborts. Exit status 1: infeasible.
    """
    from ...common.wording import status_words
    from ...plan.plan import Plan
    from ...problem.instance import load
    from ...run import front
    from ...run.methods import BOUNDS
    from .work import emit_result, run_method

    method = method or front.DEFAULT_BOUND
    time_limit = front.DEFAULT_BOUND_TIME_LIMIT_S if time_limit is None else time_limit
    options = parse_assignments(front.method_of(method, BOUNDS), assignments)
    instance = load(instance_path)
    start = None if start_path is None else Plan.load(start_path)
    check_certificate(
        certificate_path,
        instance,
        method,
        None,
        instance_path,
        start_path,
        margin=margin,
        group=BOUNDS,
    )

    given = front.RunOptions(
        time_limit, seed, start, jobs=jobs, iterations=iterations, margin=margin, options=options
    )
    result = run_method(BOUNDS, instance, method, given, as_json=as_json, quiet=quiet)
    not_written: InputError | None = None
    if certificate_path is not None:
        try:
            save_certificate(certificate_path, instance, result, quiet, plan=False)
        except InputError as error:
            not_written = error
    if as_json:
        emit_result(instance, margin, result)
    else:
        proven = f"{result.upper_bound:.6g}" if math.isfinite(result.upper_bound) else "none proven"
        status = status_words(result.status)
        emit(f"upper bound {proven}, {status}, runtime {result.runtime_s:.2f} s")
        plan = result.plan
        if plan is not None and plan.cost_bound is not None:
            emit(f"cost bound {plan.cost_bound:.6g}, of a plan that costs {plan.cost:.6g}")
        for name, count in result.counters.items():
            emit(f"  {name} {count:g}")
    if not_written is not None:
        # It may have taken hours: the bound is said, if nothing else of it can be kept.
        raise not_written
    return 1 if result.status == "infeasible" else 0
