"""Price of a leg with free place and direction of each impulse (docs/model.md section 2.7).

To first order the changes that a leg makes within a plane are linear in its impulses. Their least
sum is the most that a linear function of the changes can be whose *primer*, what a unit impulse
adds to it, is nowhere longer than 1 on the way: so each such function, a *dual vector*, bounds it.
Two for each number of revolutions are taken here, chosen for how near they come (``python
bench/legs.py dual-vectors``), with the trivial ones |c|/2 and |Δe|/2.

With L = (2k + 3) π swept from the departure on the line of nodes, the changes are c of the
semi-major axis, as a share; the *swing* d = 2A − c, A being its mean offset on the way, which the
time of flight alone tells; and the components of Δe along and across the line.
"""

import math
from typing import NamedTuple

import numpy as np

from ...common.constants import MU_M3_S2
from ..core.compile import inlined
from ..orbits import eccentricity

MARGIN = 1.02
"""Ratio of the price to the closed-form minimum, so that plans hold when they are flown."""

ROOT_3 = math.sqrt(3.0)

DUALS = np.array(
    [
        [[-0.116117, 0.450056, -0.119470, 0.313029], [-0.013419, 0.689870, -0.216437, 0.018977]],
        [[-0.008381, 0.598471, -0.110083, 0.011853], [-0.074431, 0.475659, -0.070860, 0.192116]],
        [[-0.005676, 0.567391, -0.074547, 0.008027], [0.058867, 0.452670, -0.025475, -0.169389]],
        [[0.004288, 0.551192, -0.056326, -0.006065], [0.042974, 0.488616, -0.037382, -0.105654]],
        [[-0.009110, 0.537545, -0.047431, 0.014123], [0.042348, 0.442275, 0.008272, -0.133833]],
        [[-0.004738, 0.533412, -0.038595, 0.007266], [0.033452, 0.475247, -0.012440, -0.091022]],
        [[-0.006552, 0.527157, -0.034111, 0.010157], [-0.029283, 0.477725, -0.009910, 0.080505]],
        [[-0.025916, 0.481479, -0.009637, 0.070518], [-0.003567, 0.525241, -0.029062, 0.005471]],
        [[-0.005115, 0.521268, -0.026629, 0.007929], [-0.020723, 0.495413, -0.017442, 0.050077]],
        [[-0.004609, 0.519187, -0.023996, 0.007145], [0.025188, 0.446488, 0.025437, -0.089221]],
        [[-0.002603, 0.518455, -0.021203, 0.003991], [-0.017152, 0.496389, -0.014437, 0.041450]],
        [[-0.020052, 0.474280, 0.004174, 0.061088], [0.003848, 0.516041, -0.020035, -0.005966]],
        [[0.016621, 0.488070, -0.005625, -0.045694], [-0.002205, 0.515636, -0.017963, 0.003382]],
    ]
)
"""Dual vectors by number of revolutions: weights of c, d, and of Δe along and across the line. With
y also (±y₀, y₁, y₂, ±y₃) and −y are dual vectors, as the way may be flown backwards."""

MOST_REVOLUTIONS = DUALS.shape[0] - 1
"""Largest k with dual vectors."""


class Faces(NamedTuple):
    """The two dual vectors of a number of revolutions."""

    climb_1: float
    swing_1: float
    along_1: float
    across_1: float
    climb_2: float
    swing_2: float
    along_2: float
    across_2: float


@inlined
def faces_of(revolutions):
    """The dual vectors of a number of revolutions."""
    one, other = DUALS[revolutions, 0], DUALS[revolutions, 1]
    return Faces(one[0], one[1], one[2], one[3], other[0], other[1], other[2], other[3])


@inlined
def swing(pair, revolutions, time):
    """D of a flight: twice the mean offset of its semi-major axis from the mean of both ends.

    Parameters
    ----------
    pair : adr_opt.kernels.legs.co_elliptic.Pair
    revolutions : int
        k.
    time : float
        From the departure to the stand-off [s].
    """
    rate = (2.0 * revolutions + 3.0) * math.pi / time
    cube = MU_M3_S2 / (rate * rate)
    axis = cube ** (1.0 / 3.0)
    widening = 0.5 * (pair.widening_i + pair.widening_j)
    if widening != 0.0:
        # The pace of latitudes under J2, by fixed point; each step gains three digits.
        for _ in range(5):
            pace = 1.0 + widening / (axis * axis)
            axis = (cube * pace * pace) ** (1.0 / 3.0)
    return 2.0 * (axis / pair.reference - 1.0)


@inlined
def climb(pair):
    """c: the difference of both semi-major axes, as a share of their mean."""
    return (pair.radius_j - pair.radius_i) / pair.reference


@inlined
def turned(along, across, sine, cosine):
    """Components of a vector along and across a direction that is turned by an angle."""
    return along * cosine + across * sine, across * cosine - along * sine


@inlined
def shape(pair, time, latitude):
    """Δe at a time, along and across the direction at a latitude in the plane of the origin.

    Parameters
    ----------
    pair : adr_opt.kernels.legs.co_elliptic.Pair
    time : float
        Of perigees and nodes [s].
    latitude : float
        [rad].

    Returns
    -------
    along, across : float
    """
    perigee_i = pair.perigee_i + pair.perigee_rate_i * time - latitude
    perigee_j = perigee_i + pair.perigee_lag + pair.perigee_lag_rate * time
    perigee_j += eccentricity.along_turn(
        pair.inclination_i, pair.inclination_j, pair.lag + pair.lag_rate * time
    )
    return (
        pair.eccentricity_j * math.cos(perigee_j) - pair.eccentricity_i * math.cos(perigee_i),
        pair.eccentricity_j * math.sin(perigee_j) - pair.eccentricity_i * math.sin(perigee_i),
    )


@inlined
def delta_v(faces, speed, climb, swing, along, across, turn):
    """Price of a leg without its approach [m/s].

    Parameters
    ----------
    faces : Faces
    speed : float
        v [m/s].
    climb, swing, along, across : float
        c, d and Δe.
    turn : float
        4 sin²(θ/2).
    """
    first = abs(faces.swing_1 * swing + faces.along_1 * along)
    first += abs(faces.climb_1 * climb + faces.across_1 * across)
    second = abs(faces.swing_2 * swing + faces.along_2 * along)
    second += abs(faces.climb_2 * climb + faces.across_2 * across)
    square = across * across
    planar = max(0.5 * max(abs(climb), math.sqrt(along * along + square)), max(first, second))
    # Across the line radial parts ride on the turn; where they outgrow it, the turn is taken off
    # the line.
    side, theta = abs(across), math.sqrt(turn)
    apart = 0.5 * (side + ROOT_3 * theta)
    ridden = square + turn if ROOT_3 * side < theta else apart * apart
    share = 0.5 * side / planar if planar > 0.0 else 0.0
    whole = planar * planar + turn + share * (ridden - 0.25 * square - turn)
    return MARGIN * speed * math.sqrt(whole)


@inlined
def floor(speed, climb, difference, turn):
    """Least price of any leg with a given |Δe|, without its approach [m/s]."""
    largest = max(abs(climb), difference)
    return MARGIN * speed * math.sqrt(0.25 * largest * largest + turn)


@inlined
def least(pair, revolutions, time, turn):
    """Least price of a flight wherever the line of nodes lies, without its approach [m/s]."""
    faces, size = faces_of(revolutions), pair.eccentricity_i + pair.eccentricity_j
    swings, climbs = abs(swing(pair, revolutions, time)), abs(climb(pair))
    first = abs(faces.swing_1) * swings + abs(faces.climb_1) * climbs
    first -= size * math.sqrt(faces.along_1 * faces.along_1 + faces.across_1 * faces.across_1)
    second = abs(faces.swing_2) * swings + abs(faces.climb_2) * climbs
    second -= size * math.sqrt(faces.along_2 * faces.along_2 + faces.across_2 * faces.across_2)
    planar = max(0.5 * climbs, max(first, second))
    return MARGIN * pair.free_speed * math.sqrt(planar * planar + turn)
