"""Quality of planners: means over fields, every plan checked, gaps where there is a bound.

    python bench/planners.py nominal greedy greedy-guarded beam auto@10 auto@60 auto+lagrangian@60
    python bench/planners.py campaign greedy-guarded auto@10 auto@60 auto@120 --chasers 5
    python bench/planners.py removal auto@200 --count 10 --falls 2,1

A method is NAME[:OPTION=VALUE,…][+BOUND][@SECONDS]. The time limit starts with a ready timetable.
Rows go to ``--out`` as JSON lines when they are finished, and a run started again skips what is
there; the table is printed from these rows. ``--count`` fields of a family, by seed from 0;
``--targets``, ``--chasers``, ``--stations``, ``--days`` and ``--dynamics`` change them. With
``--falls`` a target is worth one prize after the other, in equal parts of the mission. Methods for
one chaser are left out where there are several.
"""

from __future__ import annotations

import argparse
import json
import resource
import statistics
import sys
import time
from pathlib import Path
from typing import Any

from falling_prizes import falling, numbers
from machine import heading

import adr_opt
from adr_opt import Instance, Plan
from adr_opt.common.options import parsed
from adr_opt.fly.flight import fly
from adr_opt.mission.problem import Problem, problem_of
from adr_opt.plan.plan import InstanceReference
from adr_opt.run import methods as planner


def parse(spec: str) -> tuple[str, dict[str, str], str | None, float]:
    """Name, options, bound and time limit [s] of a method as typed."""
    rest, _, limit = spec.partition("@")
    rest, _, bound = rest.partition("+")
    name, _, options = rest.partition(":")
    pairs = dict(pair.split("=", 1) for pair in options.split(",") if pair)
    return name, pairs, bound or None, float(limit or 60.0)


def options_of(name: str, texts: dict[str, str]) -> dict[str, Any]:
    """Values of options given as text."""
    kind = planner.options_of(planner.get(name))
    return {key: parsed(kind, key, text) for key, text in texts.items()}


def plans_campaigns(spec: str) -> bool:
    """Whether a method as typed is for several chasers too."""
    name, _, bound, _ = parse(spec)
    named = [planner.spec(name)]
    named += [] if bound is None else [planner.spec(bound, planner.BOUNDS)]
    return all(each.several for each in named)


def worst_miss_m(instance: Instance, plan: Plan) -> float:
    """Largest miss of an arrival, with each chaser flown by itself [m]."""
    chasers = {chaser.name: chaser for chaser in instance.chasers}
    worst = 0.0
    for route in plan.routes:
        alone = instance.replace(chasers=(chasers[route.chaser],))
        reference = InstanceReference(name=alone.name, sha256=alone.sha256)
        flight = fly(alone, plan.replace(instance=reference, routes=(route,)))
        worst = max(worst, flight.worst_miss_m)
    return worst


def measure(
    family: str, seed: int, spec: str, mission: Problem, plans: Path | None
) -> dict[str, Any]:
    """One plan: solved, checked, flown, and written into a folder if there is one."""
    name, texts, bound, limit = parse(spec)
    options = options_of(name, texts)
    began = time.perf_counter()
    result = adr_opt.solve(mission, name, time_limit=limit, seed=0, bound=bound, **options)
    wall = time.perf_counter() - began
    assert result.plan is not None
    if plans is not None:
        plans.mkdir(parents=True, exist_ok=True)
        result.plan.save(plans / f"{mission.instance.name}-{name}.json")
    violations = adr_opt.check(mission.instance, result.plan)
    miss = worst_miss_m(mission.instance, result.plan)
    return {
        "family": family,
        "seed": seed,
        "method": spec,
        "objective": result.objective,
        "upper_bound": result.plan.upper_bound,
        "gap": result.plan.gap,
        "status": result.status,
        "delta_v_m_s": result.plan.delta_v_m_s,
        "wall_s": wall,
        "violations": len(violations),
        "miss_m": miss,
    }


def table(rows: list[dict[str, Any]], methods: list[str]) -> str:
    """Means over fields, one method to a line."""
    lines = [
        "| method | fields | visits, mean | min–max | bound, mean | gap, mean | proven | "
        "time, median | max | violations | worst miss |",
        "|---|---|---|---|---|---|---|---|---|---|---|",
    ]
    for spec in methods:
        mine = [row for row in rows if row["method"] == spec]
        if not mine:
            continue
        values = [row["objective"] for row in mine]
        bounds = [row["upper_bound"] for row in mine if row["upper_bound"] is not None]
        gaps = [row["gap"] for row in mine if row["gap"] is not None]
        walls = [row["wall_s"] for row in mine]
        lines.append(
            f"| {spec} | {len(mine)} | {statistics.mean(values):.2f} | "
            f"{min(values):g}–{max(values):g} | "
            + (f"{statistics.mean(bounds):.2f}" if len(bounds) == len(mine) else "")
            + " | "
            + (f"{100 * statistics.mean(gaps):.2f} %" if len(gaps) == len(mine) else "")
            + f" | {sum(row['status'] == 'optimal' for row in mine)} | "
            f"{statistics.median(walls):.3g} s | {max(walls):.3g} s | "
            f"{sum(row['violations'] for row in mine)} | "
            f"{max(row['miss_m'] for row in mine):.1e} m |"
        )
    return "\n".join(lines)


def main() -> None:
    """Measure what is missing and print the table."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("family")
    parser.add_argument("methods", nargs="+")
    parser.add_argument("--count", type=int, default=20)
    parser.add_argument("--targets", type=int)
    parser.add_argument("--chasers", type=int)
    parser.add_argument("--stations", type=int)
    parser.add_argument("--days", type=float)
    parser.add_argument("--dynamics", choices=["two-body", "j2"])
    parser.add_argument("--falls", default="", help="prizes one after the other: 2,1")
    parser.add_argument("--out", type=Path, help="JSON lines, appended to")
    parser.add_argument("--plans", type=Path, metavar="FOLDER", help="where to keep the plans")
    arguments = parser.parse_args()
    family = arguments.family
    if arguments.targets is not None:
        family += f"-n{arguments.targets}"
    if arguments.chasers is not None:
        family += f"-c{arguments.chasers}"
    if arguments.stations is not None:
        family += f"-s{arguments.stations}"
    if arguments.days is not None:
        family += f"-{arguments.days:g}d"
    if arguments.dynamics is not None:
        family += f"-{arguments.dynamics}"
    if arguments.falls:
        family += f"-falling-{arguments.falls.replace(',', '-')}"
    prizes = numbers(arguments.falls)
    changes = {} if arguments.dynamics is None else {"dynamics": arguments.dynamics}
    sizes = {name: getattr(arguments, name) for name in ("targets", "chasers", "stations")}
    first = adr_opt.generate(arguments.family, 0, **sizes).replace(**changes)
    methods = arguments.methods
    if len(first.chasers) > 1:
        methods = [spec for spec in methods if plans_campaigns(spec)]
        left_out = [spec for spec in arguments.methods if spec not in methods]
        if left_out:
            print(f"for one chaser, left out: {', '.join(left_out)}", file=sys.stderr)
    rows: list[dict[str, Any]] = []
    if arguments.out and arguments.out.exists():
        rows = [json.loads(line) for line in arguments.out.read_text().splitlines()]
        rows = [row for row in rows if row["family"] == family]
    done = {(row["seed"], row["method"]) for row in rows}
    for spec in methods:  # compile before the clock starts
        name, texts, bound, _ = parse(spec)
        options = options_of(name, texts)
        warm = adr_opt.generate("tiny", 0, chasers=min(2, len(first.chasers)))
        warm = warm.replace(dynamics=first.dynamics)
        adr_opt.solve(warm, name, time_limit=20.0, iterations=3, bound=bound, **options)
    built: list[tuple[float, float]] = []
    for seed in range(arguments.count):
        missing = [spec for spec in methods if (seed, spec) not in done]
        if not missing:
            continue
        instance = adr_opt.generate(arguments.family, seed, **sizes)
        if arguments.days is not None:
            instance = instance.with_limits(duration_s=86400.0 * arguments.days)
            instance = instance.replace(name=f"{family}-{seed:03d}")
        problem = problem_of(falling(instance.replace(**changes), prizes))
        began, spent = time.perf_counter(), time.process_time()
        for mission in problem.missions:
            mission.rules  # noqa: B018  builds the timetable
        built.append((time.perf_counter() - began, time.process_time() - spent))
        for spec in missing:
            row = measure(family, seed, spec, problem, arguments.plans)
            rows.append(row)
            if arguments.out:
                with arguments.out.open("a") as file:
                    file.write(json.dumps(row) + "\n")
            print(
                f"{family}-{seed:03d} {spec}: {row['objective']:g} "
                f"of {row['upper_bound']} {row['wall_s']:.2f} s",
                file=sys.stderr,
            )
    rows = [row for row in rows if row["seed"] < arguments.count]
    print(heading())
    print(f"Family `{family}`, seeds 0–{arguments.count - 1}.\n")
    print(table(rows, methods))
    if built:
        wall, spent = (statistics.median(times) for times in zip(*built, strict=True))
        print(f"\nTimetable besides: {wall:.2g} s, {spent:.2g} s on all cores, medians.", end="")
    peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1e6
    print(f"\nPeak memory of this process: {peak:.1f} GB.")


if __name__ == "__main__":
    main()
