"""The command line of the benchmark."""

from __future__ import annotations

import argparse
import math
import sys
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import NoReturn

from adr_opt.common.errors import InputError
from adr_opt.common.processors import usable_cores
from adr_opt.run.front import method_of
from adr_opt.run.methods import BOUNDS
from adr_opt.sources.generator import LARGEST_SEED

from .methods import DEFAULT_METHODS, parse_methods
from .trials import DEFAULT_ZONES, MOST_ITERATIONS, BoundCall, Protocol, parse_suites

MOST_FIELDS = LARGEST_SEED // MOST_ITERATIONS
QUICK = {"suite": ["all"], "cases": 5, "iterations": 2, "time_limit": 2.0}
FULL = {"suite": ["nominal"], "cases": 100, "iterations": 10, "time_limit": 10.0}


@dataclass(frozen=True)
class Options:
    """The command line, checked."""

    protocol: Protocol | None
    out: Path
    jobs: int
    cluster: str | None
    report_only: bool
    no_report: bool
    retry_failed: bool
    quiet: bool
    command: str


class _Parser(argparse.ArgumentParser):
    def error(self, message: str) -> NoReturn:
        raise InputError(f"{message}; see --help")


def parse(arguments: Sequence[str], description: str) -> Options:
    """The options of a call.

    Raises
    ------
    InputError
        Something is wrong with it, in one sentence.
    """
    parser = _Parser(
        prog="run_all.py",
        description=description,
        allow_abbrev=False,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    parser.add_argument(
        "--suite", action="append", help="families, by comma; all: the published three [nominal]"
    )
    parser.add_argument("--cases", type=int, help="fields of each suite, by seed from 0 [100]")
    parser.add_argument("--iterations", type=int, help="draws of zones for each field [10]")
    parser.add_argument(
        "--methods",
        action="append",
        help=f"NAME[:OPTION=VALUE,…][@SECONDS], by comma [{DEFAULT_METHODS}]",
    )
    parser.add_argument("--time-limit", type=float, help="seconds for each plan [10]")
    parser.add_argument("--seed", type=int, default=0, help="of every planner [0]")
    parser.add_argument(
        "--zones", type=int, default=DEFAULT_ZONES, help=f"keep-out zones [{DEFAULT_ZONES}]"
    )
    parser.add_argument("--bound", help="a bound to prove once for each field and iteration")
    parser.add_argument(
        "--bound-time-limit", type=float, default=30.0, help="seconds for each bound [30]"
    )
    parser.add_argument("--jobs", type=int, help="worker processes [one for each core]")
    parser.add_argument("--cluster", help="dask://HOST:PORT of a scheduler, instead of --jobs")
    parser.add_argument("--out", type=Path, help="folder of results and report")
    parser.add_argument(
        "--quick",
        action="store_true",
        help="--suite all --cases 5 --iterations 2 --time-limit 2, where nothing else is given",
    )
    parser.add_argument("--report-only", action="store_true", help="plan nothing, report what is")
    parser.add_argument("--no-report", action="store_true", help="only keep rows")
    parser.add_argument(
        "--retry-failed", action="store_true", help="forget rows without a legal plan first"
    )
    parser.add_argument("--quiet", action="store_true", help="no progress")
    typed = parser.parse_args(list(arguments))
    if typed.out is None:
        raise InputError("--out is missing: give a folder for results and report; see --help")
    jobs = typed.jobs if typed.jobs is not None else usable_cores()
    if not 1 <= jobs <= 10_000:
        raise InputError(f"--jobs = {jobs}: must be a number of processes, at least 1")
    if typed.cluster is not None and typed.jobs is not None:
        raise InputError("--jobs and --cluster exclude each other; the cluster has its own workers")
    for name in ("no_report", "retry_failed"):
        if typed.report_only and getattr(typed, name):
            option = name.replace("_", "-")
            raise InputError(f"--report-only and --{option} exclude each other; leave one out")
    protocol = _protocol(typed)
    return Options(
        protocol=None if typed.report_only else protocol,
        out=typed.out,
        jobs=jobs,
        cluster=typed.cluster,
        report_only=typed.report_only,
        no_report=typed.no_report,
        retry_failed=typed.retry_failed,
        quiet=typed.quiet,
        command=" ".join(["bench/run_all.py", *arguments]),
    )


def _protocol(typed: argparse.Namespace) -> Protocol:
    default = QUICK if typed.quick else FULL
    chosen = {
        name: value if getattr(typed, name) is None else getattr(typed, name)
        for name, value in default.items()
    }
    fields, iterations, zones = chosen["cases"], chosen["iterations"], typed.zones
    for option, value, least, most in (
        ("--cases", fields, 1, MOST_FIELDS),
        ("--iterations", iterations, 1, MOST_ITERATIONS),
        ("--seed", typed.seed, 0, LARGEST_SEED),
        ("--zones", zones, 0, 1000),
    ):
        if not least <= value <= most:
            raise InputError(f"{option} = {value}: must be between {least} and {most}")
    if zones == 0 and iterations > 1:
        raise InputError(
            f"--iterations = {iterations}: without zones all iterations are the same mission; "
            "give --iterations 1 with --zones 0"
        )
    for option, value in (
        ("--time-limit", chosen["time_limit"]),
        ("--bound-time-limit", typed.bound_time_limit),
    ):
        if not (math.isfinite(value) and value > 0.0):
            raise InputError(f"{option} = {value:g}: must be positive, in seconds")
    bound = None
    if typed.bound is not None:
        try:
            method_of(typed.bound, BOUNDS)
        except InputError as error:
            raise InputError(f"--bound: {error}") from None
        bound = BoundCall(typed.bound, typed.bound_time_limit)
    protocol = Protocol(
        suites=parse_suites(chosen["suite"]),
        fields=fields,
        iterations=iterations,
        zones=zones,
        methods=parse_methods(typed.methods or [DEFAULT_METHODS], chosen["time_limit"]),
        seed=typed.seed,
        bound=bound,
    )
    for suite in protocol.suites:
        if not protocol.methods_for(suite):
            raise InputError(
                f"--suite: {suite!r} has several chasers, for which none of the methods plans; "
                "give for example --methods greedy-guarded,auto"
            )
    return protocol


def say(sentence: str) -> None:
    """A message to the user."""
    print(sentence, file=sys.stderr, flush=True)
