"""What a small scenario takes and finds: a synthetic population with campaigns and without.

    python bench/scenario.py
    python bench/scenario.py --objects 24000 --years 1 --seeds 1 --every 2

Objects are drawn (`population.py`), without the two constellations, which dodge. A campaign is a
launch of one chaser with kits.
"""

from __future__ import annotations

import argparse
import tempfile
import time
from pathlib import Path
from typing import Any

from machine import heading
from worth import DODGING, bodies_of

from adr_opt.analysis.scenario import ScenarioSettings, scenario, scenario_answer
from adr_opt.common.constants import DAY_S
from adr_opt.problem.chasers import TankByMass
from adr_opt.problem.instance import Instance
from adr_opt.sources import catalogue
from adr_opt.sources.worth import Bodies

TANK = TankByMass(dry_mass_kg=500.0, propellant_kg=700.0, isp_s=320.0)

KITS, KIT_KG = 5, 100.0

MISSION_DAYS, SERVICE_DAYS = 700.0, 5.0

ROWS = (
    ("objects", "{:.1f}"),
    ("fragments", "{:.1f}"),
    ("catastrophic", "{:.3g}"),
    ("expected_fragments_before", "{:.3g}"),
)


def template_of(bodies: Bodies) -> Instance:
    """A campaign of one launched chaser with kits; its target only says so."""
    return catalogue.to_instance(
        bodies.records[:1],
        mission=catalogue.MissionOutline(
            name="one-launch", duration_s=MISSION_DAYS * DAY_S, refuelling=False
        ),
        crew=catalogue.Crew(
            tank=TANK, launches=1, kits=KITS, kit_mass_kg=KIT_KG, service_s=SERVICE_DAYS * DAY_S
        ),
    ).instance


def cell(pair: dict[str, Any], at: int, form: str) -> str:
    """A mean with its standard error."""
    mean, error = pair["mean"][at], pair["standard_error"]
    return form.format(mean) + ("" if error is None else f" ± {error[at]:.3g}")


def main() -> None:
    """Run the scenario, and print its time and table."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--objects", type=int, default=2000)
    parser.add_argument("--years", type=int, default=20)
    parser.add_argument("--every", type=int, default=2)
    parser.add_argument("--seeds", type=int, default=3)
    parser.add_argument("--time-limit", type=float, default=2.0)
    call = parser.parse_args()
    print(heading())
    with tempfile.TemporaryDirectory() as name:
        bodies = bodies_of(Path(name), call.objects, DODGING)
    settings = ScenarioSettings(
        years=call.years,
        every=call.every,
        seeds=call.seeds,
        time_limit_s=call.time_limit,
        explosions=1e-4,
        capture_failure=0.1,
        campaign_failure=0.05,
    )
    begin, cpu_begin = time.perf_counter(), time.process_time()
    made = scenario(bodies, template_of(bodies), settings, jobs=1)
    wall_s, cpu_s = time.perf_counter() - begin, time.process_time() - cpu_begin
    told = scenario_answer(made)
    flown = [each for each in told["campaigns"] if each["flown"]]
    sums = {
        name: sum(each[name] for each in flown)
        for name in ("flown", "failed", "captured", "missed", "replanned")
    }
    print(
        f"{told['objects']:,} objects, years: {call.years}, futures in both cases: {call.seeds}; "
        f"{wall_s:.0f} s, {cpu_s:.0f} s of processors. "
        f"Campaigns: {sums['flown']}, lost at launch: {sums['failed']}, objects captured: "
        f"{sums['captured']}, missed: {sums['missed']}, planned anew: {sums['replanned']} times.\n"
    )
    headings = (
        "year",
        "case",
        "objects",
        "fragments of events",
        "catastrophic a year",
        "fragments expected so far",
    )
    print(f"| {' | '.join(headings)} |")
    print("|---|---|---|---|---|---|")
    for at in sorted({0, call.years // 2, call.years}):
        for case in ("without", "with", "difference"):
            cells = (cell(told[case][name], at, form) for name, form in ROWS)
            print(f"| {at} | {case} | {' | '.join(cells)} |")


if __name__ == "__main__":
    main()
