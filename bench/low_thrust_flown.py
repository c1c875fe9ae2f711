"""Low-thrust legs flown: the closed form against integrated legs, their misses, and the time taken.

    python bench/low_thrust_flown.py

Missions of one leg are drawn: orbits 650 to 950 km high, up to 60 km, 0.2° and 6° of node apart at
the end, with 20 to 60 days and an acceleration of 1 to 5 · 10⁻⁴ m/s², once between circles and once
with eccentricities up to 0.005. Each leg is planned, refined under J2, and flown by the second
integrator. A negative error is a leg that the closed form has cheaper than it is. Times are
processor time.

    python bench/low_thrust_flown.py --spans 160

Legs between circles are drawn with 3 to 60 days, as many of each factor in time, and up to 6° of
node and, from 20 days on, 60 km and 0.2° apart, in shorter times in proportion less. The table has
flown over planned ΔV, in total, by days and by planned ΔV.
"""

from __future__ import annotations

import argparse
import math
import time
from itertools import pairwise
from typing import Any

import numpy as np
from machine import heading

import adr_opt
from adr_opt.common.constants import DAY_S, EARTH_RADIUS_M, MU_M3_S2, OBLATENESS_M2
from adr_opt.fly.flight import fly_refined
from adr_opt.problem.instance import Instance, instance_of

DRY_KG, PROPELLANT_KG, ISP_S, DUTY = 300.0, 20.0, 1500.0, 0.9

DAYS = (3.0, 5.0, 10.0, 20.0, 60.0)
"""Limits of classes of days."""

CLASSES_M_S = (50.0, 100.0, 200.0)
"""Limits of classes of planned ΔV."""

ONE_CLASS = 1000.0
"""Width of classes of mass with which there is one: accelerations are as drawn."""


def node_rate(axis_m: float, inclination_deg: float) -> float:
    """Secular rate of the node of a circle [rad/s]."""
    n = math.sqrt(MU_M3_S2 / axis_m**3)
    return -1.5 * OBLATENESS_M2 / axis_m**2 * n * math.cos(math.radians(inclination_deg))


def drawn(rng: np.random.Generator, eccentricity: float, days: float | None = None) -> Instance:
    """A mission of one leg, of 20 to 60 days if none are given."""
    whole = days is None
    span = (rng.uniform(20.0, 60.0) if days is None else days) * DAY_S
    near, turn = (1.0, 1.0) if whole else (min(span / (20.0 * DAY_S), 1.0), span / (60.0 * DAY_S))
    axis = EARTH_RADIUS_M + rng.uniform(650e3, 950e3)
    inclination = float(rng.choice([71.0, 82.5, 86.4, 98.0]))
    other = axis + near * rng.uniform(-60e3, 60e3), inclination + near * rng.uniform(-0.2, 0.2)
    apart = turn * rng.uniform(-6.0, 6.0) - math.degrees(
        (node_rate(*other) - node_rate(axis, inclination)) * span
    )
    node = rng.uniform(0.0, 360.0)
    orbits: list[dict[str, Any]] = [
        {
            "semi_major_axis_m": float(of[0]),
            "eccentricity": eccentricity * rng.uniform(),
            "inclination_deg": float(of[1]),
            "raan_deg": float(raan % 360.0),
            "argument_of_perigee_deg": rng.uniform(0.0, 360.0),
            "true_anomaly_deg": rng.uniform(0.0, 360.0),
        }
        for of, raan in (((axis, inclination), node), (other, node + apart))
    ]
    acceleration = 10.0 ** rng.uniform(-4.0, math.log10(5e-4))
    tank = {"dry_mass_kg": DRY_KG, "propellant_kg": PROPELLANT_KG, "isp_s": ISP_S}
    return instance_of(
        {
            "format": "adr-opt-instance/2",
            "name": "leg",
            "epoch": f"2027-{rng.integers(1, 13):02d}-01T00:00:00Z",
            "dynamics": "j2",
            "stations": [],
            "targets": [{"name": "target", "orbit": orbits[1]}],
            "chasers": [
                {
                    "name": "tug",
                    "start": {"orbit": orbits[0]},
                    "tank": tank,
                    "thrust_n": float(acceleration * (DRY_KG + PROPELLANT_KG) / DUTY),
                    "duty_cycle": DUTY,
                }
            ],
            "mission": {"duration_s": span + DAY_S, "service_s": DAY_S},
            "transfer": {"max_drift_s": span, "drift_step_s": span, "mass_class": ONE_CLASS},
        }
    )


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


def print_spans(count: int) -> None:
    """Refine and fly drawn legs of few and many days, and print how far off they are."""
    rng = np.random.default_rng(22)
    found: dict[tuple[int, int], list[tuple[float, float]]] = {}
    missing: dict[tuple[int, int], int] = {}
    drawn_legs = 0
    while drawn_legs < count:
        days = float(np.exp(rng.uniform(math.log(DAYS[0]), math.log(DAYS[-1]))))
        instance = drawn(rng, 0.0, days)
        plan = adr_opt.solve(instance, method="greedy-guarded").plan
        if not plan.legs:
            continue
        drawn_legs += 1
        cell = int(np.digitize(days, DAYS[1:-1])), int(np.digitize(plan.delta_v_m_s, CLASSES_M_S))
        refined = adr_opt.refine(instance, plan, jobs=1)
        if refined.missing:
            missing[cell] = missing.get(cell, 0) + 1
            continue
        (leg,) = fly_refined(instance, refined).legs
        found.setdefault(cell, []).append((leg.flown_delta_v_m_s, leg.planned_delta_v_m_s))
    ends = [f"up to {CLASSES_M_S[0]:g} m/s"]
    ends += [f"{low:g} to {high:g}" for low, high in pairwise(CLASSES_M_S)]
    print("\n| days | " + " | ".join([*ends, f"over {CLASSES_M_S[-1]:g} m/s", "all"]) + " |")
    print("|---" * (len(CLASSES_M_S) + 3) + "|")
    for row, (low, high) in enumerate(pairwise(DAYS)):
        cells = [[(row, at)] for at in range(len(CLASSES_M_S) + 1)]
        cells.append([(row, at) for at in range(len(CLASSES_M_S) + 1)])
        said = [
            _ratio(
                [pair for one in each for pair in found.get(one, [])],
                sum(missing.get(one, 0) for one in each),
            )
            for each in cells
        ]
        print(f"| {low:g} to {high:g} | " + " | ".join(said) + " |", flush=True)


def _ratio(legs: list[tuple[float, float]], missing: int) -> str:
    """Flown over planned, mean absolute error and number of legs."""
    lacks = f", {missing} missing" if missing else ""
    if not legs:
        return f"0{lacks}" if missing else "–"
    flown, planned = np.array(legs).T
    error = np.abs(planned / flown - 1.0).mean()
    return f"{flown.sum() / planned.sum():.3f}, {error:.1%} ({len(legs)}{lacks})"


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--legs", type=int, default=30, help="drawn legs of each kind")
    parser.add_argument(
        "--eccentricities", type=float, nargs="+", default=[0.0, 0.005], help="largest of each kind"
    )
    parser.add_argument("--spans", type=int, default=0, help="drawn legs of 3 to 60 days, instead")
    options = parser.parse_args()
    print(heading())
    if options.spans:
        print_spans(options.spans)
        return
    print(
        "\n| eccentricity up to | legs | missing | flown | closed form | mean absolute error "
        "| range | worst stand-off | worst arrival | thrust in the shadow | refined in |"
    )
    print("|---|---|---|---|---|---|---|---|---|---|---|")
    for eccentricity in options.eccentricities:
        print_row(options.legs, eccentricity)


if __name__ == "__main__":
    main()
