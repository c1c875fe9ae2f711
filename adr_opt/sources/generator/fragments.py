"""A large old fragmentation cloud: thousands of pieces with planes all around the Earth.

Drawn, not fitted: the numbers are round ones of the kind that is known of what the destruction of
the satellite Fengyun 1C in 2007, near 865 km and 98.6°, has left after most of twenty years. Its
planes have spread over all nodes, because pieces thrown into higher or lower orbits drift
otherwise; perigees lie below the height of the event and apogees above it, as every orbit led
through it once; what was thrown lowest has come down.

* Perigee and apogee altitude are independent: the one 600 to 860 km, denser towards the event, the
  other 860 to 1,500 km, likewise.
* Inclination is that of the event with a triangular spread of ±0.7°.
* Node, argument of perigee and anomaly are uniform.
"""

from __future__ import annotations

from ...common.constants import EARTH_RADIUS_M, HOUR_S
from ...problem.orbit import Orbit
from ...problem.settings import TransferSettings
from .belt import circle
from .ellipse import rounded
from .stream import Uniform

TARGETS = 1900

EVENT_KM = 865.0
LOWEST_KM, HIGHEST_KM = 600.0, 1500.0
INCLINATION_DEG, SPREAD_DEG = 98.6, 0.7

STATION = circle(EVENT_KM, INCLINATION_DEG, 0.0, 0.0)
"""Station on the orbit of the destroyed satellite."""

TRANSFER = TransferSettings().replace(departure_spacing_s=2.0 * HOUR_S, delta_v_resolution_m_s=0.5)
"""Two months are too short for planes to drift together, and with thousands of pieces no wait for
one pays: no long transfers."""


def draw_piece(uniform: Uniform) -> Orbit:
    """A target of the cloud."""
    perigee_km = EVENT_KM - (EVENT_KM - LOWEST_KM) * min(uniform(0.0, 1.0), uniform(0.0, 1.0))
    apogee_km = EVENT_KM + (HIGHEST_KM - EVENT_KM) * min(uniform(0.0, 1.0), uniform(0.0, 1.0))
    tilt_deg = SPREAD_DEG * (uniform(0.0, 1.0) + uniform(0.0, 1.0) - 1.0)
    semi_major_axis_m = EARTH_RADIUS_M + 500.0 * (perigee_km + apogee_km)
    return rounded(
        semi_major_axis_m,
        500.0 * (apogee_km - perigee_km) / semi_major_axis_m,
        INCLINATION_DEG + tilt_deg,
        uniform(0.0, 360.0),
        uniform(0.0, 360.0),
        uniform(0.0, 360.0),
    )
