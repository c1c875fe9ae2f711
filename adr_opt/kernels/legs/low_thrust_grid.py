"""Low-thrust legs on a grid of departure and arrival times: those that no other dominates."""

import math

import numpy as np

from ..core.compile import kernel
from ..core.lists import wider
from .drift_grid import first_to_last
from .low_thrust import bound_below, leg_below

NONE_KNOWN = np.empty(0, np.int32), np.empty(0, np.int32), np.empty(0)
"""No legs of heavier chasers."""


@kernel
def of_pair(pair, thrust, times, duration, resolution, relaxed, known):
    """Undominated low-thrust legs of a pair.

    Parameters
    ----------
    pair : LowThrustPair
    thrust : Thrust
        Of the chaser with the largest mass, or the least for lower bounds.
    times : Times
        Its interval is not looked at.
    duration : float
        The last arrival [s].
    resolution : float
        A leg that saves no more than this is dominated [m/s].
    relaxed : bool
        Whether to take lower bounds for all masses in place of costs with the largest.
    known : tuple of (legs,) int32, (legs,) int32, (legs,) float64
        Departures and arrivals in steps, and ΔV [m/s], of legs that are there already, in order of
        departure: those of heavier chasers. They are not found again, and dominate.

    Returns
    -------
    LongTransfers
    """
    step, most = times.step, times.most
    points = math.floor(duration / step) + 1
    furthest = min(math.floor(times.longest / step), points - 1)
    # The least cost of all that leave later and arrive by then.
    stair = np.full(points, math.inf)
    room = 256
    departures, arrivals = np.empty(room, np.int32), np.empty(room, np.int32)
    costs = np.empty(room)
    count = 0
    leaves, lands, paid = known
    before = leaves.size
    for begin in range(points - 2, -1, -1):
        while before > 0 and leaves[before - 1] >= begin:
            before -= 1
            stair[lands[before]] = min(stair[lands[before]], paid[before])
        if begin * step > times.leave_by:
            continue
        cheapest = most + resolution
        for t in range(begin + 1, min(begin + furthest, points - 1) + 1):
            cheapest = min(cheapest, stair[t])
            below = cheapest - resolution
            departure, arrival = begin * step, t * step
            if relaxed:
                cost = bound_below(pair, thrust, departure, arrival, below)
            else:
                cost = leg_below(pair, thrust, departure, arrival, below, False).split.delta_v
            if cost >= below:
                continue
            if count == departures.size:
                departures, arrivals = wider(departures, count), wider(arrivals, count)
                costs = wider(costs, count)
            departures[count], arrivals[count], costs[count] = begin, t, cost
            cheapest = stair[t] = cost
            count += 1
    return first_to_last(departures, arrivals, costs, count)
