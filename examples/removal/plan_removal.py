r"""From the upper stages of a catalogue to a campaign of removal, proven and refined: one command.

    python examples/removal/plan_removal.py catalogue.tle --out removal
    python examples/removal/plan_removal.py examples/removal/bodies.tle --out made-up

The catalogue is a file of your own, TLE or OMM; the second command takes a made-up one. Three
chasers are launched within four years, each onto a target of its choice, with a kit for every stage
that it goes to. The two most dangerous stages have to be removed by a deadline: those whose mass,
times the number of other stages of the catalogue that share their altitudes, is the largest. The
folder gets mission.json, plan.json, refined.json and page.html.
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Sequence
from pathlib import Path

import adr_opt
from adr_opt.fly.flight.tanks import tanks_of
from adr_opt.fly.refine.all_legs import refine
from adr_opt.problem.chasers import TankByMass
from adr_opt.problem.instance import Instance
from adr_opt.problem.orbit import Orbit
from adr_opt.sources import catalogue
from adr_opt.ui.cli.timeline import by_chaser
from adr_opt.ui.report import write_report

DAY_S = 86400.0
MASSES_KG = {"SL-16 R/B": 9000.0, "SL-8 R/B": 1400.0}
"""Masses of the stages by name, to some hundreds of kilograms."""
TANK = {"dry_mass_kg": 500.0, "isp_s": 300.0}
KIT_MASS_KG = 40.0
DANGEROUS = 2


def altitudes_m(orbit: Orbit) -> tuple[float, float]:
    """Radii of perigee and apogee."""
    a, e = orbit.semi_major_axis_m, orbit.eccentricity
    return a * (1.0 - e), a * (1.0 + e)


def shared(orbit: Orbit, others: Sequence[Orbit]) -> int:
    """Number of other stages at altitudes that this one passes, too."""
    low, high = altitudes_m(orbit)
    bands = [altitudes_m(other) for other in others]
    return sum(lower <= high and low <= higher for lower, higher in bands) - 1


def with_deadlines(instance: Instance, deadline_s: float) -> Instance:
    """The mission with masses, and with the most dangerous stages required in time."""
    masses = [
        next(mass for part, mass in MASSES_KG.items() if part in target.name)
        for target in instance.targets
    ]
    orbits = [target.orbit for target in instance.targets]
    crowds = [shared(orbit, orbits) for orbit in orbits]
    dangers = [mass * crowd for mass, crowd in zip(masses, crowds, strict=True)]
    worst = sorted(range(len(dangers)), key=lambda at: -dangers[at])[:DANGEROUS]
    for at in worst:
        print(
            f"{instance.targets[at].name}: {masses[at]:g} kg, {crowds[at]} others at its "
            f"altitudes: to be removed by day {deadline_s / DAY_S:g}"
        )
    return instance.replace(
        targets=tuple(
            target.replace(
                mass_kg=mass,
                required=at in worst,
                window_s=(0.0, deadline_s if at in worst else None),
            )
            for at, (target, mass) in enumerate(zip(instance.targets, masses, strict=True))
        )
    )


def mission(typed: argparse.Namespace) -> Instance:
    """The mission that the arguments say."""
    made = catalogue.to_instance(
        catalogue.read(typed.files, skip_bad=True),
        filters=catalogue.Filters(
            names=tuple(MASSES_KG), altitude_km=(700.0, 1000.0), inclination_deg=(70.0, 84.0)
        ),
        skip_bad=True,
        mission=catalogue.MissionOutline(duration_s=DAY_S * typed.days, refuelling=False),
        crew=catalogue.Crew(
            tank=TankByMass(propellant_kg=typed.propellant, **TANK),
            launches=3,
            apart_s=DAY_S * typed.launch_every,
            kits=typed.kits,
            kit_mass_kg=KIT_MASS_KG,
        ),
    )
    for warning in made.warnings:
        print(f"warning: {warning}", file=sys.stderr)
    return with_deadlines(made.instance, DAY_S * typed.deadline)


def main(arguments: Sequence[str] | None = None) -> int:
    """Plan what the arguments say; the exit status."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").partition("\n")[0])
    parser.add_argument("files", nargs="+", metavar="FILE", help="catalogue, TLE or OMM")
    parser.add_argument("--days", type=float, default=1461.0, help="duration of the mission")
    parser.add_argument("--launch-every", type=float, default=365.0, help="days")
    parser.add_argument("--deadline", type=float, default=548.0, help="of the dangerous, days")
    parser.add_argument("--propellant", type=float, default=100.0, help="of a full tank, kg")
    parser.add_argument("--kits", type=int, default=6, help="that a chaser carries at most")
    parser.add_argument("--margin", type=float, default=0.1, help="share of the tanks kept back")
    parser.add_argument("--time-limit", type=float, default=60.0, help="seconds for plan and proof")
    parser.add_argument("--out", type=Path, required=True, metavar="FOLDER")
    typed = parser.parse_args(arguments)
    try:
        instance = mission(typed)
        result = adr_opt.solve(instance, time_limit=typed.time_limit, margin=typed.margin)
        plan = result.plan
        if plan is None:
            raise adr_opt.InputError(f"no plan: status {result.status}; raise --time-limit")
        violations = adr_opt.check(instance, plan)
        typed.out.mkdir(parents=True, exist_ok=True)
        (typed.out / "mission.json").write_text(instance.to_json(), encoding="utf-8")
        plan.save(typed.out / "plan.json")
        for sentence in by_chaser(instance, plan):
            print(sentence)
        # Legs of a year, flown in true dynamics again and again, take minutes.
        refined = refine(instance, plan)
        refined.save(typed.out / "refined.json")
        write_report(instance, plan, typed.out / "page.html", refined)
    except (adr_opt.InputError, OSError) as error:
        print(error, file=sys.stderr)
        return 2
    broken = [tank for tank in tanks_of(instance, refined) if not tank.holds]
    print(
        f"refined: {len(refined.legs)} legs in the field {refined.gravity}, planned with "
        f"{refined.planned_delta_v_m_s:.0f} m/s, flown with {refined.flown_delta_v_m_s:.0f} m/s, "
        f"{len(refined.missing)} missing, {len(broken)} tanks broken"
    )
    most = min(result.upper_bound, float(len(instance.targets)))
    print(
        f"{plan.objective:g} of {len(instance.targets)} removed, at most {most:g} "
        f"with {100.0 * typed.margin:g} % of each tank kept back, "
        f"{len(violations)} violations: {typed.out / 'page.html'}"
    )
    return 1 if violations or broken or refined.missing else 0


if __name__ == "__main__":
    sys.exit(main())
