"""A tiny field in which some objects are towed."""

from __future__ import annotations

from random_rules import (
    carrying,
    drifting_mission,
    mixed_campaign,
    random_campaign,
    random_mission,
    towing,
)

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
        mission=drawn.mission.replace(disposal={"circle_m": 450e3}),
    )


def drawn(seed: int) -> Instance:
    """One chaser or several that tow, by turns with kits, in all dynamics."""
    draw = drifting_mission if seed % 2 else random_mission
    make = (draw, lambda n: random_campaign(n, draw), lambda n: mixed_campaign(n, draw))[seed % 3]
    made = make(seed // 2)
    return towing(carrying(made, seed) if seed % 4 < 2 else made, seed)
