"""Rocket bodies: heavy upper stages, and their removal with kits or by tows of low thrust.

Near 71° and 840 km some twenty upper stages of one launcher remain, the objects that lists of what
to remove first begin with: orbits that differ mainly by their nodes. Altitudes, inclinations and
eccentricities are drawn from limits like theirs; no object of a catalogue is in it. Their nodes go
all around, and a degree of node costs 123 m/s: hardly any two can be visited one after the other
without waiting until their planes meet. There is no refuelling: the chaser is launched into a
circle of the same kind, without a station.

A removal campaign has annual launches, with kits for stages of two kinds. Half of the targets are
like those above, the others lighter and far more frequent: some hundreds of them remain near 83°
and 960 km. A chaser is launched onto a target of its choice, with a kit for each object that it
goes to, which stays there and takes it down.

Electric chasers in the same fields tow each object down by a spiral. Three of them are launched at
the start, each onto a target of its choice. With thrust of 0.4 N each goes from object to object,
takes it down to a disposal orbit of 500 km, leaves it there and climbs to the next one.
"""

from __future__ import annotations

from ...common.constants import DAY_S
from ...problem.chasers import Chaser, TankByMass
from ...problem.orbit import Orbit
from ...problem.settings import TransferSettings
from .stream import Uniform, draw_ellipse

TARGETS = 20

ALTITUDE_KM = (830.0, 850.0)
INCLINATION_DEG = (70.9, 71.1)
ECCENTRICITY = (0.0, 0.004)
RAAN_DEG = (0.0, 360.0)


def draw_rocket_body(uniform: Uniform) -> Orbit:
    """A target, uniform in all elements."""
    return draw_ellipse(uniform, ALTITUDE_KM, INCLINATION_DEG, ECCENTRICITY, RAAN_DEG)


def draw_start(uniform: Uniform) -> Orbit:
    """Start of the chaser: a circular orbit of the same kind."""
    return draw_rocket_body(uniform).replace(eccentricity=0.0)


REMOVAL_TARGETS, REMOVAL_CHASERS = 60, 4

DURATION_S = 1826.0 * DAY_S
APART_S = 365.0 * DAY_S
"""Interval between launches [s]."""

LIGHTER_ALTITUDE_KM = (930.0, 990.0)
LIGHTER_INCLINATION_DEG = (82.9, 83.0)
LIGHTER_ECCENTRICITY = (0.0, 0.004)

HEAVY_KG, LIGHT_KG = 9000.0, 1400.0
"""Masses of the two kinds [kg]."""

REMOVAL_TANK = TankByMass(dry_mass_kg=500.0, propellant_kg=100.0, isp_s=300.0)
KITS, KIT_MASS_KG = 8, 40.0


def draw_removal_target(uniform: Uniform) -> Orbit:
    """A target of either kind."""
    if uniform(0.0, 1.0) < 0.5:
        return draw_rocket_body(uniform)
    return draw_ellipse(
        uniform, LIGHTER_ALTITUDE_KM, LIGHTER_INCLINATION_DEG, LIGHTER_ECCENTRICITY, RAAN_DEG
    )


def mass_kg(orbit: Orbit) -> float:
    """Mass of the target in an orbit."""
    return LIGHT_KG if orbit.inclination_deg > 77.0 else HEAVY_KG


def removal_chaser(number: int) -> Chaser:
    """The chaser with a number from 0, launched a year after its predecessor."""
    return Chaser(
        name=f"chaser-{number + 1}",
        start="anywhere",
        available_s=(APART_S * number, None),
        tank=REMOVAL_TANK,
        kits=KITS,
        kit_mass_kg=KIT_MASS_KG,
    )


ELECTRIC_CHASERS = 3

ELECTRIC_SERVICE_S = 10.0 * DAY_S
"""Time to approach and capture an object [s]."""

DISPOSAL_ALTITUDE_M = 500e3

THRUST_N = 0.4
ELECTRIC_TANK = TankByMass(dry_mass_kg=600.0, propellant_kg=300.0, isp_s=1800.0)

ELECTRIC_TRANSFER = TransferSettings(
    departure_spacing_s=8.0 * DAY_S,
    drift_step_s=20.0 * DAY_S,
    max_drift_s=360.0 * DAY_S,
    delta_v_resolution_m_s=20.0,
)
"""Coarse grid, as legs take weeks and the longest a year: a finer one would save little."""


def electric_chaser(number: int) -> Chaser:
    """The chaser with a number from 0."""
    return Chaser(
        name=f"chaser-{number + 1}", start="anywhere", tank=ELECTRIC_TANK, thrust_n=THRUST_N
    )
