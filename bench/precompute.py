"""Speed of timetable, connections and first bound, on one core and on all.

    python bench/precompute.py

Medians of several runs in one process after a warm-up. The timetable also by entry and against a
reference library; the greedy plan from a ready timetable; what a first bound takes from there, and
its parts; and two whole processes: `import adr_opt` and `solve --method greedy`.
"""

from __future__ import annotations

import argparse
import os
import statistics
import subprocess
import sys
import time
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor

import numpy as np
from machine import heading
from reference_leg import reference_leg

import adr_opt
from adr_opt.common.processors import usable_cores
from adr_opt.common.progress import silent
from adr_opt.common.stop import MaxIterations
from adr_opt.kernels.core.compile import kernel
from adr_opt.kernels.legs import connections
from adr_opt.run.methods import get
from solvers.networks import network
from solvers.progress.gap import GapTracker
from solvers.proof.proof import COARSER, Proof, ProofOptions
from solvers.walks.walks import WalkBound


def median_s(function: Callable[[], object], runs: int) -> tuple[float, float, float]:
    """Least, median and greatest wall time after one warm-up [s]."""
    function()
    times = []
    for _ in range(runs):
        began = time.perf_counter()
        function()
        times.append(time.perf_counter() - began)
    return min(times), statistics.median(times), max(times)


def in_reference(table: adr_opt.Timetable, leg: tuple[int, int, float]) -> tuple[float, float]:
    """ΔV and arrival of one leg through the reference library [m/s], [s]."""
    i, j, ready = leg
    return reference_leg(table.instance, table.names[i], table.names[j], ready)


@kernel
def connections_from(i, leaving, orbits, extra_delta_v, rule, duration):  # type: ignore[no-untyped-def]
    """Number of connections that leave a body, all of which are computed."""
    count = 0
    for j in range(orbits.shape[0]):
        if j != i:
            found = connections.of_pair(
                leaving[i], orbits[j], extra_delta_v[i, j], rule, duration, 0.0
            )
            count += found.departure.size
    return count


def all_connections(mission: adr_opt.Mission, jobs: int) -> int:
    """Work out all connections of all pairs; how many there are."""
    given = mission.transfer_inputs
    with ThreadPoolExecutor(jobs) as pool:
        return sum(
            pool.map(
                lambda i: connections_from(i, *given, mission.rules.duration), range(len(given[0]))
            )
        )


def first_bound(mission: adr_opt.Mission, jobs: int) -> float:
    """The first bound of a proof, with the usual options."""
    certificate = GapTracker(mission, silent)
    proof = Proof(mission, certificate, MaxIterations(1), ProofOptions(jobs=jobs))
    proof.begin()
    proof.close()
    return certificate.bound


def print_bound(mission: adr_opt.Mission, runs: int) -> None:
    """Print what a first bound takes from a ready timetable, and its parts."""
    cores = usable_cores()
    built = network.build(mission, jobs=cores)
    slot = COARSER * ProofOptions().delta_v_slot_m_s
    walks = WalkBound(mission, slot, network=built)
    bound = first_bound(mission, cores)
    rows: list[tuple[str, Callable[[], object]]] = []
    for jobs in dict.fromkeys((1, cores)):
        on = "1 core" if jobs == 1 else f"{jobs} cores"
        count = all_connections(mission, jobs)
        rows += [
            (f"all {count} connections, {on}", lambda jobs=jobs: all_connections(mission, jobs)),
            (
                f"network of {built.delta_v.size} legs, with them, {on}",
                lambda jobs=jobs: network.build(mission, jobs=jobs),
            ),
            (
                f"first bound of {bound:g} from a ready timetable, with all that, {on}",
                lambda jobs=jobs: first_bound(mission, jobs),
            ),
        ]
    rows.insert(
        2, (f"one sweep at {slot:g} m/s, 1 core", lambda: walks.evaluate(walks.first_point()))
    )
    for name, function in rows:
        cells = " | ".join(f"{t:.3f} s" for t in median_s(function, runs))
        print(f"| {name} | {cells} |")
    walks.close()


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--runs", type=int, default=9)
    parser.add_argument("--reference-legs", type=int, default=12)
    arguments = parser.parse_args()
    instance = adr_opt.generate("nominal", 0)
    timetable = adr_opt.Timetable(instance)
    entries = timetable.entries
    cores = usable_cores()
    print(heading())
    print("| what | min | median | max |\n|---|---|---|---|")
    one = median_s(lambda: adr_opt.Timetable(instance, 1), arguments.runs)
    many = median_s(lambda: adr_opt.Timetable(instance, cores), arguments.runs)
    for name, times in ((f"{entries} entries, 1 core", one), (f"the same, {cores} cores", many)):
        cells = " | ".join(f"{t:.3f} s ({t / entries * 1e6:.3f} µs/entry)" for t in times)
        print(f"| timetable, {name} | {cells} |")
    print(f"| speed-up on {cores} cores | | {one[1] / many[1]:.2f} × | |")

    rng = np.random.default_rng(0)
    legs = []
    while len(legs) < arguments.reference_legs:
        i, j = (int(x) for x in rng.choice(len(timetable.names), 2, replace=False))
        ready = float(rng.uniform(0.0, 6.0 * 86400.0))
        if np.isfinite(timetable.lookup(i, j, ready)[0]):
            legs.append((i, j, ready))
    in_reference(timetable, legs[0])
    times, worst = [], 0.0
    for i, j, ready in legs:
        began = time.perf_counter()
        delta_v, arrival = in_reference(timetable, (i, j, ready))
        times.append(time.perf_counter() - began)
        ours = timetable.lookup(i, j, ready)
        worst = max(worst, abs(delta_v / ours[0] - 1.0), abs(arrival / ours[1] - 1.0))
    per_leg = statistics.median(times)
    print(
        f"| one leg through boinor, every (k, m) tried | {min(times) * 1e3:.0f} ms | "
        f"{per_leg * 1e3:.0f} ms | {max(times) * 1e3:.0f} ms |"
    )
    print(f"| boinor leg / timetable entry, 1 core | | {per_leg / (one[1] / entries):.0f} × | |")
    print(f"| largest relative difference to boinor, {len(legs)} legs | | | {worst:.1e} |")

    mission = adr_opt.Mission(instance, timetable)
    mission.rules  # noqa: B018  the arrays of the rules are part of a ready timetable
    greedy = get("greedy")
    search = median_s(
        lambda: greedy(mission, seed=0, stop=MaxIterations(1), progress=silent), arguments.runs
    )
    plans = [
        greedy(mission, seed=0, stop=MaxIterations(1), progress=silent).runtime_s
        for _ in range(arguments.runs)
    ]
    print(
        f"| greedy sequence from a ready timetable | {min(plans) * 1e3:.3f} ms | "
        f"{statistics.median(plans) * 1e3:.3f} ms | {max(plans) * 1e3:.3f} ms |"
    )
    print(
        "| the same with legs, burns and reasons | "
        + " | ".join(f"{t * 1e3:.1f} ms" for t in search)
        + " |"
    )
    print_bound(mission, arguments.runs)
    path = os.path.join(os.path.dirname(__file__), "../instances/nominal/nominal-000.json")
    for name, command in (
        ("process: import adr_opt", ["-c", "import adr_opt"]),
        ("process: solve --method greedy", ["-m", "adr_opt", "solve", path, "--method", "greedy"]),
    ):
        times_of = median_s(
            lambda command=command: subprocess.run(  # type: ignore[misc]
                [sys.executable, *command], check=True, capture_output=True
            ),
            5,
        )
        print(f"| {name} | " + " | ".join(f"{t:.2f} s" for t in times_of) + " |")


if __name__ == "__main__":
    main()
