"""A tiny field in which some objects are towed."""

from __future__ import annotations

import adr_opt
from adr_opt.problem.instance import Instance

TANK = {"dry_mass_kg": 300.0, "propellant_kg": 600.0, "isp_s": 300.0}


def field(dynamics: str = "two-body", every: int = 2) -> Instance:
    """A tiny field, by turns with objects that are towed and that are not, and a heavy tank."""
    drawn = adr_opt.generate("tiny", 0, targets=6)
    return drawn.replace(
        dynamics=dynamics,
        targets=tuple(
            target.replace(removal="tow" if number % every == 0 else "visit", mass_kg=250.0)
            for number, target in enumerate(drawn.targets)
        ),
        chasers=(drawn.chaser.replace(tank=TANK),),
        mission=drawn.mission.replace(disposal_altitude_m=450e3),
    )
