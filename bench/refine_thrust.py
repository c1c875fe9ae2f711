"""The loop of planning and refining with low thrust: plans that hold, and the rounds they take.

    python bench/refine_thrust.py
    python bench/refine_thrust.py cloud electric-0 --rounds 4

`cloud` is the example catalogue, imported with a chaser of 0.2 N for a year; `electric-N` a small
field of the family, with tows. Each is planned, refined and planned again until it holds, and
flown by `fly` with another integrator. Times are processor time.
"""

from __future__ import annotations

import argparse
import tempfile
import time
from pathlib import Path

from machine import heading

import adr_opt
from adr_opt.fly.flight import fly_refined
from adr_opt.problem.instance import Instance
from adr_opt.ui.cli.entry import main as command_line

CATALOGUE = Path(__file__).parents[1] / "examples" / "catalogue" / "cloud.tle"
CHASER = ("--thrust", "0.2", "--dry-mass", "400", "--propellant", "60", "--isp", "1500")
NAMES = ("cloud", "electric-0", "electric-1")


def instance_of(name: str, targets: int) -> Instance:
    """An instance by its name here."""
    if name != "cloud":
        return adr_opt.generate("electric", int(name.removeprefix("electric-")), targets=targets)
    with tempfile.TemporaryDirectory() as made:
        path = Path(made) / "cloud.json"
        limits = ("--duration-days", "365", "--max-targets", str(targets), "--out", str(path))
        command_line(["import", str(CATALOGUE), *CHASER, *limits, "--quiet"])
        return adr_opt.load(path)


def print_row(name: str, arguments: argparse.Namespace) -> bool:
    """Print what the loop comes to; whether its plan holds in `fly`."""
    instance = instance_of(name, arguments.targets)
    began = time.process_time()
    found = adr_opt.solve_refined(
        instance,
        time_limit=arguments.time_limit,
        rounds=arguments.rounds,
        seed=0,
        told=lambda one: print(f"{name}, {one}; corrections: {one.corrections}", flush=True),
    )
    taken = time.process_time() - began
    first = found.rounds[0]
    holds, outcome, cells = False, found.reason, "| | "
    if found.holds and found.refined is not None and found.plan is not None:
        assert not adr_opt.check(instance, found.plan)
        flight = fly_refined(instance, found.refined)
        holds = flight.holds
        outcome = "holds" if holds else "does not hold in `fly`"
        planned, flown = found.refined.planned_delta_v_m_s, found.refined.flown_delta_v_m_s
        cells = f"| {found.plan.objective:g} | {planned:.0f} → {flown:.0f} m/s "
    print(
        f"| {name} | {first.objective:g} | {first.planned_delta_v_m_s:.0f} → "
        f"{first.flown_delta_v_m_s:.0f} m/s | {len(first.troubles)} | {len(found.rounds)} "
        f"{cells}| {outcome} | {taken:.0f} s |",
        flush=True,
    )
    return holds


def main() -> None:
    """Print a row for each instance."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("names", nargs="*", default=NAMES, metavar="NAME")
    parser.add_argument("--targets", type=int, default=8)
    parser.add_argument("--rounds", type=int, default=4)
    parser.add_argument("--time-limit", type=float, default=20.0, metavar="S")
    arguments = parser.parse_args()
    print(heading())
    print(
        "| instance | prize | planned → flown | troubles | rounds | prize | planned → flown | | |"
    )
    print("|---|---|---|---|---|---|---|---|---|")
    held = [print_row(name, arguments) for name in arguments.names]
    raise SystemExit(0 if all(held) else 1)


if __name__ == "__main__":
    main()
