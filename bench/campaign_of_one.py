"""What the machinery of campaigns costs one chaser: its mission planned as a campaign of one.

    python bench/campaign_of_one.py nominal --seeds 0 1 2 3 4
    python bench/campaign_of_one.py nominal --method auto

Both are planned one after the other, in turns of who begins, until the optimum is proven. Times are
processor time of all threads, with kernels that are compiled already.
"""

from __future__ import annotations

import argparse
import statistics
import time

from machine import heading

import adr_opt
from adr_opt.campaign import Campaign, Problem
from adr_opt.instance import Instance
from adr_opt.mission import Mission
from adr_opt.result import Result


def timed(problem: Problem, method: str, limit_s: float) -> tuple[Result, float]:
    """A plan with its proof, and what it took [s]."""
    began = time.process_time()
    result = adr_opt.solve(problem, method, time_limit=limit_s)
    return result, time.process_time() - began


def row(instance: Instance, method: str, limit_s: float, campaign_first: bool) -> float:
    """Print the row of a field; how many times as long the campaign takes."""
    kinds = (Campaign, Mission) if campaign_first else (Mission, Campaign)
    found = {kind: timed(kind(instance), method, limit_s) for kind in kinds}
    (one, one_s), (campaign, campaign_s) = found[Mission], found[Campaign]
    print(
        f"| {instance.name} | {one.objective:g} | {one.upper_bound:g} | {one_s:.2f} "
        f"| {campaign.objective:g} | {campaign.upper_bound:g} | {campaign_s:.2f} "
        f"| {campaign_s / one_s:.2f} |",
        flush=True,
    )
    return campaign_s / one_s


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("family", nargs="?", default="nominal")
    parser.add_argument("--seeds", type=int, nargs="+", default=[0, 1, 2, 3, 4])
    parser.add_argument("--method", default="exact")
    parser.add_argument("--limit", type=float, default=300.0)
    arguments = parser.parse_args()
    warm = adr_opt.generate("tiny", 0)
    for kind in (Mission, Campaign):
        timed(kind(warm), arguments.method, 30.0)
    print(f"{heading()}\n\n| field | one chaser | bound | s | campaign | bound | s | times |")
    print("|---|---|---|---|---|---|---|---|")
    ratios = [
        row(
            adr_opt.generate(arguments.family, seed),
            arguments.method,
            arguments.limit,
            bool(number % 2),
        )
        for number, seed in enumerate(arguments.seeds)
    ]
    print(f"\nin the median {statistics.median(ratios):.2f} times as long")


if __name__ == "__main__":
    main()
