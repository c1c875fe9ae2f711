"""Plans of chasers with low thrust: one class of masses, several, and exact masses.

    python bench/low_thrust_masses.py

Missions are drawn of five targets on sun-synchronous orbits up to some 4° of node apart, in 60 to
200 days, with a dry mass of 150 to 300 kg, propellant of 10 to 40 % of that, 30 to 150 mN and
1,500 s; a second set has tows, and a third kits of 10 kg. Each is planned with one class; the order
of that plan is then timed at least ΔV for each width of classes; the narrowest stands for exact
masses. Lists have a resolution of 0.1 m/s.
"""

from __future__ import annotations

import argparse
import time
from typing import Any

import numpy as np
from machine import heading

import adr_opt
from adr_opt.common.constants import DAY_S
from adr_opt.mission.mission import Mission
from adr_opt.problem.drives import CLASS_WIDTH, drive_of
from adr_opt.problem.instance import Instance, instance_of

ONE, EXACT = 1000.0, 0.0025
WIDTHS = (ONE, 0.07, CLASS_WIDTH, 0.0175, EXACT)
SETS = {"visits": "visit", "tows": "tow", "kits": "kit"}


def drawn(seed: int, removal: str) -> Instance:
    """A mission in which not everything can be done."""
    rng = np.random.default_rng(seed)
    field = adr_opt.generate("sso", seed, targets=5)
    duration_s, dry_kg = float(rng.uniform(60.0, 200.0)) * DAY_S, float(rng.uniform(150.0, 300.0))
    bodies: list[dict[str, Any]] = []
    for target in field.targets:
        body = target.model_dump(mode="json")
        body["orbit"]["raan_deg"] = float(rng.normal(0.0, 4.0)) % 360.0
        bodies.append(body | {"removal": removal, "mass_kg": float(rng.uniform(50.0, 200.0))})
    tug = {
        "name": "tug",
        "start": {"orbit": bodies[0]["orbit"] | {"raan_deg": 1.0}},
        "tank": {
            "dry_mass_kg": dry_kg,
            "propellant_kg": dry_kg * float(rng.uniform(0.1, 0.4)),
            "isp_s": 1500.0,
        },
        "thrust_n": float(rng.uniform(0.03, 0.15)),
        "duty_cycle": 0.9,
        "kit_mass_kg": 10.0,
    }
    content = field.model_dump(mode="json") | {"targets": bodies, "chasers": [tug], "stations": []}
    content["mission"] = {"duration_s": duration_s, "service_s": DAY_S}
    if removal == "tow":
        content["mission"] |= {"disposal_altitude_m": 4.5e5}
    content["transfer"] |= {
        "max_drift_s": duration_s,
        "drift_step_s": duration_s / 20,
        "departure_spacing_s": DAY_S,
        "delta_v_resolution_m_s": 0.1,
    }
    return instance_of(content)


def with_width(instance: Instance, width: float) -> Instance:
    """The mission with classes of a width."""
    return instance.replace(transfer=instance.transfer.replace(mass_class=width))


def print_set(name: str, removal: str, missions: int) -> None:
    """Print the rows of a set."""
    costs: dict[float, list[float]] = {width: [] for width in WIDTHS}
    counts: dict[float, list[int]] = {width: [] for width in WIDTHS}
    taken = dict.fromkeys(WIDTHS, 0.0)
    legs = 0
    for seed in range(missions):
        instance = drawn(seed, removal)
        one = with_width(instance, ONE)
        plan = adr_opt.solve(one, time_limit=600.0, iterations=20).plan
        if plan is None or not plan.legs:
            continue
        legs += len(plan.legs)
        for width in WIDTHS:
            of_width = with_width(instance, width)
            mission = Mission(of_width)
            begun = time.process_time()
            found = mission.time_by_class(plan.destinations)
            taken[width] += time.process_time() - begun
            assert found.made == len(plan.legs)
            costs[width].append(found.delta_v)
            drive = drive_of(of_width.chasers[0], of_width.targets)
            assert drive is not None
            counts[width].append(len(drive.classes_kg(width)))
    exact = np.array(costs[EXACT])
    for width in WIDTHS:
        cost = np.array(costs[width])
        said = "one class" if width == ONE else f"{width:.2%}"
        print(
            f"| {name} | {said} | {np.mean(counts[width]):.1f} | {legs} | {cost.sum():.0f} m/s | "
            f"{cost.sum() / exact.sum() - 1.0:+.2%} | {(cost / exact).max() - 1.0:+.1%} | "
            f"{taken[width] / legs * 1e3:.0f} ms |",
            flush=True,
        )


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--missions", type=int, default=40, help="drawn missions of each set")
    options = parser.parse_args()
    print(heading())
    print(
        "\n| missions | width | classes | legs | total | against exact masses | largest of a plan "
        "| processor time of a leg |"
    )
    print("|---|---|---|---|---|---|---|---|")
    for name, removal in SETS.items():
        print_set(name, removal, options.missions)


if __name__ == "__main__":
    main()
