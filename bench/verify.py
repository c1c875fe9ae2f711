"""Cost of verifying a proof, against that of the proof.

    python bench/verify.py nominal --count 20
    python bench/verify.py tiny nominal reduced-time reduced-fuel --limit 60
    python bench/verify.py removal --method auto --limit 200

For each field of the families in the library a proof, its certificate, and `verify` of both with
the 1,000 connections that are sampled by default. Processor time of all threads, with kernels that
are compiled already, and wall time beside it; both begin with the instance.
"""

from __future__ import annotations

import argparse
import statistics
import time
from collections.abc import Callable
from pathlib import Path
from typing import TypeVar

from machine import heading

import adr_opt
from adr_opt.common.errors import InputError
from adr_opt.judge.verify import verify
from adr_opt.mission.certify import certificate_of
from adr_opt.mission.result import Result
from adr_opt.plan.certificate import Certificate
from adr_opt.sources.library import Entry, load_library

LIBRARY = Path(__file__).parents[1] / "instances" / "library.json"

Found = TypeVar("Found")


def timed(task: Callable[[], Found]) -> tuple[Found, float, float]:
    """Result of a task, with its processor time and its wall time [s]."""
    cpu, wall = time.process_time(), time.perf_counter()
    found = task()
    return found, time.process_time() - cpu, time.perf_counter() - wall


def proof_of(entry: Entry, method: str, limit_s: float) -> tuple[Result, Certificate]:
    """The proof of a field, and its certificate."""
    instance = entry.generate()
    result = adr_opt.solve(instance, method, time_limit=limit_s)
    return result, certificate_of(instance, result)


def row(entry: Entry, method: str, limit_s: float) -> tuple[str, float]:
    """The row of a field, and how many times the processor time of the proof verifying it takes."""
    (result, certificate), cpu, wall = timed(lambda: proof_of(entry, method, limit_s))
    verdict, own_cpu, own_wall = timed(lambda: verify(entry.generate(), result.plan, certificate))
    answer = "yes" if verdict.verified else "no: " + "; ".join(verdict.reasons)
    size = len(certificate.to_json())
    ratio = own_cpu / cpu
    return (
        f"| {entry.name} | {result.objective:g} | {result.upper_bound:g} | {verdict.upper_bound:g} "
        f"| {cpu:.1f} | {wall:.1f} | {own_cpu:.1f} | {own_wall:.1f} | {ratio:.2f} "
        f"| {verdict.labels:,} | {size:,} | {answer} |"
    ), ratio


def main() -> None:
    """Print a table."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").split("\n")[0])
    parser.add_argument("families", nargs="+")
    parser.add_argument("--first", type=int, default=0, help="field of each family to begin with")
    parser.add_argument("--count", type=int, help="fields of each family; all by default")
    parser.add_argument("--method", default="exact", help="that proves")
    parser.add_argument("--limit", type=float, default=300.0, help="of a proof [s]")
    asked = parser.parse_args()
    library = load_library(LIBRARY)
    last = None if asked.count is None else asked.first + asked.count
    entries = [
        entry
        for family in asked.families
        for entry in library.of_family(family)[asked.first : last]
    ]
    first = library.of_family("tiny")[0]
    proven, certificate = proof_of(first, asked.method, 60.0)  # compiles
    verify(first.generate(), proven.plan, certificate)
    print(heading())
    print(
        "| field | objective | bound | bound verified | proof, processor s | wall s "
        "| `verify`, processor s | wall s | ratio | labels | bytes | verified |"
    )
    print("|---|---|---|---|---|---|---|---|---|---|---|---|")
    ratios = []
    for entry in entries:
        try:
            line, ratio = row(entry, asked.method, asked.limit)
        except InputError as error:
            line, ratio = f"| {entry.name} | " + " | " * 9 + f" | {error} |", 0.0
        print(line, flush=True)
        ratios += [ratio] if ratio else []
    if ratios:
        print(
            f"\nRatio of processor times: median {statistics.median(ratios):.2f}, "
            f"largest {max(ratios):.2f}, of {len(ratios)}."
        )


if __name__ == "__main__":
    main()
