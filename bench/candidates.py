"""Value of more candidates at equal time: a cloud, its nearest targets, several limits.

    python bench/candidates.py auto beam --targets 120 300 600 --limits 5 10 20

The limit holds for everything, the timetable included, as on the command line. Every plan is
checked. *Near* is for how many destinations of each body the time was enough.
"""

from __future__ import annotations

import argparse
import time

from machine import heading

import adr_opt
from adr_opt.legs.nearest_pairs import nearest_pairs
from adr_opt.mission.mission import Mission
from adr_opt.run.table_budget import looked_at


def main() -> None:
    """Measure and print."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("methods", nargs="+")
    parser.add_argument("--family", default="cloud")
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--targets", type=int, nargs="+", default=[120, 300, 600])
    parser.add_argument("--limits", type=float, nargs="+", default=[5.0, 10.0, 20.0])
    arguments = parser.parse_args()
    most = adr_opt.generate(arguments.family, arguments.seed, targets=max(arguments.targets))
    order = nearest_pairs(most, (), 0).origins.tolist()
    print(f"{heading()}\n`{most.name}`, the nearest of {max(arguments.targets)}\n")
    print("| method | limit s | targets | near | visits | wall s | violations |")
    print("|---|---|---|---|---|---|---|")
    for method in arguments.methods:
        # What is compiled on first use is not measured.
        adr_opt.solve(adr_opt.generate("tiny", 0), method, iterations=3)
        for limit in arguments.limits:
            for count in arguments.targets:
                instance = most.part(order[: count + 1])
                mission = Mission(instance)
                began = time.perf_counter()
                result = adr_opt.solve(mission, method, time_limit=limit)
                wall = time.perf_counter() - began
                if result.plan is None:
                    print(f"| {method} | {limit:g} | {count} | 0 | | {wall:.1f} | |")
                    continue
                near = looked_at(mission.timetable)
                violations = len(adr_opt.check(instance, result.plan))
                print(
                    f"| {method} | {limit:g} | {count} | {near:.0f} "
                    f"| {result.objective:g} | {wall:.1f} | {violations} |",
                    flush=True,
                )


if __name__ == "__main__":
    main()
