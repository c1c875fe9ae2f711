"""Rocket bodies: heavy upper stages of one launcher in orbits that differ mainly by their nodes.

Near 71° and 840 km some twenty upper stages of one kind remain, the objects that lists of what to
remove first begin with. Altitudes, inclinations and eccentricities are drawn from limits like
theirs; no object of a catalogue is in it. Their nodes go all around, and a degree of node costs
123 m/s: hardly any two can be visited one after the other without waiting until their planes meet.

There is no refuelling: the chaser is launched into a circle of the same kind, without a station.
"""

from __future__ import annotations

from ...problem.orbit import Orbit
from .ellipse import draw_ellipse
from .stream import Uniform

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
