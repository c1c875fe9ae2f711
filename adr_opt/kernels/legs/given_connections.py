"""Undominated connections among those of a pair, in any order of arrival."""

import math

import numpy as np

from ..core.compile import kernel
from ..core.lists import chosen, filled, ranks
from .found import GIVEN, ConnectionArrays


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
