"""A fragmentation cloud: remnants of a collision near 86.4° and 780 km after sixteen years.

Drawn, not copied: no object of a catalogue is in it. The numbers below were fitted to a public
catalogue of April 2025, its 121 objects of the satellite Iridium 33, which collided in 2009
(`bench/worth.py cloud` prints them from such a file).

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
"""

from __future__ import annotations

from ...common.constants import EARTH_RADIUS_M
from ...problem.orbit import Orbit
from .belt import circle
from .ellipse import rounded
from .stream import Uniform, at_percentile

TARGETS = 50

PERCENTILES = (0.0, 5.0, 10.0, 25.0, 50.0, 75.0, 90.0, 95.0, 100.0)
PERIGEE_KM = (437.9, 541.8, 583.7, 639.9, 696.8, 728.3, 747.5, 756.9, 770.9)
APOGEE_MINUS_PERIGEE_KM = (1.6, 7.9, 10.0, 16.9, 26.1, 53.0, 146.1, 232.9, 342.9)
INCLINATION_DEG = (85.960, 86.195, 86.241, 86.306, 86.344, 86.380, 86.393, 86.407, 86.474)
HALF_WIDTH_DEG = 23.4
INCLINATION_WITH_DIFFERENCE = -0.32
RAAN_WITH_INCLINATION = 0.28

STATION_ALTITUDE_KM = 720.0
STATION_INCLINATION_DEG = 86.344
STATION = circle(STATION_ALTITUDE_KM, STATION_INCLINATION_DEG, 0.0, 0.0)
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
    """Another element's share with a probability, else an independent one."""
    own, chance = uniform(0.0, 1.0), uniform(0.0, 1.0)
    return other if chance < probability else own
