"""The estimate with a phase: what a leg costs that must also meet the debris on its orbit.

The closed form has no phase. On a drift orbit that is b_y higher [m/s] a chaser falls behind by
3 b_y T / a, so with a time of flight T only those b_y lead to the debris that lie on a comb of
teeth 2π a / 3T apart: 7 m/s in 25 d, where it hardly matters, and 170 m/s in a day, where it is
everything. The dearest part of short legs is hidden there, and a shift of some hours avoids it.

Where the comb lies follows from the mean longitudes of both debris. A chaser's mean semi-major axis
differs from the osculating one of its debris by ¾ J2 (R/a)² · 2a sin² i cos 2u (Y. Kozai,
Astronomical Journal 64, 1959, 367–377), and its mean motion by the secular terms of J2. What this
leaves out, a tenth of a turn in some days, is for the flight.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from adr_opt.common.constants import DAY_S, MU_M3_S2, OBLATENESS_M2
from adr_opt.kernels.core.compile import kernel
from adr_opt.kernels.legs import drift_linear as drift
from adr_opt.kernels.orbits import ephemeris

from .ephemeris import Debris


class Latitude(NamedTuple):
    """Mean arguments of latitude [rad], of a debris and of a chaser that leaves it.

    Attributes
    ----------
    begin, rate : float
        Of the debris at MJD2000 0, and how fast it grows [rad], [rad/s].
    axis, swing : float
        Semi-major axis, and how much the mean one of a chaser that leaves at the node is less [m].
    more : float
        Secular rate of a chaser besides its mean motion [rad/s].
    """

    begin: float
    rate: float
    axis: float
    swing: float
    more: float


def latitude_of(debris: Debris) -> Latitude:
    """Mean arguments of latitude of a debris object and of a chaser leaving it."""
    axis, gone = debris.axis, debris.epoch_d * DAY_S
    motion = math.sqrt(MU_M3_S2 / axis**3)
    _, perigee, anomaly = ephemeris.secular_rates(
        axis, debris.eccentricity, debris.inclination, OBLATENESS_M2
    )
    rate = motion + perigee
    swing = 1.5 * OBLATENESS_M2 / axis * math.sin(debris.inclination) ** 2
    begin = debris.perigee + debris.anomaly - rate * gone
    return Latitude(begin, rate, axis, swing, perigee + anomaly - motion)


@kernel
def phased_cost(pair, one, other, departure, arrival):
    """ΔV of the best leg that meets the debris [m/s].

    Parameters
    ----------
    pair : LinearPair
    one, other : Latitude
        Of the debris that is left, and of that to be met.
    departure, arrival : float
        Since MJD2000 0 [s].
    """
    span = arrival - departure
    node, shape = drift.node_left(pair, arrival), drift.shape_left(pair, arrival)
    best = drift.climb_of(pair, span, node)
    begin = one.begin + one.rate * departure
    axis = one.axis - one.swing * math.cos(2.0 * begin)
    rate = math.sqrt(MU_M3_S2 / axis**3) + one.more
    ahead = begin + rate * span - other.begin - other.rate * arrival
    # Half a revolution at either end goes by before the impulses are made.
    room = span - 2.0 * math.pi / one.rate
    if room <= 0.0:
        return np.inf
    tooth = 2.0 * math.pi * one.axis / (3.0 * room)
    first = ahead / (2.0 * math.pi) * tooth
    low = first + math.floor((best - first) / tooth) * tooth
    cost = np.inf
    for climb in (low, low + tooth):
        if pair.least_climb <= climb <= pair.most_climb:
            cost = min(cost, drift.cost_of(pair, span, node, shape, climb))
    return cost


@kernel
def phased_costs(pair, one, other, first, arrivals, spans, step, cost):
    """The same of a pair by arrival and span, on a grid, as :func:`.estimate.pair_costs`."""
    for a in range(arrivals):
        arrival = first + a * step
        for s in range(1, spans + 1):
            cost[a, s - 1] = phased_cost(pair, one, other, arrival - s * step, arrival)
