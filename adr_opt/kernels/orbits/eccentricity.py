"""Cost of eccentric ends for a sequence flown between circles (docs/model.md).

The circles leave out the eccentricity vectors, which differ by Δe. Burns that are flown for other
reasons change them on the way, at no cost as long as there are enough of them; but to change them
and turn the plane takes about hypot(v |Δe| / 2, 2 v sin θ/2). So a sequence costs that where it is
more than what it costs between circles.

Δe is the difference once one plane is turned into the other about their line of nodes, and v the
geometric mean of the two circular speeds. Where nothing drifts v |Δe| / 2 is a number of the pair;
where perigees do, it depends on the time.
"""

import math

import numpy as np

from ...common.constants import MU_M3_S2
from ..core.compile import inlined, kernel
from .ephemeris import eccentricity_at, inclination_at, node_at, perigee_at, radius_at


@kernel
def chord(eccentricity_i, eccentricity_j, angle):
    """|e_j e^{iω_j} − e_i e^{iω_i}| for perigees an angle apart, computed without cancellation."""
    between = 4.0 * eccentricity_i * eccentricity_j * math.sin(0.5 * angle) ** 2
    return math.sqrt((eccentricity_j - eccentricity_i) ** 2 + between)


@inlined
def along_turn(inclination_i, inclination_j, lag):
    """α_i − α_j: loss of latitude when a plane is turned about the line of nodes [rad].

    By Napier's analogies in the triangle of the two nodes and the line: unlike the two latitudes of
    the line themselves it is steady where planes nearly coincide.

    Parameters
    ----------
    inclination_i, inclination_j, lag : float
        Of the planes; Ω_j − Ω_i [rad].
    """
    across = math.sin(0.5 * lag) * math.cos(0.5 * (inclination_i + inclination_j))
    return 2.0 * math.atan2(
        across, math.cos(0.5 * lag) * math.cos(0.5 * (inclination_j - inclination_i))
    )


@inlined
def whole(circles, turned, matching):
    """ΔV of a sequence between eccentric ends, without the approach [m/s].

    Parameters
    ----------
    circles : float
        ΔV between circles [m/s].
    turned : float
        4 v₁ v₂ sin²(θ/2) [m²/s²].
    matching : float
        v |Δe| / 2 [m/s]. With 0 nothing but the sequence between circles counts, to the last digit.
    """
    return max(circles, math.sqrt(matching * matching + turned))


@inlined
def alone(speed, eccentricity_i, eccentricity_j, perigee_lag, inclination_i, inclination_j, lag):
    """Half of v |Δe| for given differences of ω and Ω at a time [m/s]."""
    angle = perigee_lag + along_turn(inclination_i, inclination_j, lag)
    return 0.5 * speed * chord(eccentricity_i, eccentricity_j, angle)


@inlined
def matching(pair, time):
    """Cost of matching eccentricity alone when a sequence leaves, v |Δe| / 2 [m/s]."""
    if pair.eccentricity_i == 0.0 and pair.eccentricity_j == 0.0:
        return pair.matching
    return alone(
        math.sqrt(pair.speed_i * pair.speed_j),
        pair.eccentricity_i,
        pair.eccentricity_j,
        pair.perigee_lag + pair.perigee_lag_rate * time,
        pair.inclination_i,
        pair.inclination_j,
        pair.lag + pair.lag_rate * time,
    )


@kernel
def matchings(bodies, time):
    """Cost of matching alone between any two bodies at a time, v |Δe| / 2 [m/s].

    Parameters
    ----------
    bodies : (bodies, columns) float64
        Rows of :data:`.columns.ORBIT_COLUMNS`.
    time : float
        [s].

    Returns
    -------
    (origin, destination) float64
    """
    count = bodies.shape[0]
    costs = np.zeros((count, count))
    for i in range(count):
        for j in range(i):
            one, other = bodies[i], bodies[j]
            costs[i, j] = costs[j, i] = alone(
                math.sqrt(MU_M3_S2 / math.sqrt(radius_at(one, time) * radius_at(other, time))),
                eccentricity_at(one, time),
                eccentricity_at(other, time),
                perigee_at(other, time) - perigee_at(one, time),
                inclination_at(one, time),
                inclination_at(other, time),
                node_at(other, time) - node_at(one, time),
            )
    return costs
