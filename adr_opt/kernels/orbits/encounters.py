"""Rates at which orbits with random nodes and perigees meet (docs/worth.md, equations 1 to 3).

The spatial densities of two objects, integrated over the region that both cross (E. J. Öpik,
Proceedings of the Royal Irish Academy 54A, 1951; D. J. Kessler, Icarus 48, 1981), in closed form
with two complete elliptic integrals.
"""

import math

from ...common.constants import MU_M3_S2
from ..core.compile import inlined, kernel

LEAST_WIDTH_M = 5000.0
"""Least width of a shell, from perigee to apogee [m]. Short-period motion is wider."""

BLUR_M = 1000.0
"""Width over which each perigee and apogee is spread evenly [m]."""

LEAST_PART = 1e-12
"""Least complementary parameter of K for two inclinations, which is 0 for two polar orbits."""

CLOSE = 1e-9
"""Relative distance of the two means at which the arithmetic-geometric mean is reached."""


@inlined
def quarter_period(part):
    """Complete elliptic integral of the first kind, K(m), from the complement 1 − m.

    By the arithmetic-geometric mean; the part itself keeps the digits that m loses near 1.
    """
    one, other = 1.0, math.sqrt(part)
    while one - other > CLOSE * one:
        one, other = 0.5 * (one + other), math.sqrt(one * other)
    return math.pi / (one + other)


@inlined
def _integral(distance):
    """Second integral of the logarithm of a distance [m²]."""
    return 0.0 if distance == 0.0 else distance**2 * (0.5 * math.log(abs(distance)) - 0.75)


@kernel
def blurred(distance):
    """Distance of two perigees, each spread over :data:`BLUR_M`, in the mean of its logarithm [m].

    K grows with the logarithm where two perigees or apogees agree, and is finite in the mean.
    """
    if distance > 4.0 * BLUR_M:
        return distance
    above, below = _integral(distance + BLUR_M), _integral(distance - BLUR_M)
    return math.exp((above - 2.0 * _integral(distance) + below) / BLUR_M**2)


@kernel
def shell_factor(perigee, apogee, other_perigee, other_apogee):
    """Equation 2: chance density that both objects are at one radius, and the middle radius.

    Parameters
    ----------
    perigee, apogee, other_perigee, other_apogee : float
        Radii [m], each shell at least :data:`LEAST_WIDTH_M` wide.

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
    above, below = blurred(highest - second), blurred(third - lowest)
    product = (highest - third) * (second - lowest)
    part = min(above * below / product, 1.0)
    factor = 2.0 * quarter_period(part) / (math.pi**2 * math.sqrt(product))
    return factor, 0.5 * (second + third)


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


@inlined
def between(table, row, column):
    """Value of a table at a fractional row and column, linear between entries."""
    row = min(max(row, 0.0), table.shape[0] - 1.0)
    column = min(max(column, 0.0), table.shape[1] - 1.0)
    i, j = min(int(row), table.shape[0] - 2), min(int(column), table.shape[1] - 2)
    down, right = row - i, column - j
    upper = table[i, j] * (1.0 - right) + table[i, j + 1] * right
    lower = table[i + 1, j] * (1.0 - right) + table[i + 1, j + 1] * right
    return upper * (1.0 - down) + lower * down


@inlined
def _squares(perigee, apogee, radius):
    """Squared speed and squared speed across the radius at a radius [m²/s²]."""
    squared = MU_M3_S2 * (2.0 / radius - 2.0 / (perigee + apogee))
    return squared, MU_M3_S2 * 2.0 * perigee * apogee / ((perigee + apogee) * radius**2)


@kernel
def encounter_rate(shells, tilts, widths, speeds, i, j):
    """Equation 1: rate at which two objects come closer than the sum of their radii.

    Parameters
    ----------
    shells : (object, 2) float64
        Radii of perigee and apogee [m].
    tilts, widths : (object,) float64
        Inclinations [rad], radii of the objects [m].
    speeds : (tilt, tilt) float64
        Mean relative speed of encounters of circles over the speed of both, by inclinations from 0°
        to 180°.
    i, j : int

    Returns
    -------
    rate : float
        [1/s].
    radius : float
        Middle of the radii at which they meet; 0 where their shells do not [m].
    speed : float
        Mean relative speed of encounters [m/s].
    """
    factor, radius = shell_factor(shells[i, 0], shells[i, 1], shells[j, 0], shells[j, 1])
    if factor == 0.0:
        return 0.0, 0.0, 0.0
    step = math.pi / (speeds.shape[0] - 1)
    relative = between(speeds, tilts[i] / step, tilts[j] / step)
    squared, across = _squares(shells[i, 0], shells[i, 1], radius)
    other_squared, other_across = _squares(shells[j, 0], shells[j, 1], radius)
    both = math.sqrt(across * other_across)
    # Motion along the radius and unequal speeds add to the relative speed of circles.
    added = max(squared + other_squared - 2.0 * both, 0.0)
    speed = math.sqrt(both * relative**2 + added)
    axes = 0.25 * (shells[i, 0] + shells[i, 1]) * (shells[j, 0] + shells[j, 1])
    wide = (widths[i] + widths[j]) ** 2 / math.pi**2
    rate = wide * speed / (relative * axes) * factor * tilt_factor(tilts[i], tilts[j])
    return rate, radius, speed
