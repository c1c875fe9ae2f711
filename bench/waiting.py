"""The mission in which chasers may wait: connections, network, sweeps and bounds, measured.

    python bench/waiting.py nominal --seeds 20

For each field: all connections of all pairs, on one core; the network of walks, on all cores; one
sweep on one core, median of several; and the bound `waiting` with the time, after the timetable,
when it got there. Times are wall times in one process after a warm-up.
"""

from __future__ import annotations

import argparse
import os
import resource
import statistics
import time
from collections.abc import Callable

import numpy as np
from machine import heading

import adr_opt
from adr_opt.mission import Mission
from solvers.relaxation import WaitingBound


def timed(function: Callable[[], object], runs: int = 1) -> tuple[float, object]:
    """Median wall time of some calls [s], and what the last one gave."""
    times = []
    for _ in range(runs):
        began = time.perf_counter()
        found = function()
        times.append(time.perf_counter() - began)
    return statistics.median(times), found


def every_connection(mission: Mission) -> int:
    """Number of connections of all pairs, each worked out."""
    bodies = range(len(mission.names))
    table = mission.timetable
    return sum(table.connections(i, j).departure.size for i in bodies for j in bodies)


def measure(mission: Mission, slot: float, runs: int, time_limit: float) -> list[float]:
    """The numbers of one row of the table."""
    _ = mission.rules
    cores = os.cpu_count() or 1
    connecting, count = timed(lambda: every_connection(mission), runs)
    building, bound = timed(lambda: WaitingBound(mission, slot, cores))
    single = WaitingBound(mission, slot, 1)
    nothing = np.zeros(len(mission.names))
    sweeping, _ = timed(lambda: single.evaluate(nothing), runs)
    bound.close()
    lowest, reached, began = np.inf, 0.0, time.perf_counter()

    def hear(incumbent: float, upper_bound: float) -> None:
        nonlocal lowest, reached
        if upper_bound < lowest:
            lowest, reached = upper_bound, time.perf_counter() - began

    adr_opt.bound(mission, "waiting", time_limit=time_limit, seed=0, progress=hear)
    return [
        float(count), connecting, bound.network.cost.size, building, sweeping,
        lowest, reached,
    ]  # fmt: skip


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("family")
    parser.add_argument("--seeds", type=int, default=20)
    parser.add_argument("--zones", type=int, default=0)
    parser.add_argument("--slot", type=float, default=50.0, help="m/s")
    parser.add_argument("--runs", type=int, default=3)
    parser.add_argument("--time-limit", type=float, default=60.0, help="of the bound, s")
    arguments = parser.parse_args()
    measure(Mission(adr_opt.generate("tiny", 0)), arguments.slot, 1, 1.0)
    print(heading())
    print(
        "| field | connections | s, one core | ns each | legs in slots | network, s "
        "| sweep, one core, s | bound | after, s |\n|---|---|---|---|---|---|---|---|---|"
    )
    rows = []
    for seed in range(arguments.seeds):
        field = adr_opt.generate(arguments.family, seed, zones=arguments.zones)
        row = measure(Mission(field), arguments.slot, arguments.runs, arguments.time_limit)
        rows.append(row)
        print(line(str(seed), row), flush=True)
    print(line("median", [statistics.median(column) for column in zip(*rows, strict=True)]))
    peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 2**20
    print(
        f"\nMean bound {statistics.mean(row[5] for row in rows):.3f}; peak memory {peak:.2f} GiB."
    )


def line(name: str, row: list[float]) -> str:
    """One row of the table."""
    count, connecting, legs, building, sweeping, bound, reached = row
    return (
        f"| {name} | {count:.0f} | {connecting:.2f} | {1e9 * connecting / count:.0f} | {legs:.0f} "
        f"| {building:.2f} | {sweeping:.3f} | {bound:g} | {reached:.1f} |"
    )


if __name__ == "__main__":
    main()
