"""Connections between drifting planes: short transfers at events, long ones on a grid of times.

As :mod:`.connections` for two bodies, but that nothing is regular any more: short ones
(:mod:`.short_transfers`) and long ones (:mod:`.drift`) are sifted and then put into one list.
"""

import math

import numpy as np

from ..core.compile import kernel
from ..core.lists import chosen, filled, ranks, rising, wider
from ..orbits.ephemeris import EPOCH_S
from . import co_elliptic, drift_grid, phasing
from .found import DRIFT, SHORT, ConnectionArrays
from .short_transfers import DeparturePiece, short


@kernel
def _by_departure(departure, arrival, order):
    """Sort an order by departure, then by arrival.

    It is nearly so already: only sequences of events beside each other can change places.
    """
    for place in range(1, order.size):
        new, at = order[place], place
        while at > 0 and (
            departure[order[at - 1]] > departure[new]
            or (
                departure[order[at - 1]] == departure[new] and arrival[order[at - 1]] > arrival[new]
            )
        ):
            order[at] = order[at - 1]
            at -= 1
        order[at] = new


@kernel
def _merged(shorts, kept, longs, step):
    """Retained short and long transfers in one list, by departure and then by arrival."""
    departure, arrival = shorts.departure, shorts.arrival
    cost, laps, family = shorts.delta_v, shorts.revolutions, shorts.family
    leaves, lands, long_cost = longs.departure, longs.arrival, longs.delta_v
    rank = ranks(arrival)
    order = rising(arrival, arrival.size)
    highest = 0 if lands.size == 0 else lands.max()
    # Number of short transfers that arrive before each time of the grid.
    before = np.empty(highest + 1, np.int32)
    place = 0
    for t in range(highest + 1):
        while place < order.size and arrival[order[place]] < t * step:
            place += 1
        before[t] = 0 if place == 0 else rank[order[place - 1]] + 1
    size = leaves.size
    for c in range(kept.size):
        size += kept[c]
    departures, arrivals, costs = np.empty(size), np.empty(size), np.empty(size)
    revolutions, crossing = np.empty(size, np.int8), np.empty(size, np.int32)
    families = np.empty(size, np.int8)
    short, long = 0, 0
    # Both lists are in order, so that the lesser of their heads is next. The rank of an arrival
    # among all is its rank in its own list and the number in the other that come before it.
    for at in range(size):
        while short < kept.size and not kept[short]:
            short += 1
        is_long = long < leaves.size and (
            short == kept.size
            or leaves[long] * step < departure[short]
            or (leaves[long] * step == departure[short] and lands[long] * step < arrival[short])
        )
        if is_long:
            departures[at], arrivals[at] = leaves[long] * step, lands[long] * step
            costs[at], revolutions[at], families[at] = long_cost[long], -1, DRIFT
            crossing[at] = lands[long] + before[lands[long]]
            long += 1
        else:
            departures[at], arrivals[at] = departure[short], arrival[short]
            costs[at], revolutions[at] = cost[short], laps[short]
            families[at] = family[short]
            crossing[at] = rank[short] + min(math.ceil(arrival[short] / step), highest + 1)
            short += 1
    return ConnectionArrays(departures, arrivals, costs, revolutions, crossing, families)


@kernel
def short_ones(orbit_i, orbit_j, extra_delta_v, rule, times, duration, resolution):
    """Undominated short transfers of a pair.

    Parameters
    ----------
    orbit_i, orbit_j : (columns,) float64
        Rows of :data:`adr_opt.kernels.orbits.ephemeris.ORBIT_COLUMNS`.
    extra_delta_v : float
        As :func:`.co_elliptic.prepare` takes it [m/s].
    rule : TransferRule
        Its time value is not looked at.
    times : Times
    duration : float
        Connections that arrive later are left out [s].
    resolution : float
        A connection that saves no more than this is dominated [m/s].

    Returns
    -------
    ConnectionArrays
    """
    pair = co_elliptic.prepare(orbit_i, orbit_j, extra_delta_v, rule, EPOCH_S)
    piece = DeparturePiece(0.0, math.inf, times.leave_by)
    curves = phasing.curves_of(pair, rule)
    found, order = short(
        pair, rule, curves, duration, times.interval, times.most, piece, resolution
    )
    size = order.size
    _by_departure(found.departure, found.arrival, order)
    arrival = chosen(found.arrival, order, size)
    return ConnectionArrays(
        chosen(found.departure, order, size),
        arrival,
        chosen(found.delta_v, order, size),
        chosen(found.revolutions, order, size),
        ranks(arrival),
        filled(size, SHORT),
    )


@kernel
def short_ones_of_pieces(pieces, orbit_j, extra_delta_v, rule, times, duration, resolution):
    """Short transfers of a pair with departures split into pieces, undominated in each piece.

    Parameters
    ----------
    pieces : adr_opt.plan.after_tows.Pieces
    orbit_j, extra_delta_v, rule, times, duration, resolution
        As :func:`short_ones` takes them.

    Returns
    -------
    ConnectionArrays
        In no order, without crossings.
    """
    room = 256
    departure, arrival, delta_v = np.empty(room), np.empty(room), np.empty(room)
    revolutions, count = np.empty(room, np.int8), 0
    for number in range(pieces.since.size):
        if pieces.since[number] > min(duration, times.leave_by):
            break
        pair = co_elliptic.prepare(pieces.rows[number], orbit_j, extra_delta_v, rule, EPOCH_S)
        if number == 0:
            curves = phasing.curves_of(pair, rule)
        piece = DeparturePiece(pieces.since[number], pieces.until[number], times.leave_by)
        found, order = short(
            pair, rule, curves, duration, times.interval, times.most, piece, resolution
        )
        for c in range(order.size):
            if count == departure.size:
                departure, arrival = wider(departure, count), wider(arrival, count)
                delta_v, revolutions = wider(delta_v, count), wider(revolutions, count)
            departure[count], arrival[count] = found.departure[order[c]], found.arrival[order[c]]
            delta_v[count] = found.delta_v[order[c]]
            revolutions[count] = found.revolutions[order[c]]
            count += 1
    return ConnectionArrays(
        departure[:count],
        arrival[:count],
        delta_v[:count],
        revolutions[:count],
        np.zeros(count, np.int32),
        filled(count, SHORT),
    )


@kernel
def with_drifts(orbits_i, orbit_j, rule, times, duration, resolution, found):
    """Other connections of a pair merged with its drift legs, without dominated ones.

    Parameters
    ----------
    orbits_i : (1 or times, columns) float64
        The origin as it is left, at each time of the grid if it is another body then.
    orbit_j, rule, times, duration, resolution
        As :func:`short_ones` takes them.
    found : ConnectionArrays
        The other ones, none of which dominates another.

    Returns
    -------
    ConnectionArrays
        Drifts have −1 revolutions.
    """
    kept = np.empty(found.departure.size, np.bool_)
    longs = drift_grid.of_pair(orbits_i, orbit_j, rule, times, duration, resolution, found, kept)
    return _merged(found, kept, longs, times.step)
