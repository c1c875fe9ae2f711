"""A removal campaign: annual launches, with kits for heavy upper stages of two kinds.

Half of the targets are like those of :mod:`.rocket_bodies`, the others lighter and far more
frequent: some hundreds of them remain near 83° and 960 km. All nodes go all around. A chaser is
launched onto a target of its choice, with a kit for each object that it goes to, which stays there
and takes it down; there is no refuelling.
"""

from __future__ import annotations

from ...common.constants import DAY_S
from ...problem.chasers import Chaser, TankByMass
from ...problem.orbit import Orbit
from .ellipse import draw_ellipse
from .rocket_bodies import RAAN_DEG, draw_rocket_body
from .stream import Uniform

TARGETS, CHASERS = 60, 4

DURATION_S = 1826.0 * DAY_S
APART_S = 365.0 * DAY_S
"""Interval between launches [s]."""

LIGHTER_ALTITUDE_KM = (930.0, 990.0)
LIGHTER_INCLINATION_DEG = (82.9, 83.0)
LIGHTER_ECCENTRICITY = (0.0, 0.004)

HEAVY_KG, LIGHT_KG = 9000.0, 1400.0
"""Masses of the two kinds [kg]."""

TANK = TankByMass(dry_mass_kg=500.0, propellant_kg=100.0, isp_s=300.0)
KITS, KIT_MASS_KG = 8, 40.0


def draw_target(uniform: Uniform) -> Orbit:
    """A target of either kind."""
    if uniform(0.0, 1.0) < 0.5:
        return draw_rocket_body(uniform)
    return draw_ellipse(
        uniform, LIGHTER_ALTITUDE_KM, LIGHTER_INCLINATION_DEG, LIGHTER_ECCENTRICITY, RAAN_DEG
    )


def mass_kg(orbit: Orbit) -> float:
    """Mass of the target in an orbit."""
    return LIGHT_KG if orbit.inclination_deg > 77.0 else HEAVY_KG


def chaser(number: int) -> Chaser:
    """The chaser with a number from 0, launched a year after its predecessor."""
    return Chaser(
        name=f"chaser-{number + 1}",
        start="anywhere",
        available_s=(APART_S * number, None),
        tank=TANK,
        kits=KITS,
        kit_mass_kg=KIT_MASS_KG,
    )
