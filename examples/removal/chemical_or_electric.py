r"""The same stages removed by a chemical chaser or by electric ones: how many, and how fast.

    python examples/removal/chemical_or_electric.py catalogue.tle --out drives
    python examples/removal/chemical_or_electric.py examples/removal/bodies.tle --out made-up

The catalogue is a file of your own, TLE or OMM; the second command takes a made-up one. One chaser
is launched onto a stage of its choice, tows it down to a disposal orbit, and goes on to the next.
Dry mass and propellant are the same with each drive, but for a chemical chaser with four times the
propellant. The folder gets a mission and a plan of each.
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Sequence
from pathlib import Path
from typing import NamedTuple

import adr_opt
from adr_opt.common.files import write_text
from adr_opt.mission.result import Result
from adr_opt.plan.routes import routes_of
from adr_opt.problem.bodies import DisposalCircle
from adr_opt.problem.chasers import TankByMass
from adr_opt.problem.instance import Instance
from adr_opt.problem.settings import TransferSettings
from adr_opt.sources import catalogue

DAY_S = 86400.0
YEAR_D = 365.25
MASSES_KG = {"SL-16 R/B": 9000.0, "SL-8 R/B": 1400.0}
"""Masses of the stages by name, to some hundreds of kilograms."""
SERVICE_S = 10.0 * DAY_S
GRID = TransferSettings(
    drift_step_s=20.0 * DAY_S,
    max_drift_s=360.0 * DAY_S,
    departure_spacing_s=8.0 * DAY_S,
    delta_v_resolution_m_s=20.0,
)
"""The same for each drive, fine enough for legs of months."""


class Drive(NamedTuple):
    """A way to propel a chaser; without a thrust its burns are impulses."""

    name: str
    isp_s: float
    thrust_n: float | None = None
    tanks: float = 1.0


DRIVES = (
    Drive("chemical, 320 s", 320.0),
    Drive("chemical, 320 s, four tanks", 320.0, tanks=4.0),
    Drive("electric, 0.2 N, 1500 s", 1500.0, 0.2),
    Drive("electric, 0.4 N, 1800 s", 1800.0, 0.4),
)


def mission(typed: argparse.Namespace, drive: Drive) -> Instance:
    """The mission that the arguments say, with a drive."""
    made = catalogue.to_instance(
        catalogue.read(typed.files, skip_bad=True),
        filters=catalogue.Filters(
            names=tuple(MASSES_KG), altitude_km=(700.0, 1000.0), inclination_deg=(70.0, 84.0)
        ),
        skip_bad=True,
        mission=catalogue.MissionOutline(
            duration_s=DAY_S * typed.days, refuelling=False, transfer=GRID
        ),
        crew=catalogue.Crew(
            tank=TankByMass(
                dry_mass_kg=typed.dry_mass,
                propellant_kg=drive.tanks * typed.propellant,
                isp_s=drive.isp_s,
            ),
            launches=1,
            towed_kg=1.0,
            disposal=DisposalCircle(circle_m=1e3 * typed.disposal_altitude),
            service_s=SERVICE_S,
            thrust_n=drive.thrust_n,
        ),
    )
    instance = made.instance
    targets = (
        target.replace(mass_kg=next(kg for part, kg in MASSES_KG.items() if part in target.name))
        for target in instance.targets
    )
    return instance.replace(targets=tuple(targets))


def told(instance: Instance, result: Result) -> str:
    """What a drive achieves."""
    plan = result.plan
    if plan is None:
        raise adr_opt.InputError(f"no plan: status {result.status}; raise --time-limit")
    violations = adr_opt.check(instance, plan)
    (flown,) = routes_of(instance, plan)
    used_kg = flown.carried(instance).used_kg or 0.0
    days = [leg.done_s / DAY_S for leg in plan.legs]
    last = max(days, default=0.0)
    most = min(result.upper_bound, float(len(instance.targets)))
    names = [leg.destination for leg in plan.legs]
    kinds = ", ".join(f"{sum(part in name for name in names)} {part}" for part in MASSES_KG)
    return (
        f"removes {plan.objective:g} of {len(instance.targets)} ({kinds}), at most {most:g}; "
        f"{used_kg:.0f} kg of propellant, {100.0 * plan.objective / max(used_kg, 1.0):.1f} "
        f"removals per 100 kg; on days {', '.join(f'{day:.0f}' for day in days)}, "
        f"{plan.objective / max(last / YEAR_D, 1e-9):.1f} a year; {len(violations)} violations"
    )


def main(arguments: Sequence[str] | None = None) -> int:
    """Compare what the arguments say; the exit status."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").partition("\n")[0])
    parser.add_argument("files", nargs="+", metavar="FILE", help="catalogue, TLE or OMM")
    parser.add_argument("--days", type=float, default=1826.0, help="duration of the mission")
    parser.add_argument("--dry-mass", type=float, default=600.0, help="of the chaser, kg")
    parser.add_argument("--propellant", type=float, default=300.0, help="of a full tank, kg")
    parser.add_argument("--disposal-altitude", type=float, default=500.0, help="km")
    parser.add_argument("--time-limit", type=float, default=120.0, help="seconds for each drive")
    parser.add_argument("--out", type=Path, required=True, metavar="FOLDER")
    typed = parser.parse_args(arguments)
    try:
        missions = [mission(typed, drive) for drive in DRIVES]
        typed.out.mkdir(parents=True, exist_ok=True)
        for at, (drive, instance) in enumerate(zip(DRIVES, missions, strict=True)):
            result = adr_opt.solve(instance, time_limit=typed.time_limit)
            print(f"{drive.name}: {told(instance, result)}", flush=True)
            write_text(typed.out / f"mission-{at}.json", instance.to_json())
            assert result.plan is not None
            result.plan.save(typed.out / f"plan-{at}.json")
    except (adr_opt.InputError, OSError) as error:
        print(error, file=sys.stderr)
        return 2
    return 0


if __name__ == "__main__":
    sys.exit(main())
