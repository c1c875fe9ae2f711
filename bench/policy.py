"""Quality of the learned policy: visits, time, and gaps to the known results of every field.

    python bench/policy.py nominal reduced-time reduced-fuel --count 100
    python bench/policy.py nominal --targets 20 --count 20 ppo ppo:decode=beam auto@10
    python bench/policy.py --curve bench/curves/set.csv

Fields are those of the library, by seed from 0; none was trained on. Every plan is checked. Gaps
are to the best-known plan and to the best bound of `instances/best-known.csv`, or where a field
has no row (``--targets``) to the best plan of this run. ``--from SEED`` leaves out the first.
``--curve`` prints the evaluations of a training, thinned out; those of the trainings behind the
model card are in `bench/curves/`.
"""

from __future__ import annotations

import argparse
import csv
import statistics
import sys
import time
from pathlib import Path
from typing import Any

from machine import heading
from planners import options_of, parse
from scipy.stats import t

import adr_opt
from adr_opt.sources.generator import FAMILIES

BEST_KNOWN = Path(__file__).resolve().parents[1] / "instances" / "best-known.csv"
METHODS = ("ppo", "ppo:decode=sample@1", "ppo:decode=beam@1")
CURVE_ROWS = 12


def best_known() -> dict[str, dict[str, str]]:
    """The rows of the best-known file by instance."""
    with BEST_KNOWN.open(newline="", encoding="utf-8") as file:
        return {row["instance"]: row for row in csv.DictReader(file)}


def interval(values: list[float]) -> str:
    """Mean with its 95 % interval (Student)."""
    mean = statistics.fmean(values)
    if len(values) < 2:
        return f"{mean:.2f}"
    half = t.ppf(0.975, len(values) - 1) * statistics.stdev(values) / len(values) ** 0.5
    return f"{mean:.2f} ± {half:.2f}"


def measure(instance: adr_opt.Instance, methods: list[str]) -> list[dict[str, Any]]:
    """One plan by each method, on one timetable."""
    began = time.perf_counter()
    mission = adr_opt.Mission(instance)
    _ = mission.rules
    table_s = time.perf_counter() - began
    rows = []
    for spec in methods:
        name, texts, bound, limit = parse(spec)
        options = options_of(name, texts)
        began = time.perf_counter()
        result = adr_opt.solve(mission, name, time_limit=limit, seed=0, bound=bound, **options)
        wall = time.perf_counter() - began
        assert result.plan is not None
        rows.append(
            {
                "method": spec,
                "visits": result.objective,
                "wall_s": wall,
                "table_s": table_s,
                "violations": len(adr_opt.check(instance, result.plan)),
            }
        )
    return rows


def lines(family: str, fields: list[list[dict[str, Any]]], known: list[Any]) -> list[str]:
    """The table of one family."""
    out = [
        f"\n{family}, {len(fields)} fields\n",
        "| method | visits, mean ± 95 % | min–max | gap to best-known | gap to bound | "
        "time, median | violations |",
        "|---|---|---|---|---|---|---|",
    ]
    best, bounds = [], []
    for rows, row in zip(fields, known, strict=True):
        of_run = max(entry["visits"] for entry in rows)
        best.append(max(of_run, float(row["objective"])) if row else of_run)
        bounds.append(float(row["upper_bound"]) if row and row["upper_bound"] else None)
    for index, first in enumerate(fields[0]):
        mine = [rows[index] for rows in fields]
        visits = [row["visits"] for row in mine]
        to_best = [(b - v) / b for b, v in zip(best, visits, strict=True) if b]
        to_bound = [(b - v) / b for b, v in zip(bounds, visits, strict=True) if b]
        gap = f"{statistics.fmean(to_bound):.1%}" if len(to_bound) == len(visits) else "unknown"
        out.append(
            f"| `{first['method']}` | {interval(visits)} | {min(visits):g}–{max(visits):g} | "
            f"{statistics.fmean(to_best):.1%} | {gap} | "
            f"{1e3 * statistics.median(row['wall_s'] for row in mine):.0f} ms | "
            f"{sum(row['violations'] for row in mine)} |"
        )
    out.append(f"| best known | {interval(best)} | {min(best):g}–{max(best):g} | | | | |")
    if all(bounds):
        out.append(f"| best bound | {interval(bounds)} | {min(bounds):g}–{max(bounds):g} | | | | |")
    tables = [rows[0]["table_s"] for rows in fields]
    out.append(f"\nTimetable besides: {1e3 * statistics.median(tables):.0f} ms a field, median.")
    return out


def curve(path: Path) -> list[str]:
    """Evaluations of a training."""
    with path.open(newline="", encoding="utf-8") as file:
        rows = list(csv.DictReader(file))
    every = max(1, -(-len(rows) // CURVE_ROWS))
    kept = [row for index, row in enumerate(rows) if index % every == 0 or row is rows[-1]]
    names = [name for name in rows[0] if name not in ("steps", "seconds")]
    out = [f"| steps | minutes | {' | '.join(names)} |", f"|---|---|{'---|' * len(names)}"]
    for row in kept:
        means = " | ".join(f"{float(row[name]):.2f}" for name in names)
        out.append(f"| {int(row['steps']):,} | {float(row['seconds']) / 60:.0f} | {means} |")
    return out


def main() -> None:
    """Run from the command line."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("what", nargs="*", help="families, then methods")
    parser.add_argument("--count", type=int, default=20)
    parser.add_argument("--from", type=int, default=0, dest="first", metavar="SEED")
    parser.add_argument("--targets", type=int)
    parser.add_argument("--curve", type=Path, metavar="FILE")
    arguments = parser.parse_intermixed_args()
    if arguments.curve:
        print("\n".join(curve(arguments.curve)))
        return
    families = [name for name in arguments.what if name in FAMILIES]
    methods = [name for name in arguments.what if name not in families] or list(METHODS)
    rows_of = best_known()
    print(heading())
    for family in families or ["nominal"]:
        fields, known = [], []
        # Kernels are compiled, and the network is loaded, before anything is timed.
        measure(adr_opt.generate(family, 0, targets=arguments.targets), methods)
        for seed in range(arguments.first, arguments.first + arguments.count):
            instance = adr_opt.generate(family, seed, targets=arguments.targets)
            fields.append(measure(instance, methods))
            known.append(rows_of.get(instance.name))
            print(f"{instance.name} done", file=sys.stderr)
        print("\n".join(lines(family, fields, known)), flush=True)


if __name__ == "__main__":
    main()
