"""Field of the published study: circular orbits in a narrow belt of altitudes and planes.

The spread of the planes and of the phases is a *calibration*: the published study does not state
it. It was chosen so that the published greedy planner gives the published numbers; others do not
(docs/model.md section 7).
"""

from __future__ import annotations

from ...common.constants import EARTH_RADIUS_M
from ...problem.orbit import Orbit
from .ellipse import rounded
from .stream import Uniform

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
