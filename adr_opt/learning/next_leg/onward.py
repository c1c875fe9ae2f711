"""The legs after the next one: how dear it is to go on from where a leg leads."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from ...common.constants import HOUR_S
from ...kernels.core.compile import kernel
from ...kernels.episodes.outlook import M_S_PER_HOUR
from .choices import Choices
from .near_orbits import OrbitPlaces

FloatArray = npt.NDArray[np.float64]
IntArray = npt.NDArray[np.int64]

LOOKED_AHEAD = 10
"""Number of legs, the cheapest to targets, of which the legs after them are looked at."""

ONWARD = 6
"""Number of nearest open targets to which those lead."""

HOPELESS_H = 50.0
"""Cost of going on where no leg fits, in hours."""

Connecting = Callable[[IntArray, FloatArray, IntArray], tuple[FloatArray, FloatArray]]
"""ΔV [m/s] and arrivals [s] of legs by their origins, ready times [s] and destinations."""


class OnwardLegs(NamedTuple):
    """The cheapest legs after each leg, by hours and ΔV.

    Attributes
    ----------
    known : (legs,) bool
        Of which legs they were looked at.
    cost, next_cost : (legs,) float64
        Of the cheapest, and of the second cheapest [h].
    delta_v : (legs,) float64
        Of the cheapest [m/s].
    """

    known: npt.NDArray[np.bool_]
    cost: FloatArray
    next_cost: FloatArray
    delta_v: FloatArray


def unknown(legs: int) -> OnwardLegs:
    """Nothing known of what follows."""
    return OnwardLegs(np.zeros(legs, dtype=np.bool_), *np.zeros((3, legs)))


def onward(
    choices: Choices,
    places: OrbitPlaces,
    worths: FloatArray,
    end_s: float,
    stations: int,
    connecting: Connecting,
) -> OnwardLegs:
    """Legs after the cheapest legs, computed by a function.

    Parameters
    ----------
    choices : Choices
    places : OrbitPlaces
    worths : (bodies,) float64
        More than 0 of open targets.
    end_s : float
        End of the mission [s].
    stations : int
    connecting : callable
        Gives connections of some pairs at some times.
    """
    found = unknown(choices.bodies.size)
    near = places.neighbours_of(choices.bodies)[0]
    if near.shape[1] < 2:
        return found
    legs, there = _looked_at(choices, near, worths, stations)
    if legs.size:
        per_leg = there.shape[1]
        delta_v, arrival = connecting(
            np.repeat(choices.bodies[legs], per_leg),
            np.repeat(choices.free[legs], per_leg),
            there.ravel(),
        )
        _write_onward(choices, legs, there, delta_v, arrival, worths, end_s, found)
    return found


@kernel
def _looked_at(choices, near, worths, stations):
    """The legs of which those after them are looked at, and the bodies to which those lead."""
    count = choices.bodies.size
    cost, number = np.full(count, math.inf), 0
    for leg in range(count):
        if choices.legal[leg]:
            if choices.bodies[leg] >= stations:
                cost[leg] = choices.free[leg] / HOUR_S + choices.delta_v[leg] / M_S_PER_HOUR
            if choices.ranks[leg] == 0:  # the planned one in any case
                cost[leg] = min(cost[leg], 0.0)
            number += cost[leg] < math.inf
    legs = np.argsort(cost, kind="mergesort")[: min(number, LOOKED_AHEAD)]
    wanted = min(ONWARD, near.shape[1])
    there = np.empty((legs.size, wanted), np.int64)
    for row in range(legs.size):
        filled = 0
        for is_open in (True, False):  # open targets first, the nearest of each first
            for j in near[legs[row]]:
                if filled < wanted and (worths[j] > 0.0) == is_open:
                    there[row, filled] = j
                    filled += 1
    return legs, there


@kernel
def _write_onward(choices, legs, there, delta_v, arrival, worths, end, found):
    """Write the two cheapest legs after each of some legs."""
    for row in range(legs.size):
        leg = legs[row]
        best, second, paid = HOPELESS_H, HOPELESS_H, 0.0
        for column in range(there.shape[1]):
            at = row * there.shape[1] + column
            if not worths[there[row, column]] > 0.0:
                continue
            if delta_v[at] > choices.left[leg] or arrival[at] > end:
                continue
            cost = (arrival[at] - choices.free[leg]) / HOUR_S + delta_v[at] / M_S_PER_HOUR
            cost = min(cost, HOPELESS_H)
            if cost < best:
                best, second, paid = cost, best, delta_v[at]
            elif cost < second:
                second = cost
        found.known[leg] = True
        found.cost[leg], found.next_cost[leg], found.delta_v[leg] = best, second, paid
