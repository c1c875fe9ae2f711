"""The published study again, with the column that it lacks: what is proven.

    python bench/run_all.py --suite all --cases 100 --iterations 10 --out results
    python bench/run_all.py --quick --out results
    python bench/run_all.py --report-only --out results

Every method plans the same fields with the same keep-out zones; every plan passes `check` before it
counts; every row goes to OUT/results.sqlite as it is finished. Killed at any moment and started
again, a run loses and repeats nothing. At the end OUT/report.html, summary.csv and pictures are
made from the rows alone.

Exit status 0: done; 1: done, but some planner raised or gave an illegal plan, and the report names
it; 2: the call is wrong, in one sentence, before any work starts, or the cluster went away; 130:
interrupted, what is finished is kept.
"""

from __future__ import annotations

import sys
from collections.abc import Sequence

from harness import options as command_line
from harness.backend import Backend
from harness.display import Display, clock
from harness.methods import labels
from harness.options import Options, say
from harness.report.failures import failures
from harness.report.write import need, write
from harness.runner import Runner, Summary
from harness.store import Store
from harness.work import PARTS

from adr_opt.common.errors import InputError

DONE, FAILED, WRONG, INTERRUPTED = 0, 1, 2, 130


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the benchmark; the exit status."""
    try:
        options = command_line.parse(
            sys.argv[1:] if arguments is None else arguments, __doc__ or ""
        )
        return _run(options)
    except InputError as error:
        say(str(error))
        return WRONG
    except KeyboardInterrupt:
        say("interrupted; what is finished is kept: the same command goes on from there")
        return INTERRUPTED


def _run(options: Options) -> int:
    if not options.no_report:
        need()
    store = Store(options.out, create=not options.report_only)
    try:
        if options.protocol is not None:
            summary = _plan(options, store)
            if summary is not None:
                say(_account(summary))
                if summary.broken is not None:
                    say(summary.broken)
                    return WRONG
        if not options.no_report:
            say(f"report: {write(store, options.out)}")
        results = store.results()
        short = labels(dict.fromkeys(row["method"] for row in results))
        said = failures(results, store.bounds(), short)
    finally:
        store.close()
    for failure in said:
        say(failure)
    return FAILED if said else DONE


def _plan(options: Options, store: Store) -> Summary | None:
    """Bring about what is missing; None if nothing was."""
    protocol = options.protocol
    assert protocol is not None
    if options.retry_failed:
        store.forget_failures()
    missing = store.missing(protocol)
    if not missing:
        say("nothing is missing")
        return None
    backend = _backend(options)
    try:
        wanted = (*protocol.methods, *([protocol.bound] if protocol.bound is not None else ()))
        wrong = backend.preflight(wanted)
        if wrong is not None:
            raise InputError(wrong)
        run = store.begin_run(options.command, protocol, backend.workers)
        with Display(protocol, missing, store.mean_seconds(), quiet=options.quiet) as display:
            return Runner(protocol, store, backend, display, run).run()
    finally:
        backend.close()


def _backend(options: Options) -> Backend:
    if options.cluster is not None:
        from harness.cluster import Cluster

        return Cluster(options.cluster)
    from harness.processes import Processes

    return Processes(options.jobs)


def _account(summary: Summary) -> str:
    """Breakdown of the time, in one sentence."""
    work = sum(summary.spent[part] for part in PARTS)
    shares = ", ".join(f"{part} {summary.spent[part]:.1f} s" for part in PARTS)
    text = (
        f"{summary.rows} rows in {clock(summary.wall_s)} ({summary.wall_s:.1f} s) with "
        f"{summary.workers} workers: {shares}"
    )
    if summary.deaths:
        # What a task that lost its worker had done is not known, so nothing is left to compare.
        return f"{text}; {summary.deaths} tasks lost their worker"
    planning = summary.spent["planning"]
    text += f"; harness {summary.overhead_s:.1f} s"
    if planning > 0.0:
        text += (
            f", {100 * summary.overhead_s / planning:.1f} % of planning, "
            f"{100 * summary.overhead_s / work:.1f} % of all work"
        )
    return text


if __name__ == "__main__":
    sys.exit(main())
