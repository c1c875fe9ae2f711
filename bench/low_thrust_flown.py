"""Low-thrust legs flown: the closed form against integrated legs, their misses, and the time taken.

    python bench/low_thrust_flown.py

Missions of one leg are drawn: orbits 650 to 950 km high, up to 60 km, 0.2° and 6° of node apart at
the end, with 20 to 60 days and an acceleration of 1 to 5 · 10⁻⁴ m/s², once between circles and once
with eccentricities up to 0.005. Each leg is planned, refined under J2, and flown by the second
integrator. A negative error is a leg that the closed form has cheaper than it is. Times are
processor time.
"""

from __future__ import annotations

import argparse
import math
import time
from typing import Any

import numpy as np
from machine import heading

import adr_opt
from adr_opt.common.constants import DAY_S, EARTH_RADIUS_M, MU_M3_S2, OBLATENESS_M2
from adr_opt.fly.flight import fly_refined
from adr_opt.problem.instance import Instance, instance_of

DRY_KG, PROPELLANT_KG, ISP_S, DUTY = 300.0, 20.0, 1500.0, 0.9

ONE_CLASS = 1000.0
"""Width of classes of mass with which there is one: accelerations are as drawn."""


def node_rate(axis_m: float, inclination_deg: float) -> float:
    """Secular rate of the node of a circle [rad/s]."""
    n = math.sqrt(MU_M3_S2 / axis_m**3)
    return -1.5 * OBLATENESS_M2 / axis_m**2 * n * math.cos(math.radians(inclination_deg))


def drawn(rng: np.random.Generator, eccentricity: float) -> Instance:
    """A mission of one leg."""
    span = rng.uniform(20.0, 60.0) * DAY_S
    axis = EARTH_RADIUS_M + rng.uniform(650e3, 950e3)
    inclination = float(rng.choice([71.0, 82.5, 86.4, 98.0]))
    other = axis + rng.uniform(-60e3, 60e3), inclination + rng.uniform(-0.2, 0.2)
    apart = rng.uniform(-6.0, 6.0) - math.degrees(
        (node_rate(*other) - node_rate(axis, inclination)) * span
    )
    node = rng.uniform(0.0, 360.0)
    orbits: list[dict[str, Any]] = [
        {
            "semi_major_axis_m": float(of[0]), "eccentricity": eccentricity * rng.uniform(),
            "inclination_deg": float(of[1]), "raan_deg": float(raan % 360.0),
            "argument_of_perigee_deg": rng.uniform(0.0, 360.0),
            "true_anomaly_deg": rng.uniform(0.0, 360.0),
        }
        for of, raan in (((axis, inclination), node), (other, node + apart))
    ]  # fmt: skip
    acceleration = 10.0 ** rng.uniform(-4.0, math.log10(5e-4))
    tank = {"dry_mass_kg": DRY_KG, "propellant_kg": PROPELLANT_KG, "isp_s": ISP_S}
    return instance_of(
        {
            "format": "adr-opt-instance/2", "name": "leg",
            "epoch": f"2027-{rng.integers(1, 13):02d}-01T00:00:00Z", "dynamics": "j2",
            "stations": [], "targets": [{"name": "target", "orbit": orbits[1]}],
            "chasers": [
                {
                    "name": "tug", "start": {"orbit": orbits[0]}, "tank": tank,
                    "thrust_n": float(acceleration * (DRY_KG + PROPELLANT_KG) / DUTY),
                    "duty_cycle": DUTY,
                }
            ],
            "mission": {"duration_s": span + DAY_S, "service_s": DAY_S},
            "transfer": {"max_drift_s": span, "drift_step_s": span, "mass_class": ONE_CLASS},
        }
    )  # fmt: skip


def print_row(count: int, eccentricity: float) -> None:
    """Refine and fly drawn legs, and print what came of it."""
    rng = np.random.default_rng(21)
    planned, flown, stands, arrivals = [], [], [], []
    missing, taken, dark = 0, 0.0, 0.0
    while len(planned) + missing < count:
        instance = drawn(rng, eccentricity)
        plan = adr_opt.solve(instance, method="greedy-guarded").plan
        if not plan.legs:
            continue
        begun = time.process_time()
        refined = adr_opt.refine(instance, plan, jobs=1)
        taken += time.process_time() - begun
        if refined.missing:
            missing += 1
            continue
        (leg,) = fly_refined(instance, refined).legs
        planned.append(leg.planned_delta_v_m_s)
        flown.append(leg.flown_delta_v_m_s)
        stands.append((leg.standoff_miss_m, leg.standoff_miss_m_s))
        arrivals.append((leg.arrival_miss_m, leg.arrival_miss_m_s))
        dark = max(dark, leg.shadow_s or 0.0)
    off = np.array(planned) / np.array(flown) - 1.0
    misses = ["{:.2g} m, {:.2g} m/s".format(*np.max(each, axis=0)) for each in (stands, arrivals)]
    print(
        f"| {eccentricity:g} | {len(planned)} | {missing} | {sum(flown):.0f} m/s | "
        f"{sum(planned) / sum(flown) - 1.0:+.1%} | {np.abs(off).mean():.1%} | {off.min():+.1%} to "
        f"{off.max():+.1%} | {misses[0]} | {misses[1]} | {dark:.2g} s | {taken:.0f} s |",
        flush=True,
    )


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--legs", type=int, default=30, help="drawn legs of each kind")
    parser.add_argument(
        "--eccentricities", type=float, nargs="+", default=[0.0, 0.005], help="largest of each kind"
    )
    options = parser.parse_args()
    print(heading())
    print(
        "\n| eccentricity up to | legs | missing | flown | closed form | mean absolute error "
        "| range | worst stand-off | worst arrival | thrust in the shadow | refined in |"
    )
    print("|---|---|---|---|---|---|---|---|---|---|---|")
    for eccentricity in options.eccentricities:
        print_row(options.legs, eccentricity)


if __name__ == "__main__":
    main()
