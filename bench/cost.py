"""The least cost at the best prize: what ``exact`` proves of it in a time, field by field.

    python bench/cost.py nominal --limit 60 --out cost.jsonl
    python bench/cost.py removal --targets 12 --chasers 3 --expense 55,0,2e-3 --limit 60
    python bench/cost.py nominal --duration --count 5

With ``--targets`` and ``--chasers`` fields are smaller or larger than those of the family, and with
``--expense`` the cost is no ΔV, but what chasers take: each one so much if it is used, for each
kilogram that it carries, and for each square of one. With ``--duration`` it is the end of the last
service.

Fields of a family by seed from ``--first``, ``--count`` of them. The time limit starts with a ready
timetable and covers the proof of the prizes, too; ``cpu_s`` is the processor time that was spent,
which tells how busy the machine was with something else. Every plan is checked. Rows go to
``--out`` as JSON lines, and a run started again skips what is there.
"""

from __future__ import annotations

import argparse
import json
import statistics
import sys
import time
from pathlib import Path
from typing import Any

from machine import heading

import adr_opt
from adr_opt.mission.problem import problem_of


def drawn(family: str, seed: int, asked: dict[str, Any]) -> adr_opt.Instance:
    """A field of a family, with a number of targets and chasers, and by expense."""
    sizes = {name: asked[name] for name in ("targets", "chasers") if asked.get(name) is not None}
    instance = adr_opt.generate(family, seed, **sizes)
    if asked.get("duration"):
        return instance.replace(objective={"cost": "duration"})
    if not asked.get("expense"):
        return instance
    names = ("fixed", "per_kg", "per_kg_squared")
    expense = dict(zip(names, asked["expense"], strict=False))
    return instance.replace(
        chasers=tuple(chaser.replace(expense=expense) for chaser in instance.chasers),
        objective={"cost": "expense"},
    )


def measure(family: str, seed: int, limit: float, asked: dict[str, Any]) -> dict[str, Any]:
    """One field: solved and checked."""
    instance = drawn(family, seed, asked)
    mission = problem_of(instance)
    for each in mission.missions:
        each.rules  # noqa: B018  builds the timetable
    began, spent = time.perf_counter(), time.process_time()
    result = adr_opt.solve(mission, "exact", time_limit=limit, seed=0, cost=True)
    wall, cpu = time.perf_counter() - began, time.process_time() - spent
    plan = result.plan
    assert plan is not None
    return {
        "family": family,
        "seed": seed,
        "limit_s": limit,
        **asked,
        "objective": result.objective,
        "status": result.status,
        "cost": plan.cost,
        "cost_bound": plan.cost_bound,
        "cost_gap": plan.cost_gap,
        "cost_status": plan.cost_status,
        "wall_s": wall,
        "cpu_s": cpu,
        "violations": len(adr_opt.check(mission.instance, plan)),
    }


def table(rows: list[dict[str, Any]]) -> str:
    """One field to a line, and what they come to."""
    what, unit = "ΔV", " m/s"
    if any(row.get("expense") for row in rows):
        what, unit = "expense", ""
    elif any(row.get("duration") for row in rows):
        what, unit = "end", " s"
    lines = [
        f"| seed | prize | {what} | no plan below | gap | time | processor time |",
        "|---|---|---|---|---|---|---|",
    ]
    for row in rows:
        known = row["cost_bound"] is not None
        bound = f"{row['cost_bound']:,.1f}{unit}" if known else ""
        gap = f"{100 * row['cost_gap']:.2f} %" if known else ""
        lines.append(
            f"| {row['seed']} | {row['objective']:g} | {row['cost']:,.1f}{unit} | {bound} | "
            f"{gap} | "
            f"{row['wall_s']:.1f} s | {row['cpu_s']:.1f} s |"
        )
    gaps = [1.0 if row["cost_gap"] is None else row["cost_gap"] for row in rows]
    proven = sum(row["cost_status"] == "optimal" for row in rows)
    close = sum(gap <= 0.02 for gap in gaps)
    lines.append(
        f"\n{len(rows)} fields: {proven} proven, {close} within 2 %, median gap "
        f"{100 * statistics.median(gaps):.2f} %, median time "
        f"{statistics.median(row['wall_s'] for row in rows):.1f} s, "
        f"{sum(row['violations'] for row in rows)} violations."
    )
    return "\n".join(lines)


def main() -> None:
    """Measure what is missing and print the table."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("family")
    parser.add_argument("--first", type=int, default=0)
    parser.add_argument("--count", type=int, default=20)
    parser.add_argument("--limit", type=float, default=60.0, help="seconds")
    parser.add_argument("--out", type=Path, help="JSON lines, appended to")
    parser.add_argument("--targets", type=int)
    parser.add_argument("--chasers", type=int)
    cost = parser.add_mutually_exclusive_group()
    cost.add_argument("--expense", help="FIXED[,PER_KG[,PER_KG2]]")
    cost.add_argument("--duration", action="store_true")
    arguments = parser.parse_args()
    prices = arguments.expense and [float(part) for part in arguments.expense.split(",")]
    asked = {
        "targets": arguments.targets,
        "chasers": arguments.chasers,
        "expense": prices,
        "duration": arguments.duration or None,
    }
    rows: list[dict[str, Any]] = []
    if arguments.out and arguments.out.exists():
        rows = [json.loads(line) for line in arguments.out.read_text().splitlines()]
    rows = [row for row in rows if all(row.get(name) == asked[name] for name in asked)]
    done = {(row["family"], row["seed"], row["limit_s"]) for row in rows}
    few = {**asked, "targets": 3}
    measure("tiny" if prices is None else arguments.family, 0, 20.0, few)  # compile beforehand
    seeds = range(arguments.first, arguments.first + arguments.count)
    for seed in seeds:
        if (arguments.family, seed, arguments.limit) in done:
            continue
        row = measure(arguments.family, seed, arguments.limit, asked)
        rows.append(row)
        if arguments.out:
            with arguments.out.open("a") as file:
                file.write(json.dumps(row) + "\n")
        print(f"{row}", file=sys.stderr)
    rows = [row for row in rows if row["family"] == arguments.family]
    rows = [row for row in rows if row["seed"] in seeds and row["limit_s"] == arguments.limit]
    print(heading())
    print(f"Family `{arguments.family}`, at most {arguments.limit:g} s each.\n")
    print(table(sorted(rows, key=lambda row: row["seed"])))


if __name__ == "__main__":
    main()
