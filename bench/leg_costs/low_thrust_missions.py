"""Low-thrust legs of drawn missions: classes of mass, and the closed form against flown legs."""

from __future__ import annotations

import math
import time
from collections import defaultdict
from typing import Any

import numpy as np
from tables import head, row

import adr_opt
from adr_opt.common.constants import DAY_S, EARTH_RADIUS_M, MU_M3_S2, OBLATENESS_M2
from adr_opt.fly.flight import fly_refined
from adr_opt.mission.mission import Mission
from adr_opt.problem.drives import CLASS_WIDTH, drive_of
from adr_opt.problem.instance import Instance, instance_of

ONE, EXACT = 1000.0, 0.0025
"""Widths of classes of mass with which there is one, and with which they stand for exact masses."""

WIDTHS = (ONE, 0.07, CLASS_WIDTH, 0.0175, EXACT)


def removing(seed: int, removal: str) -> Instance:
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
        content["mission"] |= {"disposal": {"circle_m": 4.5e5}}
    content["transfer"] |= {
        "max_drift_s": duration_s,
        "drift_step_s": duration_s / 20,
        "departure_spacing_s": DAY_S,
        "delta_v_resolution_m_s": 0.1,
    }
    return instance_of(content)


def classes(missions: int = 40) -> None:
    """Plans of chasers with low thrust: one class of masses, several, and exact masses.

    Missions are drawn of five targets on sun-synchronous orbits up to some 4° of node apart, in 60
    to 200 days, with a dry mass of 150 to 300 kg, propellant of 10 to 40 % of that, 30 to 150 mN
    and 1,500 s; a second set has tows, and a third kits of 10 kg. Each is planned with one class;
    the order of that plan is then timed at least ΔV for each width of classes. Lists have a
    resolution of 0.1 m/s.
    """
    head(
        *("missions", "width", "classes", "legs", "total", "against exact masses"),
        *("largest of a plan", "processor time of a leg"),
    )
    for name, removal in {"visits": "visit", "tows": "tow", "kits": "kit"}.items():
        costs, counts = (defaultdict[float, list[float]](list) for _ in range(2))
        taken, legs = dict.fromkeys(WIDTHS, 0.0), 0
        for seed in range(missions):
            instance = removing(seed, removal)
            of_width = {
                width: instance.replace(transfer=instance.transfer.replace(mass_class=width))
                for width in WIDTHS
            }
            plan = adr_opt.solve(of_width[ONE], time_limit=600.0, iterations=20).plan
            if plan is None or not plan.legs:
                continue
            legs += len(plan.legs)
            for width, each in of_width.items():
                mission = Mission(each)
                begun = time.process_time()
                found = mission.time_by_class(plan.destinations)
                taken[width] += time.process_time() - begun
                assert found.made == len(plan.legs)
                costs[width].append(found.delta_v)
                drive = drive_of(each.chasers[0], each.targets)
                assert drive is not None
                counts[width].append(len(drive.classes_kg(width)))
        exact = np.array(costs[EXACT])
        for width in WIDTHS:
            cost = np.array(costs[width])
            row(
                name,
                "one class" if width == ONE else f"{width:.2%}",
                f"{np.mean(counts[width]):.1f}",
                legs,
                f"{cost.sum():.0f} m/s",
                f"{cost.sum() / exact.sum() - 1.0:+.2%}",
                f"{(cost / exact).max() - 1.0:+.1%}",
                f"{taken[width] / legs * 1e3:.0f} ms",
            )


DRY_KG, PROPELLANT_KG, ISP_S, DUTY = 300.0, 20.0, 1500.0, 0.9


ONE_CLASS = 1000.0
"""Width of classes of mass with which there is one: accelerations are as drawn."""


def node_rate(axis_m: float, inclination_deg: float) -> float:
    """Secular rate of the node of a circle [rad/s]."""
    n = math.sqrt(MU_M3_S2 / axis_m**3)
    return -1.5 * OBLATENESS_M2 / axis_m**2 * n * math.cos(math.radians(inclination_deg))


def single(rng: np.random.Generator, eccentricity: float) -> Instance:
    """A mission of one leg, of 20 to 60 days."""
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
            "format": "adr-opt-instance/3",
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


def thrust_flown(
    legs: int = 30,
    eccentricities: tuple[float, ...] = (0.0, 0.005),
    burns: str = "sequence",
    seed: int = 21,
) -> None:
    """The closed form against integrated legs, their misses, and the time taken.

    Missions of one leg are drawn: orbits 650 to 950 km high, up to 60 km, 0.2° and 6° of node apart
    at the end, with 20 to 60 days and an acceleration of 1 to 5 · 10⁻⁴ m/s², between circles and
    with eccentricities. Each leg is planned, refined under J2, and flown by the second integrator.
    A negative error is a leg that the closed form has cheaper than it is. Times are processor time.
    ``--burns free`` has the price in which eccentricities change with the size.
    """
    head(
        *("eccentricity up to", "legs", "missing", "flown", "closed form", "mean absolute error"),
        *(
            "within 10 %",
            "range",
            "worst stand-off",
            "worst arrival",
            "thrust in the shadow",
            "refined in",
        ),
    )
    for eccentricity in eccentricities:
        rng, flown, planned = np.random.default_rng(seed), list[Any](), list[float]()
        missing, taken = 0, 0.0
        while len(planned) + missing < legs:
            instance = single(rng, eccentricity)
            instance = instance.replace(transfer=instance.transfer.replace(burns=burns))
            plan = adr_opt.solve(instance, method="greedy-guarded").plan
            if not plan.legs:
                continue
            begun = time.process_time()
            refined = adr_opt.refine(instance, plan, jobs=1)
            taken += time.process_time() - begun
            if refined.missing:
                missing += 1
                continue
            flown += fly_refined(instance, refined).legs
            planned.append(flown[-1].planned_delta_v_m_s)
        burnt = np.array([leg.flown_delta_v_m_s for leg in flown])
        off = np.array(planned) / burnt - 1.0
        misses = (
            [(leg.standoff_miss_m, leg.standoff_miss_m_s) for leg in flown],
            [(leg.arrival_miss_m, leg.arrival_miss_m_s) for leg in flown],
        )
        row(
            f"{eccentricity:g}",
            len(planned),
            missing,
            f"{burnt.sum():.0f} m/s",
            f"{sum(planned) / burnt.sum() - 1.0:+.1%}",
            f"{np.abs(off).mean():.1%}",
            f"{np.mean(np.abs(off) <= 0.1):.0%}",
            f"{off.min():+.1%} to {off.max():+.1%}",
            *("{:.2g} m, {:.2g} m/s".format(*np.max(each, axis=0)) for each in misses),
            f"{max(leg.shadow_s or 0.0 for leg in flown):.2g} s",
            f"{taken:.0f} s",
        )
