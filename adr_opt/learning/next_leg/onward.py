"""The legs after the next one: how dear it is to go on from where a leg leads."""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from ...common.constants import HOUR_S
from .choices import M_S_PER_HOUR, Choices
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
    nothing = np.zeros(legs)
    return OnwardLegs(np.zeros(legs, dtype=np.bool_), nothing, nothing, nothing)


def onward(
    choices: Choices, places: OrbitPlaces, worths: FloatArray, end_s: float, stations: int,
    connecting: Connecting,
) -> OnwardLegs:  # fmt: skip
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
    cost = choices.free / HOUR_S + choices.delta_v / M_S_PER_HOUR
    cost = np.where(choices.legal & (choices.bodies >= stations), cost, np.inf)
    cost = np.where(choices.ranks == 0, np.minimum(cost, 0.0), cost)
    cost = np.where(choices.legal, cost, np.inf)
    at = np.argsort(cost, kind="stable")[:LOOKED_AHEAD]
    at = at[np.isfinite(cost[at])]
    near = places.near[choices.bodies[at]]
    if at.size == 0 or near.shape[1] < 2:
        return found
    first = np.argsort(worths[near] <= 0.0, axis=1, kind="stable")[:, :ONWARD]
    there = np.take_along_axis(near, first, axis=1)
    origins = np.repeat(choices.bodies[at], there.shape[1])
    ready = np.repeat(choices.free[at], there.shape[1])
    delta_v, arrival = connecting(origins, ready, there.ravel())
    delta_v, arrival = delta_v.reshape(there.shape), arrival.reshape(there.shape)
    fits = (worths[there] > 0.0) & (delta_v <= choices.left[at, None]) & (arrival <= end_s)
    taken = (arrival - choices.free[at, None]) / HOUR_S + delta_v / M_S_PER_HOUR
    taken = np.where(fits, np.minimum(taken, HOPELESS_H), HOPELESS_H)
    order = np.argsort(taken, axis=1)
    rows = np.arange(at.size)
    found.known[at] = True
    cost, later, least = np.zeros_like(found.cost), np.zeros_like(found.cost), found.delta_v.copy()
    cost[at], later[at] = taken[rows, order[:, 0]], taken[rows, order[:, 1]]
    least[at] = np.where(fits, delta_v, 0.0)[rows, order[:, 0]]
    return OnwardLegs(found.known, cost, later, least)
