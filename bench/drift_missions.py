"""Missions of weeks to a year with drift legs: whether plans hold when flown, and which grid pays.

    python bench/drift_missions.py hold
    python bench/drift_missions.py releases
    python bench/drift_missions.py grid
    python bench/drift_missions.py fragments --catalogue FILE

`hold` draws missions of 30, 90 and 365 days at 71°, 86.4° and 98°, some with kits and some with
tows, plans each with `auto`, has `check` judge the plan and flies it in mean motion. It prints the
mission, the plan and the fullest use of a tank, planned and flown; with --refine also in full
dynamics. `releases` refines those of them with tows, and prints the mean orbits on which objects
are left, by the tolerance that `fly` has for spirals. `grid` plans missions without kits or tows on
grids of several steps for the same time. `fragments` imports the 40 nearest of a catalogue for two
chasers of 3 km/s and 90 days, and 30 for one of 1.2 km/s and 60 days on several grids, and prints
what is planned, flown, refined and proven.
"""

from __future__ import annotations

import argparse
import itertools
import math
import statistics
import subprocess
import sys
import tempfile
from collections.abc import Iterator
from pathlib import Path

import numpy as np
from machine import heading

import adr_opt
from adr_opt.common.constants import DAY_S, EARTH_RADIUS_M
from adr_opt.fly.flight import TankFlight, fly, fly_refined
from adr_opt.fly.flight.refined_result import MOST_RELEASE_ECCENTRICITY
from adr_opt.fly.refine.bodies import state_of
from adr_opt.fly.refine.troubles import FIELDS
from adr_opt.judge.refined.release import released
from adr_opt.problem.transfer_sizes import transfers_for

INCLINATIONS_DEG = (71.0, 86.4, 98.0)

ALTITUDES_KM = ((780.0, 860.0), (650.0, 950.0))
"""A stream of fragments or of stages of one kind, and a band, by turns."""

NODES_DEG = {30: 2.0, 60: 3.0, 90: 5.0, 180: 10.0, 365: 25.0}
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
        asked["disposal_altitude_m"] = DISPOSAL_M
    made = {
        "format": "adr-opt-instance/2",
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


def drawn_missions(each: int) -> Iterator[tuple[int, adr_opt.Instance]]:
    """Missions of 30, 90 and 365 days with their days."""
    for days in (30, 90, 365):
        for seed in range(each):
            yield days, mission(seed, days, REMOVALS[seed % len(REMOVALS)])


def worst_of(tanks: tuple[TankFlight, ...]) -> TankFlight | None:
    """The tank that is nearest to its limit, or beyond it."""
    known = [tank for tank in tanks if tank.over_m_s is not None]
    return max(known, key=lambda tank: tank.over_m_s / tank.budget_m_s, default=None)


def told(tank: TankFlight | None) -> str:
    """Planned, flown and full, and what is left of it, as cells of a table."""
    if tank is None:
        return "– | – | – | –"
    left = -tank.over_m_s / tank.budget_m_s
    return (
        f"{tank.planned_delta_v_m_s:.0f} | {tank.flown_delta_v_m_s:.0f} | {tank.budget_m_s:.0f} "
        f"| {left:+.1%}"
    )


def print_hold(each: int, limit: float, refined: bool) -> None:
    """Print whether tanks hold when plans are flown."""
    more = " refined | its tank left |" if refined else ""
    print(
        f"\nPlans by `auto` in {limit:g} s, flown in mean motion\n\n| mission | targets | visits | "
        "bound | legs that drift | planned m/s | flown m/s | full m/s | left |" + more
    )
    print("|---" * (9 + 2 * refined) + "|")
    held, broken, all_of, refined_held = 0, [], 0, 0
    for _, instance in drawn_missions(each):
        result = adr_opt.solve(instance, time_limit=limit, seed=0)
        plan = result.plan
        assert plan is not None
        violations = adr_opt.check(instance, plan)
        assert violations == (), violations
        flight = fly(instance, plan)
        tank = worst_of(flight.tanks)
        drifting = sum(leg.kind == "drift" for leg in plan.legs)
        cells = ""
        if refined:
            true = adr_opt.refine(instance, plan)
            tried = fly_refined(instance, true)
            fullest = worst_of(tried.tanks)
            refined_held += all(one.holds for one in tried.tanks)
            cells = f" {true.flown_delta_v_m_s:.0f} | {told(fullest).rsplit('|', 1)[1]} |"
        print(
            f"| {instance.name} | {len(instance.targets)} | {result.objective:g} | "
            f"{result.upper_bound:g} | {drifting} of {len(plan.legs)} | {told(tank)} |{cells}",
            flush=True,
        )
        all_of += 1
        if all(one.holds for one in flight.tanks):
            held += 1
        elif tank is not None and tank.over_m_s is not None:
            broken.append(tank.over_m_s / tank.budget_m_s)
    over = f"; the others are over by at most {max(broken):.2%}" if broken else ""
    print(f"\n{held} of {all_of} plans hold when flown{over}.")
    if refined:
        print(f"{refined_held} of {all_of} hold when refined.")


def print_releases(each: int, limit: float) -> None:
    """Print on which orbits towed objects are left, altitudes of perigee and apogee."""
    print(
        f"\nPlans by `auto` in {limit:g} s, refined; disposal at {DISPOSAL_M / 1e3:g} km\n\n"
        "| mission | objects | released: mean perigee × apogee |\n|---|---|---|"
    )
    eccentric = all_of = 0
    for _, instance in drawn_missions(each):
        if not any(target.service.is_flown for target in instance.targets):
            continue
        plan = adr_opt.solve(instance, time_limit=limit, seed=0).plan
        assert plan is not None
        refined = adr_opt.refine(instance, plan)
        orbits = [
            released(state_of(leg.tow.released), FIELDS[refined.gravity])
            for leg in refined.legs
            if leg.tow is not None
        ]
        swings = [orbit.eccentricity * (EARTH_RADIUS_M + orbit.altitude_m) for orbit in orbits]
        cells = ", ".join(
            f"{1e-3 * (orbit.altitude_m - swing):.0f} × {1e-3 * (orbit.altitude_m + swing):.0f} km"
            for orbit, swing in zip(orbits, swings, strict=True)
        )
        print(f"| {instance.name} | {len(orbits)} | {cells} |", flush=True)
        all_of += len(orbits)
        eccentric += sum(orbit.eccentricity > MOST_RELEASE_ECCENTRICITY for orbit in orbits)
    print(f"\n{eccentric} of {all_of} are left with an eccentricity above the tolerance.")


def print_grid(each: int, limit: float) -> None:
    """Print what grids of several steps lead to within the same time."""
    shares = (0.5, 1.0, 2.0, 4.0)
    print(
        f"\nSteps of the grid, `auto` for {limit:g} s: visits of bound; in brackets s to proof\n\n"
        "| mission | default step | half of it | default | twice | four times |\n"
        "|---|---|---|---|---|---|"
    )
    lost: dict[float, list[float]] = {share: [] for share in shares}
    for days, seed in itertools.product((30, 60, 90, 180), range(each)):
        instance = mission(seed, days)
        step = instance.transfer.drift_step_s
        found = {}
        for share in shares:
            settings = transfers_for(days * DAY_S, drift_step_s=share * step)
            result = adr_opt.solve(instance.replace(transfer=settings), time_limit=limit, seed=0)
            found[share] = result
        best = max(result.objective for result in found.values())
        for share, result in found.items():
            lost[share].append(best - result.objective)
        cells = " | ".join(
            f"{result.objective:g} of {result.upper_bound:g}"
            + (f" ({result.runtime_s:.0f})" if result.status == "optimal" else "")
            for result in found.values()
        )
        print(f"| {instance.name} | {step / DAY_S:g} d | {cells} |", flush=True)
    means = ", ".join(
        f"{share:g} × default {statistics.fmean(values):.2f}" for share, values in lost.items()
    )
    print(f"\nVisits short of the best of the four, in the mean: {means}.")


def imported(catalogue: Path, *options: str) -> adr_opt.Instance:
    """An instance that the verb `import` makes of a catalogue."""
    with tempfile.TemporaryDirectory() as folder:
        out = Path(folder) / "instance.json"
        command = [sys.executable, "-m", "adr_opt", "import", str(catalogue), "--quiet"]
        subprocess.run([*command, "--no-refuelling", *options, "--out", str(out)], check=True)
        return adr_opt.load(out)


def print_fragments(catalogue: Path, limit: float) -> None:
    """Print what is planned, flown, refined and proven among the fragments of a catalogue."""
    print(
        "| targets | days | tanks m/s | step | visits | bound | planned m/s | flown m/s | "
        "refined m/s | least left, planned | flown | refined |"
    )
    print("|---" * 12 + "|")
    two = "--max-targets 40 --duration-days 90 --delta-v 3000 --launches 2 --launch-every 1"
    one = "--max-targets 30 --duration-days 60 --delta-v 1200"
    grids = [f"{one} --drift-step-days {days:g}" for days in (0.5, 1.0, 2.0, 4.0)]
    for options in (two, one, *grids):
        instance = imported(catalogue, *options.split())
        result = adr_opt.solve(instance, time_limit=limit, seed=0)
        plan = result.plan
        assert plan is not None
        assert adr_opt.check(instance, plan) == ()
        flight = fly(instance, plan)
        refined = adr_opt.refine(instance, plan)
        true = fly_refined(instance, refined)
        planned = min(tank.budget_m_s - tank.planned_delta_v_m_s for tank in flight.tanks)
        cells = [
            len(instance.targets),
            f"{instance.mission.duration_s / DAY_S:g}",
            " + ".join(f"{chaser.tank.delta_v_m_s:g}" for chaser in instance.chasers),
            f"{instance.transfer.drift_step_s / DAY_S:g} d",
            f"{result.objective:g}",
            f"{result.upper_bound:g}",
            f"{plan.delta_v_m_s:.0f}",
            f"{sum(tank.flown_delta_v_m_s or math.nan for tank in flight.tanks):.0f}",
            f"{refined.flown_delta_v_m_s:.0f}",
            f"{planned:.0f} m/s",
            *(
                f"{-max(tank.over_m_s or math.nan for tank in of.tanks):.0f} m/s"
                for of in (flight, true)
            ),
        ]
        print("| " + " | ".join(str(cell) for cell in cells) + " |", flush=True)


def main() -> None:
    """Print one of the tables."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("table", choices=("hold", "releases", "grid", "fragments"))
    parser.add_argument("--each", type=int, default=10, help="missions of each length")
    parser.add_argument("--limit", type=float, default=30.0, help="seconds for each plan")
    parser.add_argument("--refine", action="store_true")
    parser.add_argument("--catalogue", type=Path, help="file of element sets, for `fragments`")
    arguments = parser.parse_args()
    print(heading())
    if arguments.table == "hold":
        print_hold(arguments.each, arguments.limit, arguments.refine)
    elif arguments.table == "releases":
        print_releases(arguments.each, arguments.limit)
    elif arguments.table == "fragments":
        if arguments.catalogue is None:
            parser.error("fragments needs --catalogue FILE")
        print_fragments(arguments.catalogue, arguments.limit)
    else:
        print_grid(arguments.each, arguments.limit)


if __name__ == "__main__":
    main()
