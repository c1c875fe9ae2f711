"""Set-up cost of a proof per timetable entry: time on one core, and memory.

    python bench/set_up.py

Each field in a process of its own, after a warm-up on a tiny one. The time is that of the part that
cannot be broken off, with one thread, median of several runs; the memory is the peak of the process
over what it took with a ready timetable, after a first search that ended at its first labels.
`solvers.progress.proof_size` holds the greatest figures, rounded up.
"""

from __future__ import annotations

import argparse
import resource
import statistics
import subprocess
import sys
import time

from machine import heading

import adr_opt
from adr_opt.common.progress import silent
from adr_opt.common.stop import MaxIterations
from solvers.progress.gap import GapTracker
from solvers.proof.proof import Proof, ProofOptions

FIELDS = (
    ("nominal", 50, 0),
    ("nominal", 50, 6),
    ("nominal", 100, 0),
    ("reduced-time", 50, 0),
    ("reduced-fuel", 50, 0),
    ("cloud", 50, 0),
)
"""Family, targets, zones."""


def resident() -> int:
    """Memory that the process takes now [bytes]."""
    with open("/proc/self/status", encoding="utf-8") as lines:
        return next(1024 * int(line.split()[1]) for line in lines if line.startswith("VmRSS"))


def proof_of(mission: adr_opt.Mission, jobs: int) -> Proof:
    """A proof that gives up at its first labels."""
    options = ProofOptions(jobs=jobs, most_labels=1)
    return Proof(mission, GapTracker(mission, silent), MaxIterations(10**6), options)


def begun(mission: adr_opt.Mission) -> None:
    """Bring a proof as far as its first search."""
    proof = proof_of(mission, 0)
    proof.begin()
    proof.advance(lambda: False)
    proof.close()


def measure(family: str, targets: int, zones: int, runs: int) -> None:
    """Print the row of a field."""
    begun(adr_opt.Mission(adr_opt.generate("tiny", 0)))
    mission = adr_opt.Mission(adr_opt.generate(family, 0, targets=targets, zones=zones))
    entries = mission.timetable.entries
    before = resident()
    begun(mission)
    peak = 1024 * resource.getrusage(resource.RUSAGE_SELF).ru_maxrss - before
    times = []
    for _ in range(runs):
        start = time.process_time()
        proof_of(mission, 1).close()
        times.append(time.process_time() - start)
    taken = statistics.median(times)
    print(
        f"| {family}, {targets} targets, {zones} zones | {entries} | {taken:.2f} s | "
        f"{1e6 * taken / entries:.2f} µs | {peak / 1e6:.0f} MB | {peak / entries:.0f} B |"
    )


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--runs", type=int, default=3)
    parser.add_argument("--field", nargs=3, help=argparse.SUPPRESS)
    arguments = parser.parse_args()
    if arguments.field:
        family, targets, zones = arguments.field
        measure(family, int(targets), int(zones), arguments.runs)
        return
    print(heading())
    print("| field | entries | set-up, 1 core | per entry | peak memory | per entry |")
    print("|---|---|---|---|---|---|", flush=True)
    for field in FIELDS:
        command = [sys.executable, __file__, "--runs", str(arguments.runs), "--field"]
        subprocess.run([*command, *(str(part) for part in field)], check=True)


if __name__ == "__main__":
    main()
