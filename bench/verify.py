"""What it takes to verify a proof, against what the proof took.

    python bench/verify.py nominal
    python bench/verify.py tiny reduced-time --count 5 --limit 60

For each field of the families a proof by `exact`, its certificate, and `verify` of both with the
1,000 connections that are sampled by default. Processor time of all threads, with kernels that are
compiled already, and wall time beside it; both begin with reading the file.
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
from adr_opt.certificate import Certificate, certificate_of
from adr_opt.errors import InputError
from adr_opt.result import Result
from adr_opt.verifying import verify

INSTANCES = Path(__file__).parents[1] / "instances"

Found = TypeVar("Found")


def timed(task: Callable[[], Found]) -> tuple[Found, float, float]:
    """What a task gives, its processor time and its wall time [s]."""
    cpu, wall = time.process_time(), time.perf_counter()
    found = task()
    return found, time.process_time() - cpu, time.perf_counter() - wall


def proof_of(path: Path, limit_s: float) -> tuple[Result, Certificate]:
    """The proof of a field, and its certificate."""
    instance = adr_opt.load(path)
    result = adr_opt.solve(instance, "exact", time_limit=limit_s)
    return result, certificate_of(instance, result)


def row(path: Path, limit_s: float) -> tuple[str, float]:
    """The row of a field, and how many times the processor time of the proof verifying it takes."""
    (result, certificate), cpu, wall = timed(lambda: proof_of(path, limit_s))
    verdict, own_cpu, own_wall = timed(lambda: verify(adr_opt.load(path), result.plan, certificate))
    answer = "yes" if verdict.verified else "no: " + "; ".join(verdict.reasons)
    size = len(certificate.to_json())
    ratio = own_cpu / cpu
    return (
        f"| {path.stem} | {result.objective:g} | {verdict.upper_bound:g} | {cpu:.1f} | {wall:.1f} "
        f"| {own_cpu:.1f} | {own_wall:.1f} | {ratio:.2f} | {verdict.labels:,} | {size:,} "
        f"| {answer} |"
    ), ratio


def main() -> None:
    """Print a table."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").split("\n")[0])
    parser.add_argument("families", nargs="+")
    parser.add_argument("--count", type=int, default=20, help="fields of each family")
    parser.add_argument("--limit", type=float, default=300.0, help="of a proof [s]")
    asked = parser.parse_args()
    paths = [
        path
        for family in asked.families
        for path in sorted((INSTANCES / family).glob("*.json"))[: asked.count]
    ]
    proven, certificate = proof_of(INSTANCES / "tiny" / "tiny-000.json", 60.0)  # compiles
    verify(adr_opt.load(INSTANCES / "tiny" / "tiny-000.json"), proven.plan, certificate)
    print(heading())
    print(
        "| field | objective | bound | proof, processor s | wall s | `verify`, processor s "
        "| wall s | ratio | labels | bytes | verified |"
    )
    print("|---|---|---|---|---|---|---|---|---|---|---|")
    ratios = []
    for path in paths:
        try:
            line, ratio = row(path, asked.limit)
        except InputError as error:
            line, ratio = f"| {path.stem} | " + " | " * 8 + f" | {error} |", 0.0
        print(line, flush=True)
        ratios += [ratio] if ratio else []
    if ratios:
        print(
            f"\nRatio of processor times: median {statistics.median(ratios):.2f}, "
            f"largest {max(ratios):.2f}, of {len(ratios)}."
        )


if __name__ == "__main__":
    main()
