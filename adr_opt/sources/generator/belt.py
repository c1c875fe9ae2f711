"""Fields in a narrow band: circles of the published study, and debris near sun-synchronous orbits.

The spread of the planes and of the phases of the first is a *calibration*: the published study does
not state it. It was chosen so that the published greedy planner gives the published numbers; others
do not (docs/model.md section 7).

The second (``SSO_…``) is a band of near-sun-synchronous orbits, with a station at its centre.
Sun-synchronous satellites are launched into few local times, those that suit their cameras, and
what remains of them begins in such a band: the field is one, two hours of local time to either side
of a station, which is what one station may serve. Altitude and inclination are independent and
uniform. That makes few of the orbits sun-synchronous: their nodes drift by 35° a year against each
other in the median, and while the mission lasts the band dissolves. Eccentricities are small, as
they are in catalogues above 600 km.
"""

from __future__ import annotations

from ...common.constants import EARTH_RADIUS_M
from ...problem.orbit import Orbit
from .stream import Uniform, draw_ellipse, rounded

ALTITUDE_KM = (700.0, 800.0)
INCLINATION_DEG = (95.0, 97.0)
RAAN_DEG = (-1.0, 1.0)
STATION_ALTITUDE_KM = 700.0
STATION_INCLINATION_DEG = 96.0


def circle(altitude_km: float, inclination_deg: float, raan_deg: float, u_deg: float) -> Orbit:
    """A circular orbit, rounded to the digits of the file."""
    return rounded(EARTH_RADIUS_M + 1e3 * altitude_km, 0.0, inclination_deg, raan_deg, 0.0, u_deg)


def draw_circle(uniform: Uniform) -> Orbit:
    """A target of the belt, uniform in all elements."""
    return circle(
        uniform(*ALTITUDE_KM), uniform(*INCLINATION_DEG), uniform(*RAAN_DEG), uniform(0.0, 360.0)
    )


STATION = circle(STATION_ALTITUDE_KM, STATION_INCLINATION_DEG, 0.0, 0.0)


SSO_TARGETS = 60

SSO_ALTITUDE_KM = (600.0, 900.0)
SSO_INCLINATION_DEG = (97.0, 99.5)
SSO_ECCENTRICITY = (0.0, 0.004)
SSO_RAAN_DEG = (-30.0, 30.0)

SSO_STATION = circle(750.0, 98.25, 0.0, 0.0)
"""Station at the centre of all three ranges."""


def draw_debris(uniform: Uniform) -> Orbit:
    """A target, uniform in all elements."""
    return draw_ellipse(
        uniform, SSO_ALTITUDE_KM, SSO_INCLINATION_DEG, SSO_ECCENTRICITY, SSO_RAAN_DEG
    )
