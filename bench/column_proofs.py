"""Proofs of campaigns by column generation alone, in processor time.

    python bench/column_proofs.py campaign 0-19 --limit 120
    python bench/column_proofs.py removal 2 --limit 240
    python bench/column_proofs.py removal 0-19 --limit 300 --falls 2,1

Each proof begins with the plan of instances/best-known.csv, on one core and with a ready timetable;
limits and times are seconds of processor time, so that other work on the machine hardly counts. A
proof may find a better plan. With ``--falls`` every target is worth one number after the other, in
equal parts of the mission.
"""

from __future__ import annotations

import argparse
import csv
import time
from collections.abc import Sequence
from pathlib import Path

from falling_prizes import falling, numbers
from machine import heading

import adr_opt
from adr_opt.common.progress import silent
from adr_opt.mission.problem import problem_of
from solvers.columns.proof import ColumnProof
from solvers.progress.gap import GapTracker
from solvers.proof.proof import ProofOptions
from solvers.routes.route_pool import RoutePool

KNOWN = Path(__file__).resolve().parents[1] / "instances" / "best-known.csv"


class ProcessorTime:
    """Stopping criterion: seconds of processor time."""

    def __init__(self, limit_s: float) -> None:
        self._end = time.process_time() + limit_s

    def remaining_s(self) -> float:
        """What is left [s]."""
        return self._end - time.process_time()

    def __call__(self, incumbent: float, bound: float) -> bool:
        """Whether it is over."""
        return self.remaining_s() <= 0.0


def known_routes(name: str) -> list[tuple[int, ...]]:
    """Routes of the best plan in the library."""
    with KNOWN.open() as file:
        (row,) = (row for row in csv.reader(file) if row[0] == name)
    return [tuple(map(int, route.split("-"))) if route else () for route in row[-1].split("/")]


def measure(family: str, seed: int, limit_s: float, prizes: Sequence[float] = ()) -> str:
    """A line of the table."""
    problem = problem_of(falling(adr_opt.generate(family, seed), prizes))
    for mission in problem.missions:
        mission.rules  # noqa: B018  builds the timetable
    tracker, pool = GapTracker(problem, silent), RoutePool(problem)
    routes = known_routes(problem.instance.name)
    tracker.offer(*routes)
    for kind, route in zip(problem.kind_of, routes, strict=True):
        pool.add(kind, route)
    known, stop, began = tracker.incumbent, ProcessorTime(limit_s), time.process_time()
    proof = ColumnProof(problem, tracker, pool, 0, stop, ProofOptions(jobs=1))
    proof.begin()
    while not (proof.done or tracker.proven or stop.remaining_s() <= 0.0):
        proof.advance(lambda: stop.remaining_s() <= 0.0)
    spent, counters = time.process_time() - began, proof.counters
    proof.close()
    return (
        f"| {problem.instance.name} | {known:g} | {tracker.incumbent:g} | {tracker.bound:.6g} | "
        f"{'yes' if tracker.proven else 'no'} | {counters['cuts']:g} | {counters['columns']:g} | "
        f"{counters['labels']:,} | {spent:.1f} s |"
    )


def main() -> None:
    """Measure and print, field by field."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("family")
    parser.add_argument("seeds", help="numbers and ranges: 3,8,11-13")
    parser.add_argument("--limit", type=float, default=120.0, help="seconds [120]")
    parser.add_argument("--falls", default="", help="prizes one after the other: 2,1")
    arguments = parser.parse_args()
    prizes = numbers(arguments.falls)
    print(heading())
    print("| field | known | plan | bound | proven | cuts | columns | labels | processor time |")
    print("|---|---|---|---|---|---|---|---|---|")
    for part in arguments.seeds.split(","):
        first, _, last = part.partition("-")
        for seed in range(int(first), int(last or first) + 1):
            print(measure(arguments.family, seed, arguments.limit, prizes), flush=True)


if __name__ == "__main__":
    main()
