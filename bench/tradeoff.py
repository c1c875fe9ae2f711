"""Cost of ten budgets of a field against one, with proofs.

    python bench/tradeoff.py nominal --seeds 0 1 2 --out tradeoff.jsonl

For each field: one budget planned and proven by ``auto``, then ``tradeoff`` over ten, all in one
process on one core, after a warm-up. Times are processor time, so that a busy machine does not
count; ``--time-limit`` is wall time of a run.
"""

from __future__ import annotations

import argparse
import json
import time
from pathlib import Path

from machine import heading

import adr_opt
from adr_opt.analysis import Axis, tradeoff


def measure(
    family: str, seed: int, budgets: tuple[float, ...], limit_s: float
) -> dict[str, object]:
    """One field: processor time of one budget and of all."""
    instance = adr_opt.generate(family, seed)
    began = time.process_time()
    one = adr_opt.solve(instance, "auto", time_limit=limit_s)
    one_s = time.process_time() - began
    made = tradeoff(instance, [Axis("delta-v", budgets)], time_limit=limit_s)
    return {
        "field": instance.name,
        "one_cpu_s": round(one_s, 2),
        "one": [one.objective, one.upper_bound],
        "all_cpu_s": round(made.cpu_s, 2),
        "ratio": round(made.cpu_s / one_s, 2),
        "proven": made.proven,
        "points": [[point.delta_v_m_s, point.prize, point.upper_bound] for point in made.points],
    }


def main() -> None:
    """Measure and print."""
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("family")
    parser.add_argument("--seeds", type=int, nargs="+", default=[0])
    parser.add_argument("--budgets", type=float, nargs="+")
    parser.add_argument("--time-limit", type=float, default=60.0)
    parser.add_argument("--out", type=Path)
    arguments = parser.parse_args()
    budgets = tuple(arguments.budgets or [1000.0 + 500.0 * number for number in range(10)])
    print(heading())
    small = adr_opt.generate("tiny", 0)
    for method in ("beam", "auto"):
        adr_opt.solve(small, method, time_limit=5.0)
    for seed in arguments.seeds:
        row = measure(arguments.family, seed, budgets, arguments.time_limit)
        print(json.dumps(row), flush=True)
        if arguments.out is not None:
            with arguments.out.open("a", encoding="utf-8") as file:
                file.write(json.dumps(row) + "\n")


if __name__ == "__main__":
    main()
