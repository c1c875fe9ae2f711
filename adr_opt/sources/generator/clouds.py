"""Two fragmentation clouds, one young and one large and old; drawn, not copied.

The first has the remnants of a collision near 86.4° and 780 km after sixteen years; no object of a
catalogue is in it. Its numbers were fitted to a public catalogue of April 2025, its 121 objects of
the satellite Iridium 33, which collided in 2009 (`bench/worth.py cloud` prints them from such a
file).

* Perigee altitude, apogee minus perigee altitude, and inclination follow their percentiles,
  linear in between. Perigee and difference are independent (rank correlation −0.04 in the
  catalogue); the more eccentric orbits are less inclined (−0.32), and planes further east more
  inclined (0.28 among the objects nearest to the densest plane).
* A rank correlation of c is drawn by sharing: with probability |c| two quantities take the same
  share of their populations (opposite shares for c < 0), else independent ones. That gives
  Spearman's correlation exactly and leaves each distribution as it is.
* The catalogue's planes go all the way round. A degree of plane costs 130 m/s, too much to
  visit all in one mission: the field is the densest part, as wide as the 50 objects nearest to
  the densest plane, which lie within 23.4° of it. RAAN is drawn uniform there, and counted from
  that plane, in which the station is.
* Argument of perigee and true anomaly are uniform. (Mean anomaly would be right; at these
  eccentricities the two differ by 3° at most.)

The second has thousands of pieces with planes all around the Earth: round numbers of the kind that
is known of what the destruction of the satellite Fengyun 1C in 2007, near 865 km and 98.6°, has
left after most of twenty years. Its planes have spread over all nodes, because pieces thrown into
higher or lower orbits drift otherwise; perigees lie below the height of the event and apogees above
it, as every orbit led through it once; what was thrown lowest has come down.

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
from .stream import Uniform, at_percentile, rounded

CLOUD_TARGETS = 50

PERCENTILES = (0.0, 5.0, 10.0, 25.0, 50.0, 75.0, 90.0, 95.0, 100.0)
PERIGEE_KM = (437.9, 541.8, 583.7, 639.9, 696.8, 728.3, 747.5, 756.9, 770.9)
APOGEE_MINUS_PERIGEE_KM = (1.6, 7.9, 10.0, 16.9, 26.1, 53.0, 146.1, 232.9, 342.9)
INCLINATION_DEG = (85.960, 86.195, 86.241, 86.306, 86.344, 86.380, 86.393, 86.407, 86.474)
HALF_WIDTH_DEG = 23.4
INCLINATION_WITH_DIFFERENCE = -0.32
RAAN_WITH_INCLINATION = 0.28

STATION_ALTITUDE_KM = 720.0
STATION_INCLINATION_DEG = 86.344
CLOUD_STATION = circle(STATION_ALTITUDE_KM, STATION_INCLINATION_DEG, 0.0, 0.0)
"""Station in the densest plane, near the cloud's median altitude and at its median inclination."""


def draw_fragment(uniform: Uniform) -> Orbit:
    """A target of the cloud."""
    perigee_share, difference_share = uniform(0.0, 1.0), uniform(0.0, 1.0)
    inclination_share = _correlated(uniform, 1.0 - difference_share, -INCLINATION_WITH_DIFFERENCE)
    raan_share = _correlated(uniform, inclination_share, RAAN_WITH_INCLINATION)
    perigee_km = at_percentile(PERCENTILES, PERIGEE_KM, perigee_share)
    difference_km = at_percentile(PERCENTILES, APOGEE_MINUS_PERIGEE_KM, difference_share)
    semi_major_axis_m = EARTH_RADIUS_M + 1e3 * (perigee_km + 0.5 * difference_km)
    return rounded(
        semi_major_axis_m,
        0.5e3 * difference_km / semi_major_axis_m,
        at_percentile(PERCENTILES, INCLINATION_DEG, inclination_share),
        HALF_WIDTH_DEG * (2.0 * raan_share - 1.0),
        uniform(0.0, 360.0),
        uniform(0.0, 360.0),
    )


def _correlated(uniform: Uniform, other: float, probability: float) -> float:
    """Another element's quantile with some probability, else an independent one."""
    own, chance = uniform(0.0, 1.0), uniform(0.0, 1.0)
    return other if chance < probability else own


FRAGMENTS_TARGETS = 1900

EVENT_KM = 865.0
LOWEST_KM, HIGHEST_KM = 600.0, 1500.0
FRAGMENTS_INCLINATION_DEG, SPREAD_DEG = 98.6, 0.7

FRAGMENTS_STATION = circle(EVENT_KM, FRAGMENTS_INCLINATION_DEG, 0.0, 0.0)
"""Station on the orbit of the destroyed satellite."""

FRAGMENTS_TRANSFER = TransferSettings().replace(
    departure_spacing_s=2.0 * HOUR_S, delta_v_resolution_m_s=0.5
)
"""Without long transfers: two months are too short for planes to drift together, and among
thousands of pieces waiting for one never pays."""


def draw_piece(uniform: Uniform) -> Orbit:
    """A target of the cloud."""
    perigee_km = EVENT_KM - (EVENT_KM - LOWEST_KM) * min(uniform(0.0, 1.0), uniform(0.0, 1.0))
    apogee_km = EVENT_KM + (HIGHEST_KM - EVENT_KM) * min(uniform(0.0, 1.0), uniform(0.0, 1.0))
    tilt_deg = SPREAD_DEG * (uniform(0.0, 1.0) + uniform(0.0, 1.0) - 1.0)
    semi_major_axis_m = EARTH_RADIUS_M + 500.0 * (perigee_km + apogee_km)
    return rounded(
        semi_major_axis_m,
        500.0 * (apogee_km - perigee_km) / semi_major_axis_m,
        FRAGMENTS_INCLINATION_DEG + tilt_deg,
        uniform(0.0, 360.0),
        uniform(0.0, 360.0),
        uniform(0.0, 360.0),
    )
