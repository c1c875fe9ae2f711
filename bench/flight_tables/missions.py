"""Missions of weeks to a year with drift legs: whether plans hold when they are flown."""

from __future__ import annotations

import math
from collections.abc import Iterator
from itertools import pairwise
from pathlib import Path

import numpy as np
from fields import imported, planned
from tables import head, row

import adr_opt
from adr_opt.common.constants import DAY_S, EARTH_RADIUS_M
from adr_opt.fly.flight import TankFlight, fly, fly_refined
from adr_opt.fly.refine.bodies import state_of
from adr_opt.fly.refine.tow import lowest_m
from adr_opt.judge.refined.flight import released
from adr_opt.judge.refined.verdict import check_refined
from adr_opt.judge.refined.world import FreeMotion
from adr_opt.kernels.orbits.gravity import FIELDS
from adr_opt.plan.refined_plan import Gravity, RefinedLeg, RefinedTow
from adr_opt.problem.bodies import Target
from adr_opt.problem.transfer_sizes import transfers_for

INCLINATIONS_DEG = (71.0, 86.4, 98.0)

ALTITUDES_KM = ((780.0, 860.0), (650.0, 950.0))
"""A stream of fragments or of stages of one kind, and a band, by turns."""

NODES_DEG = {30: 2.0, 90: 5.0, 365: 25.0}
"""Standard deviation of the nodes of a field, by days of its mission."""


ECCENTRICITY = 0.003
"""The largest of a target; uniform."""

TANKS_M_S = (500.0, 2000.0)

TARGETS = (14, 26)

REMOVALS = ("visit", "visit", "kit", "visit", "tow")
"""Kinds of removal, by turns: of ten missions two each have kits and tows."""

MASS_KG, DISPOSAL_M = 800.0, 350e3
"""Mass of each towed object, and the disposal altitude."""

KITS, KIT_MASS_KG = 6, 20.0
"""Aboard, and the mass of each."""


def mission(seed: int, days: int, removal: str = "visit") -> adr_opt.Instance:
    """A drawn mission without a station.

    Parameters
    ----------
    seed : int
    days : int
        One of :data:`NODES_DEG`.
    removal : {"visit", "kit", "tow"}
    """
    rng = np.random.default_rng([days, seed])
    inclination = INCLINATIONS_DEG[seed % 3]
    low, high = ALTITUDES_KM[seed // 3 % 2]
    middle = rng.uniform(0.0, 360.0)

    def drawn(eccentricity: float) -> dict[str, float]:
        return {
            "semi_major_axis_m": EARTH_RADIUS_M + 1e3 * rng.uniform(low, high),
            "eccentricity": eccentricity,
            "inclination_deg": inclination + rng.normal(0.0, 0.05),
            "raan_deg": (middle + rng.normal(0.0, NODES_DEG[days])) % 360.0,
            "argument_of_perigee_deg": rng.uniform(0.0, 360.0),
            "true_anomaly_deg": rng.uniform(0.0, 360.0),
        }

    start = drawn(0.0)
    targets = [
        {"name": f"object-{number:02d}", "orbit": drawn(rng.uniform(0.0, ECCENTRICITY))}
        for number in range(1, rng.integers(*TARGETS) + 1)
    ]
    delta_v = round(rng.uniform(*TANKS_M_S), 0)
    chasers = [
        {"name": f"chaser-{c + 1}", "start": {"orbit": start}, "tank": _tank(delta_v, removal)}
        for c in range(1 + seed % 2)
    ]
    for chaser in chasers:
        if removal == "kit":
            chaser |= {"kits": KITS, "kit_mass_kg": KIT_MASS_KG}
    for target in targets:
        if removal != "visit":
            target |= {"removal": removal, "mass_kg": MASS_KG}
    asked = {"duration_s": days * DAY_S, "service_s": 0.25 * DAY_S}
    if removal == "tow":
        asked["disposal"] = {"circle_m": DISPOSAL_M}
    made = {
        "format": "adr-opt-instance/3",
        "name": f"drawn-{days}-{seed}-{removal}",
        "epoch": "2026-01-01T00:00:00Z",
        "dynamics": "j2",
        "stations": [],
        "targets": targets,
        "chasers": chasers,
        "mission": asked,
    }
    instance = adr_opt.Instance.model_validate(made)
    orbits = [*instance.body_orbits]
    return instance.replace(transfer=transfers_for(days * DAY_S, orbits=orbits))


def _tank(delta_v_m_s: float, removal: str) -> dict[str, float]:
    """The tank of a chaser: by mass where masses count, of the same worth when it is empty."""
    if removal == "visit":
        return {"delta_v_m_s": delta_v_m_s}
    dry_kg, isp_s = 600.0, 310.0
    propellant_kg = dry_kg * (math.exp(delta_v_m_s / (9.80665 * isp_s)) - 1.0)
    return {"dry_mass_kg": dry_kg, "propellant_kg": round(propellant_kg, 1), "isp_s": isp_s}


def worst_of(tanks: tuple[TankFlight, ...]) -> TankFlight | None:
    """The tank that is nearest to its limit, or beyond it."""
    known = [tank for tank in tanks if tank.over_m_s is not None]
    return max(known, key=lambda tank: tank.over_m_s / tank.budget_m_s, default=None)


def drawn_missions(each: int) -> Iterator[adr_opt.Instance]:
    """Missions of 30, 90 and 365 days."""
    for days in NODES_DEG:
        for seed in range(each):
            yield mission(seed, days, REMOVALS[seed % len(REMOVALS)])


def hold(each: int = 10, limit: float = 30.0) -> None:
    """Whether tanks hold when plans are flown in mean motion on the true orbits.

    Missions are drawn of 30, 90 and 365 days at 71°, 86.4° and 98°, some with kits and some with
    tows; each is planned with ``auto`` and judged by ``check``. The fullest use of a tank is shown.
    """
    head(
        *("mission", "targets", "visits", "bound", "legs that drift", "planned m/s"),
        *("flown m/s", "full m/s", "left"),
    )
    held, broken, all_of = 0, [0.0], 0
    for instance in drawn_missions(each):
        result = adr_opt.solve(instance, time_limit=limit, seed=0)
        plan = result.plan
        assert plan is not None
        assert adr_opt.check(instance, plan) == ()
        flight = fly(instance, plan)
        tank = worst_of(flight.tanks)
        cells = ["–"] * 4
        if tank is not None:
            sizes = tank.planned_delta_v_m_s, tank.flown_delta_v_m_s, tank.budget_m_s
            left = -tank.over_m_s / tank.budget_m_s
            broken.append(-left)
            cells = [*(f"{each:.0f}" for each in sizes), f"{left:+.1%}"]
        drifting = sum(leg.kind == "drift" for leg in plan.legs)
        row(
            instance.name,
            len(instance.targets),
            f"{result.objective:g}",
            f"{result.upper_bound:g}",
            f"{drifting} of {len(plan.legs)}",
            *cells,
        )
        all_of += 1
        held += all(one.holds for one in flight.tanks)
    print(f"\n{held} of {all_of} plans hold when flown; over by at most {max(broken):.2%}.")


def releases(catalogue: Path, tows: int = 100) -> None:
    """Where objects of a catalogue are released when their tows are refined and flown under J2.

    Neighbours by node are towed two by two, by a chaser that is launched onto the first: once to a
    circle of 450 km and once down to a perigee of 50 km. Shown are the largest distances of the
    mean perigee and apogee from the circle, and of the least radius in the first revolution from
    that of the perigee; and the least altitude of chasers: alone, of the osculating perigees on
    their legs, and passed there.
    """
    options = (
        "--no-refuelling --max-targets 120 --duration-days 5 --tow 800 --disposal-altitude 450"
    )
    instance = imported(catalogue, f"{options} --dry-mass 600 --propellant 9000 --isp 310")
    limit_m = EARTH_RADIUS_M + instance.transfer.min_altitude_m
    objects = sorted(instance.targets, key=lambda target: target.orbit.raan_deg)
    high = [each for each in objects if _perigee_m(each) > limit_m]
    head(
        *("disposal", "tows", "e", "off, km", "95 %", "chaser alone, km"),
        *("perigees on its legs, km", "passed there, km", "held"),
    )
    for disposal in ({"circle_m": 450e3}, {"perigee_m": 50e3}):
        off, alone, legs, passed, shapes, held = [], [], [], [], [], 0
        for pair in zip(high[::2], high[1::2], strict=False):
            if len(off) >= tows:
                break
            asked = instance.mission.replace(disposal=disposal)
            field = instance.replace(targets=pair, mission=asked)
            field = field.replace(chasers=(field.chaser.replace(start="anywhere"),))
            plan = planned(field, "greedy")
            assert adr_opt.check(field, plan) == ()
            if len(plan.legs) < 2:
                continue
            refined = adr_opt.refine(field, plan)
            held += check_refined(field, plan, refined) == () and fly_refined(field, refined).holds
            shapes += [target.orbit.eccentricity for target in pair]
            for leg in refined.legs:
                legs.append(leg.lowest_altitude_m / 1e3)
                passed.append((_least_m(leg, refined.gravity) - EARTH_RADIUS_M) / 1e3)
                for tow in leg.removals:
                    off.append(_off_km(tow, disposal, refined.gravity))
                    lowest = lowest_m(state_of(tow.onward), refined.gravity)
                    alone.append((lowest - EARTH_RADIUS_M) / 1e3)
        row(
            *(next(iter(disposal)), len(off), f"{min(shapes):.4f} to {max(shapes):.4f}"),
            *(f"{max(off):.2f}", f"{np.quantile(off, 0.95):.2f}", f"{min(alone):.1f}"),
            *(f"{min(legs):.1f}", f"{min(passed):.1f}", f"{held} of {len(shapes) // 2}"),
        )


def _least_m(leg: RefinedLeg, gravity: Gravity) -> float:
    """Least radius passed between the states of a leg."""
    world = FreeMotion(gravity)
    return min(
        world.arc(state_of(one), one.time_s, after.time_s)[1] for one, after in pairwise(leg.states)
    )


def _perigee_m(target: Target) -> float:
    assert target.orbit is not None
    return target.orbit.semi_major_axis_m * (1.0 - target.orbit.eccentricity)


def _off_km(tow: RefinedTow, disposal: dict[str, float], gravity: str) -> float:
    """How far a release is off its circle, or off its perigee as flown."""
    state = state_of(tow.released)
    if "perigee_m" in disposal:
        return abs(lowest_m(state, gravity) - EARTH_RADIUS_M - disposal["perigee_m"]) / 1e3
    orbit = released(state, FIELDS[gravity])
    swing = orbit.eccentricity * (EARTH_RADIUS_M + orbit.altitude_m)
    return (abs(orbit.altitude_m - disposal["circle_m"]) + swing) / 1e3


def fragments(catalogue: Path, limit: float = 30.0) -> None:
    """What is planned, flown, refined and proven among the fragments of a catalogue.

    The 40 nearest for two chasers of 3 km/s and 90 days, and 30 for one of 1.2 km/s and 60 days on
    several grids.
    """
    head(
        *("targets", "days", "tanks m/s", "step", "visits", "bound", "planned m/s", "flown m/s"),
        *("refined m/s", "least left, planned", "flown", "refined"),
    )
    two = "--max-targets 40 --duration-days 90 --delta-v 3000 --launches 2 --launch-every 1"
    one = "--max-targets 30 --duration-days 60 --delta-v 1200"
    grids = [f"{one} --drift-step-days {days:g}" for days in (0.5, 1.0, 2.0, 4.0)]
    for options in (two, one, *grids):
        instance = imported(catalogue, f"--no-refuelling {options}")
        result = adr_opt.solve(instance, time_limit=limit, seed=0)
        plan = result.plan
        assert plan is not None
        assert adr_opt.check(instance, plan) == ()
        flight, refined = fly(instance, plan), adr_opt.refine(instance, plan)
        over = [
            max(tank.over_m_s or math.nan for tank in one.tanks)
            for one in (flight, fly_refined(instance, refined))
        ]
        left = min(tank.budget_m_s - tank.planned_delta_v_m_s for tank in flight.tanks)
        flown = sum(tank.flown_delta_v_m_s or math.nan for tank in flight.tanks)
        row(
            len(instance.targets),
            f"{instance.mission.duration_s / DAY_S:g}",
            " + ".join(f"{chaser.tank.delta_v_m_s:g}" for chaser in instance.chasers),
            f"{instance.transfer.drift_step_s / DAY_S:g} d",
            f"{result.objective:g}",
            f"{result.upper_bound:g}",
            *(f"{one:.0f}" for one in (plan.delta_v_m_s, flown, refined.flown_delta_v_m_s)),
            *(f"{one:.0f} m/s" for one in (left, -over[0], -over[1])),
        )
