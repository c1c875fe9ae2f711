"""A small campaign for the tests of the shell: two launches, kits, and tanks by mass."""

from __future__ import annotations

from functools import cache

import adr_opt
from adr_opt.common.constants import DAY_S
from adr_opt.plan.plan import Plan
from adr_opt.problem.chasers import TankByMass
from adr_opt.problem.instance import Instance
from adr_opt.problem.transfer_sizes import transfers_for

DURATION_S = 60.0 * DAY_S
DRY_KG, PROPELLANT_KG, KIT_KG = 200.0, 80.0, 20.0


def campaign(dynamics: str = "j2", chasers: int = 2, kits: int = 3) -> Instance:
    """Upper stages near one another, and chasers that are launched twenty days apart."""
    drawn = adr_opt.generate("removal", 5, targets=8, chasers=chasers)
    orbit = drawn.targets[0].orbit
    return drawn.replace(
        dynamics=dynamics,
        transfer=transfers_for(DURATION_S)
        if dynamics == "j2"
        else adr_opt.generate("tiny", 0).transfer,
        mission=drawn.mission.replace(duration_s=DURATION_S, service_s=DAY_S),
        targets=tuple(
            target.replace(
                orbit=orbit.replace(
                    raan_deg=orbit.raan_deg + 0.7 * number % 3.1,
                    semi_major_axis_m=orbit.semi_major_axis_m + 6e3 * (number % 4),
                    eccentricity=0.0,
                    argument_of_perigee_deg=0.0,
                    true_anomaly_deg=40.0 * number % 360.0,
                )
            )
            for number, target in enumerate(drawn.targets)
        ),
        chasers=tuple(
            chaser.replace(
                available_s=(20.0 * DAY_S * number, None),
                tank=TankByMass(dry_mass_kg=DRY_KG, propellant_kg=PROPELLANT_KG, isp_s=300.0),
                kits=kits,
                kit_mass_kg=KIT_KG,
            )
            for number, chaser in enumerate(drawn.chasers)
        ),
    )


@cache
def planned(dynamics: str = "j2", chasers: int = 2, kits: int = 3) -> Plan:
    """A plan of it in which every chaser flies."""
    plan = adr_opt.solve(campaign(dynamics, chasers, kits), time_limit=20.0).plan
    assert plan is not None
    assert all(len(route.legs) > 1 for route in plan.routes)
    return plan
