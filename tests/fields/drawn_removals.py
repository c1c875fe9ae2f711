"""Drawn missions that remove neighbours in fields of several families: tows, kits and visits."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

import adr_opt
from adr_opt.common.constants import DAY_S, EARTH_RADIUS_M
from adr_opt.problem.bodies import Target
from adr_opt.problem.chasers import Chaser, InOrbit, TankByMass
from adr_opt.problem.instance import Instance
from adr_opt.problem.settings import TransferSettings
from adr_opt.problem.transfer_sizes import transfers_for

LONG = ("rocket-bodies", "sso", "removal", "fragment-cloud")
"""Families whose missions last weeks here: legs drift, beside short ones."""

SHORT = ("tiny", "nominal", "cloud")
"""Families whose missions last days, in two-body motion and under J2."""

KINDS = (("tow",), ("tow", "visit"), ("tow", "kit", "visit"), ("tow",), ("kit",))
"""Kinds of service of a mission's targets, by turns."""

MOST_ECCENTRICITY = 1e-3
"""Of objects that are towed."""


def drawn_removal(seed: int) -> Instance:
    """A mission to three to five neighbours of a field, of which most can be reached.

    Seeds of the form 5 n + 4 draw kits alone; in all others the first target is towed at least.
    """
    rng = np.random.default_rng([17, seed])
    short = seed % 3 == 2
    family = str(rng.choice(SHORT if short else LONG))
    field = adr_opt.generate(family, int(rng.integers(1000)), targets=None if short else 60)
    dynamics = str(rng.choice(["two-body", "j2"])) if short else "j2"
    duration_s = DAY_S * float(rng.uniform(1.0, 4.0) if short else rng.uniform(18.0, 45.0))
    kinds = KINDS[seed % len(KINDS)]
    targets = [
        _nearly_round(
            target.replace(
                removal=kinds[0] if not number else str(rng.choice(kinds)),
                mass_kg=float(rng.uniform(100.0, 2500.0)),
            )
        )
        for number, target in enumerate(_neighbours(field, rng, int(rng.integers(3, 6))))
    ]
    lowest_m = min(_lowest_m(target) for target in targets)
    mission = field.mission.replace(
        duration_s=duration_s,
        service_revolutions=1.0 if short else None,
        service_s=None if short else float(rng.choice([0.25, 1.0])) * DAY_S,
        disposal={"circle_m": float(rng.uniform(max(lowest_m - 400e3, 300e3), lowest_m - 5e3))}
        if "tow" in kinds
        else None,
    )
    laid_out = transfers_for(duration_s) if dynamics == "j2" else TransferSettings()
    return field.replace(
        name=f"removal-{seed}",
        dynamics=dynamics,
        targets=tuple(targets),
        stations=(),
        chasers=(_chaser(targets[0], rng, "kit" in kinds),),
        mission=mission,
        transfer=laid_out.replace(min_altitude_m=250e3, max_altitude_m=2000e3),
    )


def _neighbours(field: Instance, rng: np.random.Generator, count: int) -> list[Target]:
    """A target of a field, and those with the nearest planes."""
    normals = np.array([_normal(target) for target in field.targets])
    first = int(rng.integers(len(normals)))
    nearest = np.argsort(-(normals @ normals[first]), kind="stable")[:count]
    return [field.targets[int(at)] for at in nearest]


def _normal(target: Target) -> tuple[float, float, float]:
    assert target.orbit is not None
    i, node = math.radians(target.orbit.inclination_deg), math.radians(target.orbit.raan_deg)
    return math.sin(i) * math.sin(node), -math.sin(i) * math.cos(node), math.cos(i)


def _nearly_round(target: Target) -> Target:
    """A target whose orbit is so near a circle, where it is towed, that it is released on one."""
    if target.removal != "tow" or target.orbit is None:
        return target
    most = min(target.orbit.eccentricity, MOST_ECCENTRICITY)
    return target.replace(orbit=target.orbit.replace(eccentricity=most))


def _lowest_m(target: Target) -> float:
    assert target.orbit is not None
    return target.orbit.semi_major_axis_m - EARTH_RADIUS_M


def _chaser(first: Target, rng: np.random.Generator, has_kits: bool) -> Chaser:
    """A chaser that is launched, or begins in the plane of a target but on another orbit."""
    assert first.orbit is not None
    tank = TankByMass(
        dry_mass_kg=float(rng.uniform(200.0, 2000.0)),
        propellant_kg=float(rng.uniform(2000.0, 6000.0)),
        isp_s=float(rng.uniform(220.0, 320.0)),
    )
    orbit = first.orbit.replace(
        semi_major_axis_m=first.orbit.semi_major_axis_m - float(rng.uniform(10e3, 60e3)),
        eccentricity=0.0,
        true_anomaly_deg=float(rng.uniform(0.0, 360.0)),
    )
    start: Any = "anywhere" if rng.random() < 0.4 else InOrbit(orbit=orbit)
    return Chaser(
        name="chaser",
        start=start,
        tank=tank,
        kits=4 if has_kits else None,
        kit_mass_kg=40.0 if has_kits else 0.0,
    )
