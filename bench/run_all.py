"""The published study again, with the column that it lacks: what is proven.

    python bench/run_all.py --suite all --cases 100 --iterations 10 --out results
    python bench/run_all.py --quick --out results
    python bench/run_all.py --report-only --out results

Every method plans the same fields with the same keep-out zones; every plan passes `check` before it
counts; every row goes to OUT/results.jsonl as it is finished, and one run at a time writes there.
Killed at any moment and started again, a run repeats only the plans that were being made. At the
end OUT/report.html, summary.csv and pictures are made from the rows alone.

Exit status 0: done; 1: done, but some planner raised or gave an illegal plan, and the report names
it; 2: the call is wrong, in one sentence, before any work starts, or the cluster went away; 130:
interrupted, what is finished is kept.
"""

from __future__ import annotations

import sys
import time
from collections.abc import Mapping, Sequence

from harness import options as command_line
from harness.display import Display, clock
from harness.methods import labels
from harness.options import Options, say
from harness.report.failures import failures
from harness.report.write import need, write
from harness.results import Facts, missing, path_in, results, study
from harness.trials import Protocol, Trial, Wanted
from harness.work import killed, practise

from adr_opt.common.errors import InputError
from adr_opt.study import Run, Study, run

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
    path = path_in(options.out, create=not options.report_only)
    if options.protocol is not None:
        _by_value(options.cluster)
        jobs = options.jobs if options.cluster is None else 1
        with Run(study(), path, jobs=jobs, cluster=options.cluster) as running:
            _plan(options, options.protocol, running)
    if not options.no_report:
        say(f"report: {write(path, options.out)}")
    rows, bounds = results(path)
    said = failures(rows, bounds, labels(dict.fromkeys(row["method"] for row in rows)))
    for failure in said:
        say(failure)
    return FAILED if said else DONE


def _plan(options: Options, protocol: Protocol, running: Run[Wanted, Facts]) -> None:
    """Bring about what is missing."""
    lacking = missing(running, protocol, retry_failed=options.retry_failed)
    if not lacking:
        say("nothing is missing")
        return
    workers = running.workers  # a cluster that is not there is refused before any work
    whats = [*protocol.methods, *([] if protocol.bound is None else [protocol.bound])]
    practice = Study("practice", 1, practise, key=repr, failed=killed, apart=True)
    for sentence in filter(None, run(practice, whats).values()):
        say(sentence)
    made, began = list[tuple[Wanted, Facts]](), time.monotonic()
    with Display(lacking, workers, quiet=options.quiet) as display:
        for wanted, facts in running.rows(lacking.values()):
            made.append((wanted, facts))
            display.kept(wanted, facts)
    say(_account(made, time.monotonic() - began, workers))


def _by_value(cluster: str | None) -> None:
    """Have the modules of the benchmark sent to the workers of a cluster, which lack them."""
    if cluster is None:
        return
    try:
        import cloudpickle
    except ImportError:
        return  # the cluster will say so
    import machine
    from harness import methods, trials, work

    for module in (machine, methods, trials, work):
        cloudpickle.register_pickle_by_value(module)


def _account(made: Sequence[tuple[Wanted, Facts]], wall_s: float, workers: int) -> str:
    """Breakdown of the time, in one sentence."""
    builds: Mapping[Trial, set[float]] = {each.trial: set() for each, _ in made}
    spent = dict.fromkeys(("warm", "build", "planning", "check", "bound"), 0.0)
    for each, facts in made:
        builds[each.trial].add(facts.get("build_s", 0.0))  # one for each time that it was built
        spent["warm"] += facts.get("warm_s", 0.0)
        spent["check"] += facts.get("check_s", 0.0)
        part = "planning" if "outcome" in facts else "bound"
        spent[part] += facts.get("planning_s", 0.0)
    spent["build"] = sum(map(sum, builds.values()))
    work_s = sum(spent.values())
    shares = ", ".join(f"{part} {seconds:.1f} s" for part, seconds in spent.items())
    overhead_s = max(0.0, workers * wall_s - work_s)
    text = (
        f"{len(made)} rows in {clock(wall_s)} ({wall_s:.1f} s) with {workers} workers: {shares}; "
        f"harness {overhead_s:.1f} s"
    )
    return f"{text}, {100 * overhead_s / work_s:.1f} % of all work" if work_s > 0.0 else text


if __name__ == "__main__":
    sys.exit(main())
