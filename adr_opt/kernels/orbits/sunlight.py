"""Sunlight on a circular orbit: the direction of the Sun, and the Earth's shadow.

The Sun's longitude is that of the low-precision formulas of the Astronomical Almanac (page C5),
good to 0.01° until 2050. The shadow is a cylinder.
"""

import math
from typing import NamedTuple

import numpy as np

from ...common.constants import DAY_S, EARTH_RADIUS_M
from ..core.compile import inlined, kernel

OBLIQUITY_RAD = math.radians(23.439)

LONGITUDE_RAD, LONGITUDE_RATE_RAD_S = math.radians(280.460), math.radians(0.9856474) / DAY_S
"""Mean longitude of the Sun at J2000, with aberration, and its rate."""

ANOMALY_RAD, ANOMALY_RATE_RAD_S = math.radians(357.528), math.radians(0.9856003) / DAY_S
"""Mean anomaly of the Sun at J2000, and its rate."""

CENTRE_RAD, CENTRE_TWICE_RAD = math.radians(1.915), math.radians(0.020)
"""Amplitudes of the equation of the centre."""


class Shadow(NamedTuple):
    """The part of a circular orbit in the Earth's shadow.

    Attributes
    ----------
    middle : float
        Argument of latitude [rad].
    half : float
        Half of its width, 0 for none [rad].
    """

    middle: float
    half: float


@inlined
def sun_direction(since_j2000):
    """Unit vector to the Sun in the frame of the Earth's equator, at seconds since J2000."""
    anomaly = ANOMALY_RAD + ANOMALY_RATE_RAD_S * since_j2000
    longitude = LONGITUDE_RAD + LONGITUDE_RATE_RAD_S * since_j2000
    longitude += CENTRE_RAD * math.sin(anomaly) + CENTRE_TWICE_RAD * math.sin(2.0 * anomaly)
    sine = math.sin(longitude)
    return (math.cos(longitude), math.cos(OBLIQUITY_RAD) * sine, math.sin(OBLIQUITY_RAD) * sine)


@kernel
def sun_directions(since_j2000):
    """Unit vectors to the Sun at some times, shape (times, 3); see :func:`sun_direction`."""
    found = np.empty((since_j2000.size, 3))
    for row, time in enumerate(since_j2000):
        found[row] = sun_direction(time)
    return found


@inlined
def shadow(radius, inclination, node, since_j2000):
    """The shadow on a circular orbit at a time.

    Parameters
    ----------
    radius : float
        [m].
    inclination, node : float
        [rad].
    since_j2000 : float
        [s].

    Returns
    -------
    Shadow
    """
    x, y, z = sun_direction(since_j2000)
    along = x * math.cos(node) + y * math.sin(node)
    across = (y * math.cos(node) - x * math.sin(node)) * math.cos(inclination)
    across += z * math.sin(inclination)
    # In the shadow the way to the Sun's side is longer than the horizon: cos of the angle from the
    # anti-solar point over that of the Sun's height above the plane.
    in_plane = math.sqrt(along * along + across * across)
    horizon = math.sqrt(max(1.0 - (EARTH_RADIUS_M / radius) ** 2, 0.0))
    half = math.acos(horizon / in_plane) if in_plane > horizon else 0.0
    return Shadow(math.atan2(-across, -along), half)
