"""From a new zone to a new plan: how long it takes, and what it collects.

    python bench/replan.py --seeds 0 1 2 3 --days 2 3 4

For each field of the family nominal and each day on which a zone falls in: the rest of its
best-known plan is planned anew by ``adr_opt.analysis.replan``, timetable included, after a warm-up;
wall time and processor time are the least of three runs. Beside it stand the rest by ``auto``,
which tells what is still possible, and the whole mission by ``auto`` with the zone known from the
start.
"""

from __future__ import annotations

import argparse
import json
import time
from pathlib import Path

from machine import heading

import adr_opt
from adr_opt.analysis import replan
from adr_opt.common.constants import DAY_S
from adr_opt.problem.settings import KeepOutZone

BEST_KNOWN = Path(__file__).parents[1] / "instances" / "best-known"


def measure(seed: int, day: float, limit_s: float) -> dict[str, object]:
    """One field and one zone: ten kilometres for a day, an hour after it is known."""
    instance = adr_opt.generate("nominal", seed)
    plan = adr_opt.load_plan(BEST_KNOWN / f"nominal-{seed:03d}.json")
    at_s = day * DAY_S
    zone = KeepOutZone(
        min_altitude_m=740e3, max_altitude_m=750e3, start_s=at_s + 3600.0, end_s=at_s + DAY_S
    )
    wall, used = [], []
    for _ in range(3):
        began, cpu_began = time.perf_counter(), time.process_time()
        made = replan(instance, plan, at_s, zones=[zone])
        wall.append(time.perf_counter() - began)
        used.append(time.process_time() - cpu_began)
    targets = {target.name for target in instance.targets}
    flown = sum(leg.destination in targets for state in made.states for leg in state.legs)
    best = replan(instance, plan, at_s, zones=[zone], method="auto", time_limit=limit_s)
    zoned = instance.replace(keep_out_zones=(zone,))
    known = adr_opt.solve(zoned, "auto", time_limit=limit_s)
    return {
        "field": instance.name,
        "day": day,
        "wall_s": round(min(wall), 3),
        "cpu_s": round(min(used), 3),
        "collected": flown + made.prize_after,
        "collected_by_auto": flown + best.prize_after,
        "its_rest_proven": best.result.status,
        "without_zone": plan.objective,
        "known_from_the_start": known.objective,
        "its_bound": known.upper_bound,
    }


def main() -> None:
    """Measure and print."""
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("--seeds", type=int, nargs="+", default=[0, 1, 2, 3])
    parser.add_argument("--days", type=float, nargs="+", default=[2.0, 3.0, 4.0])
    parser.add_argument("--time-limit", type=float, default=20.0)
    arguments = parser.parse_args()
    print(heading())
    small = adr_opt.generate("tiny", 0)
    for method in ("beam", "auto"):
        adr_opt.solve(small, method, time_limit=5.0)
    for seed in arguments.seeds:
        for day in arguments.days:
            print(json.dumps(measure(seed, day, arguments.time_limit)), flush=True)


if __name__ == "__main__":
    main()
