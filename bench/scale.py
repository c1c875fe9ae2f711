"""Growth of plans, time and memory with the number of targets.

    python bench/scale.py                                     # nominal, 50 to 10,000 targets
    python bench/scale.py --targets 50 500 --limit 20 --seeds 3
    python bench/scale.py --dense --targets 200 500           # against the table of all pairs
    python bench/scale.py --family large --targets 200 --limit 600                   # 30 days
    python bench/scale.py --family large --targets 1500 --chasers 2

Every run is a process of its own: drawn, planned by `auto` within the limit, and checked. *Near* is
for how many destinations of each body the timetable has room and time, or at how many planners look
that ask for rows on demand; *bound* is what no plan is
worth more than, of all pairs, and *gap* how far below it the plan is; *all s* is everything from
the instance file on. Exponents are those of the line through all points from 1,000 targets on (of
logarithms). With `--dense` the same limit is spent on the table of all pairs, as far as it goes.
"""

from __future__ import annotations

import argparse
import json
import math
import resource
import statistics
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import numpy as np
from machine import heading

import adr_opt
from adr_opt.mission.problem import Problem
from adr_opt.run.table_budget import looked_at

SIZES = (50, 100, 200, 500, 1000, 2000, 5000, 10_000)
FROM = 1000
"""Exponents are read from here on: smaller fields have the table of all pairs."""


def measure(file: Path, limit_s: float, dense: bool) -> dict[str, float]:
    """Plan one instance, and say what it took."""
    # What is compiled on first use is not measured.
    adr_opt.solve(adr_opt.generate("tiny", 0), "auto", iterations=2)
    began = time.perf_counter()
    instance = adr_opt.load(file)
    problem = Problem(instance)
    if dense:
        problem.build(None)
    spent = time.perf_counter() - began if dense else 0.0
    result = adr_opt.solve(problem, "auto", time_limit=max(1.0, limit_s - spent))
    wall = time.perf_counter() - began
    violations = 1 if result.plan is None else len(adr_opt.check(instance, result.plan))
    return {
        "near": looked_at(problem.missions[0].timetable),
        "visits": result.objective,
        "bound": result.upper_bound,
        "wall_s": wall,
        "memory_gib": resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 2**20,
        "violations": violations,
    }


def generated(family: str, seed: int, targets: int, chasers: int) -> adr_opt.Instance:
    """A field of a family, with other numbers of targets and of chasers."""
    several = {"chasers": chasers} if chasers > 1 else {}
    return adr_opt.generate(family, seed, targets=targets, **several)


def main() -> None:
    """Measure and print."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--family", default="nominal")
    parser.add_argument("--targets", type=int, nargs="+", default=list(SIZES))
    parser.add_argument("--chasers", type=int, default=1)
    parser.add_argument("--limit", type=float, default=60.0)
    parser.add_argument("--seeds", type=int, default=1)
    parser.add_argument("--dense", action="store_true")
    parser.add_argument("--one", type=Path, help=argparse.SUPPRESS)
    arguments = parser.parse_args()
    if arguments.one:
        print(json.dumps(measure(arguments.one, arguments.limit, arguments.dense)))
        return
    print(f"{heading()}\n\n| targets | near | visits | bound | gap | all s | GiB | violations |")
    print("|---|---|---|---|---|---|---|---|")
    rows = []
    with tempfile.TemporaryDirectory() as folder:
        for count in arguments.targets:
            found = []
            for seed in range(arguments.seeds):
                file = Path(folder) / "instance.json"
                generated(arguments.family, seed, count, arguments.chasers).save(file)
                command = [
                    sys.executable,
                    __file__,
                    "--one",
                    str(file),
                    "--limit",
                    str(arguments.limit),
                ]
                if arguments.dense:
                    command.append("--dense")
                answer = subprocess.run(command, check=True, capture_output=True, text=True)
                found.append(json.loads(answer.stdout.splitlines()[-1]))
            mean = {key: statistics.fmean(each[key] for each in found) for key in found[0]}
            bound, gap = "–", "–"
            if math.isfinite(mean["bound"]):
                bound = f"{mean['bound']:.1f}"
                gap = f"{100.0 * (1.0 - mean['visits'] / mean['bound']):.1f} %"
            print(
                f"| {count} | {mean['near']:.0f} | {mean['visits']:.1f} | {bound} | {gap} "
                f"| {mean['wall_s']:.1f} | {mean['memory_gib']:.2f} "
                f"| {sum(each['violations'] for each in found):.0f} |",
                flush=True,
            )
            rows.append((count, mean))
    large = [(count, mean) for count, mean in rows if count >= FROM]
    if len(large) > 1:
        counts = np.log([count for count, _ in large])
        for key in ("wall_s", "memory_gib", "visits"):
            slope = np.polyfit(counts, np.log([mean[key] for _, mean in large]), 1)[0]
            print(f"\n{key} grows as targets^{slope:.2f} from {FROM} targets on")


if __name__ == "__main__":
    main()
