"""Arrivals that are functions of the departure: piecewise linear, and never overtaking.

See docs/model.md section 9. Where a function jumps, the earlier arrival is that of who leaves by
then, as with a train.
"""

import math

import numpy as np

from ..core.compile import inlined, kernel
from ..core.events import earliest_taken


@inlined
def leg_of(departures, arrivals, first, last, ready):
    """Departure and earliest arrival of a chaser that is ready at a time.

    Who leaves later arrives no earlier, so that nobody waits but for the first departure.

    Parameters
    ----------
    departures, arrivals : (breakpoints,) float64
        Of all functions; none of a function falls [s].
    first, last : int
        The breakpoints of this one: ``first`` to ``last`` − 1; none where there is no function.
    ready : float
        [s].

    Returns
    -------
    departure, arrival : float
        [s]; +inf where nothing leaves any more.
    """
    earliest = earliest_taken(ready)
    if first == last or departures[last - 1] < earliest:
        return math.inf, math.inf
    low, high = first, last - 1
    while low < high:
        middle = (low + high) // 2
        if departures[middle] < earliest:
            low = middle + 1
        else:
            high = middle
    # The first breakpoint that is not missed; at one that is met within the slack there is no
    # arithmetic, so that rounding does not decide who is in time for it.
    if low == first or departures[low] <= ready:
        return departures[low], arrivals[low]
    before = low - 1
    rise = arrivals[low] - arrivals[before]
    share = (ready - departures[before]) / (departures[low] - departures[before])
    return ready, max(arrivals[before], min(arrivals[before] + rise * share, arrivals[low]))


@kernel
def legs_of(departures, arrivals, ready):
    """Departures and arrivals by one function, for chasers that are ready at some times.

    Parameters
    ----------
    departures, arrivals : (breakpoints,) float64
        [s].
    ready : (times,) float64
        [s].

    Returns
    -------
    departure, arrival : (times,) float64
        [s], as of :func:`leg_of`.
    """
    leaves, lands = np.empty(ready.size), np.empty(ready.size)
    for place in range(ready.size):
        leaves[place], lands[place] = leg_of(departures, arrivals, 0, departures.size, ready[place])
    return leaves, lands
