"""Debris in a band of near-sun-synchronous orbits, with a station at its centre.

Sun-synchronous satellites are launched into few local times, those that suit their cameras, and
what remains of them begins in such a band: the field is one, two hours of local time to either side
of a station, which is what one station may serve. Altitude and inclination are independent and
uniform. That makes few of the orbits sun-synchronous: their nodes drift by 35° a year against each
other in the median, and while the mission lasts the band dissolves.

Eccentricities are small, as they are in catalogues above 600 km.
"""

from __future__ import annotations

from ...problem.orbit import Orbit
from .belt import circle
from .ellipse import draw_ellipse
from .stream import Uniform

TARGETS = 60

ALTITUDE_KM = (600.0, 900.0)
INCLINATION_DEG = (97.0, 99.5)
ECCENTRICITY = (0.0, 0.004)
RAAN_DEG = (-30.0, 30.0)

STATION = circle(750.0, 98.25, 0.0, 0.0)
"""Station at the centre of all three ranges."""


def draw_debris(uniform: Uniform) -> Orbit:
    """A target, uniform in all elements."""
    return draw_ellipse(uniform, ALTITUDE_KM, INCLINATION_DEG, ECCENTRICITY, RAAN_DEG)
