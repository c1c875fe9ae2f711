"""Given connections of a pair: lists, and arrivals as functions of the departure.

Functions are piecewise linear and never fall (docs/model.md section 9). Where one jumps, a chaser
that leaves at that time has the earlier arrival, as with a train. Lists are sifted by dominance.
"""

import math

import numpy as np

from ..core.compile import inlined, kernel
from ..core.events import earliest_taken
from ..core.lists import chosen, filled, first_at, ranks
from .found import GIVEN, ConnectionArrays


@inlined
def leg_of(departures, arrivals, first, last, ready):
    """Departure and earliest arrival of a chaser that is ready at a time.

    A later departure arrives no earlier, so that a chaser waits for the first one only.

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
    low = first_at(departures, first, last - 1, earliest)
    # The first breakpoint that is not missed; at one that is met within the slack there is no
    # arithmetic, so that rounding does not decide whether it is met.
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


@kernel
def undominated(departure, arrival, cost, latest, resolution):
    """Mask of the connections of a pair that are in time and undominated.

    Parameters
    ----------
    departure, arrival, cost : (given,) float64
        In order of departure, of those that leave together in order of arrival, and of those that
        arrive together, too, in order of cost [s], [s], [m/s].
    latest : float
        Connections that arrive later are left out [s].
    resolution : float
        A connection that saves no more than this is dominated [m/s].

    Returns
    -------
    (kept,) int64
        Their places, ascending.
    """
    size = departure.size
    rank = ranks(arrival)
    # Least cost of the connections looked at so far that arrive no later, as sums of a binary tree
    # (Fenwick 1994), with the minimum in place of the sum.
    least = np.empty(size + 1)
    for place in range(size + 1):
        least[place] = math.inf
    kept = np.empty(size, np.bool_)
    count, end = 0, size
    while end > 0:
        begin = end - 1
        while begin > 0 and departure[begin - 1] == departure[end - 1]:
            begin -= 1
        # Of those that leave together the first cannot be dominated by the ones after it.
        for c in range(begin, end):
            cheapest, place = math.inf, rank[c] + 1
            while place > 0:
                cheapest = min(cheapest, least[place])
                place -= place & -place
            kept[c] = arrival[c] <= latest and cost[c] < cheapest - resolution
            if kept[c]:
                count += 1
                place = rank[c] + 1
                while place <= size:
                    least[place] = min(least[place], cost[c])
                    place += place & -place
        end = begin
    order = np.empty(count, np.int64)
    place = 0
    for c in range(size):
        if kept[c]:
            order[place] = c
            place += 1
    return order


@kernel
def sifted(departure, arrival, cost, latest, resolution):
    """The undominated given connections of a pair, by the mask of :func:`undominated`.

    Returns
    -------
    ConnectionArrays
        With 0 revolutions.
    """
    order = undominated(departure, arrival, cost, latest, resolution)
    count = order.size
    lands = chosen(arrival, order, count)
    return ConnectionArrays(
        chosen(departure, order, count),
        lands,
        chosen(cost, order, count),
        filled(count, 0),
        ranks(lands),
        filled(count, GIVEN),
    )
