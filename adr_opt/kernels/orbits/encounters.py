"""Rates at which orbits with random nodes and perigees meet (docs/worth.md, equations 1 to 3).

The spatial densities of two objects, integrated over the region that both cross (E. J. Öpik,
Proceedings of the Royal Irish Academy 54A, 1951; D. J. Kessler, Icarus 48, 1981), in closed form
with two complete elliptic integrals.
"""

import math

from ...common.constants import MU_M3_S2
from ..core.compile import inlined, kernel

SPREAD_M = 2000.0
"""Width over which each perigee and apogee is spread, and least width of a shell [m]. Short-period
motion moves both by more."""

BLUR = math.exp(-1.5)
"""Distance of two perigees spread over a width, in the mean of its logarithm, over that width."""

LEAST_PART = 1e-12
"""Least complementary parameter of K for two inclinations, which is 0 for two polar orbits."""

CLOSE = 1e-9
"""Relative distance of the two means at which the arithmetic-geometric mean is reached."""


@inlined
def quarter_period(part):
    """Complete elliptic integral of the first kind, K(m), of the part 1 − m that m lacks of 1.

    By the arithmetic-geometric mean; the part itself keeps the digits that m loses near 1.
    """
    one, other = 1.0, math.sqrt(part)
    while one - other > CLOSE * one:
        one, other = 0.5 * (one + other), math.sqrt(one * other)
    return math.pi / (one + other)


@kernel
def shell_factor(perigee, apogee, other_perigee, other_apogee):
    """Equation 2: chance density that both objects are at one radius, and the middle radius.

    Parameters
    ----------
    perigee, apogee, other_perigee, other_apogee : float
        Radii [m], each shell at least :data:`SPREAD_M` wide.

    Returns
    -------
    factor : float
        Integral of the product of the densities of both radii [1/m]; 0 where shells do not meet.
    radius : float
        Middle of the radii that both reach [m].
    """
    highest, second = max(apogee, other_apogee), min(apogee, other_apogee)
    third, lowest = max(perigee, other_perigee), min(perigee, other_perigee)
    if second <= third:
        return 0.0, 0.0
    blur = BLUR * SPREAD_M
    above = math.sqrt((highest - second) ** 2 + blur**2)
    below = math.sqrt((third - lowest) ** 2 + blur**2)
    product = (second - third + above) * (second - third + below)
    part = above * below / product
    radius = 0.5 * (second + third)
    return 2.0 * quarter_period(part) / (math.pi**2 * math.sqrt(product)), radius


@kernel
def tilt_factor(tilt, other_tilt):
    """Equation 3: K(k₁²) / cos((i − j)/2), the share of latitudes and of relative velocity.

    Parameters
    ----------
    tilt, other_tilt : float
        Inclinations [rad].
    """
    apart = max(math.cos(0.5 * (tilt - other_tilt)) ** 2, LEAST_PART)
    part = math.cos(0.5 * (tilt + other_tilt)) ** 2 / apart
    return quarter_period(min(max(part, LEAST_PART), 1.0)) / math.sqrt(apart)


@kernel
def encounter_rate(shells, tilts, widths, i, j):
    """Equation 1: rate at which two objects come closer than the sum of their radii [1/s].

    Parameters
    ----------
    shells : (object, 2) float64
        Radii of perigee and apogee [m].
    tilts, widths : (object,) float64
        Inclinations [rad], radii of the objects [m].
    i, j : int

    Returns
    -------
    rate : float
    radius : float
        Middle of the radii at which they meet; 0 where their shells do not [m].
    speed : float
        Geometric mean of both speeds at this radius [m/s].
    """
    factor, radius = shell_factor(shells[i, 0], shells[i, 1], shells[j, 0], shells[j, 1])
    if factor == 0.0:
        return 0.0, 0.0, 0.0
    axis, other_axis = 0.5 * (shells[i, 0] + shells[i, 1]), 0.5 * (shells[j, 0] + shells[j, 1])
    squared = (2.0 / radius - 1.0 / axis) * (2.0 / radius - 1.0 / other_axis)
    speed = math.sqrt(MU_M3_S2 * math.sqrt(squared))
    wide = (widths[i] + widths[j]) ** 2 / math.pi**2
    rate = wide * speed / (axis * other_axis) * factor * tilt_factor(tilts[i], tilts[j])
    return rate, radius, speed
