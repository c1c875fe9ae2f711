"""Cost of matching eccentricity vectors alone, for all pairs of bodies."""

import math

import numpy as np

from ...common.constants import MU_M3_S2
from ..core.compile import kernel
from .eccentricity import alone
from .ephemeris import eccentricity_at, inclination_at, node_at, perigee_at, radius_at


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
