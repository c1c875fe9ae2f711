"""A decision: the chaser that decides, and the legs from which it may choose."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import numpy.typing as npt

FloatArray = npt.NDArray[np.float64]
IntArray = npt.NDArray[np.int64]
BoolArray = npt.NDArray[np.bool_]


class Standing(NamedTuple):
    """A chaser that decides, and its mission.

    Attributes
    ----------
    body : int
    time, end : float
        Now, and the end of the mission or of the chaser's availability [s].
    left, full : float
        ΔV in the tank, and in a full one [m/s].
    since : int
        Targets serviced since the last refuelling.
    stations : int
        Bodies with smaller numbers are stations.
    chasers : int
    tank_ahead, time_ahead : float or None
        By how much the tank and the clock are better than planned before the next planned leg
        [m/s], [s]; None without a plan.
    """

    body: int
    time: float
    end: float
    left: float
    full: float
    since: int
    stations: int
    chasers: int
    tank_ahead: float | None
    time_ahead: float | None


class Choices(NamedTuple):
    """Legs from which a chaser may choose.

    Attributes
    ----------
    bodies : (legs,) int64
        Where they lead.
    delta_v : (legs,) float64
        Of the legs [m/s].
    arrival, free : (legs,) float64
        Arrival, and when the chaser is free again [s].
    left : (legs,) float64
        ΔV left then, after tows, kits and refuelling [m/s].
    closes : (legs,) float64
        When a service there has to be over [s].
    waits : (legs,) float64
        Between arrival and the opening of the window [s].
    legal : (legs,) bool
    ranks : (legs,) int64
        Place among the planned legs that are left, from 0; −1 for none.
    planned_by_others : (legs,) bool
        Whether another chaser plans to go there.
    others_apart : (legs,) float64
        Distance of the nearest other chaser [m/s]; +inf without one.
    """

    bodies: IntArray
    delta_v: FloatArray
    arrival: FloatArray
    free: FloatArray
    left: FloatArray
    closes: FloatArray
    waits: FloatArray
    legal: BoolArray
    ranks: IntArray
    planned_by_others: BoolArray
    others_apart: FloatArray
