"""Connections: the undominated flyable transfers of a pair.

A *connection* is a transfer with everything settled: departure, arrival, ΔV, and the revolutions
that it phases. One connection dominates another of its pair if it departs no earlier, arrives no
later and costs no more, up to a resolution: a chaser that may wait never needs the other one. What
is left of all sequences (k, m) of all departure events is what a chaser can choose from.

How the sequences are sifted. All arrivals of a pair lie where the target crosses the line of nodes,
half a revolution apart, so different departures meet in the same ones: *crossings*, counted through
the mission. For a block of departure events the least ΔV to each crossing is worked out at once
(:mod:`.phasing`). Then events are gone through from the last to the first, and the crossings of an
event by time. So all that could dominate a sequence is known before it: what it costs at least to
arrive at each crossing by a later departure.
"""

import math
from typing import NamedTuple

import numpy as np

from ...common.constants import SLACK_S, TURN_RAD
from ..core.compile import kernel
from ..core.lists import ending, filled
from ..core.memory import borrowed
from ..orbits.ephemeris import EPOCH_S
from . import co_elliptic, phasing, zones
from .found import SHORT, ConnectionArrays

BLOCK = 256
"""Number of departure events laid out at once; they fit in the processor's cache."""


class CrossingGrid(NamedTuple):
    """Costs of the sequences of a block of departure events, by crossing of arrival.

    Attributes
    ----------
    departure : (events,) float64
        [s].
    crossing : (events,) int64
        At which the sequences of the first row arrive. Those of each further row arrive a
        revolution of the target later: two crossings.
    time : (rows, events) float64
        Flight times [s].
    cost : (rows, events) float64
        Least ΔV of all numbers of phasing revolutions, +inf for none [m/s].
    revolutions : (rows, events) int64
        That number, where there is a sequence.
    """

    departure: np.ndarray
    crossing: np.ndarray
    time: np.ndarray
    cost: np.ndarray
    revolutions: np.ndarray


class _Sieve(NamedTuple):
    """Parameters by which the sequences of a pair are sifted.

    Attributes
    ----------
    zoned : bool
        Whether there are zones.
    approach : float
        What follows the flight time [s].
    longest : float
        Longest flight time [s].
    duration : float
        Connections that arrive later are left out [s].
    resolution : float
        A connection that saves no more than this is dominated [m/s].
    """

    zoned: bool
    approach: float
    longest: float
    duration: float
    resolution: float


@kernel
def _begin_row(phase, turns, rate, row, time, cost):
    """Flight times of an empty row of sequences; one loop that is vectorised."""
    for e in range(phase.size):
        time[e] = (phase[e] + TURN_RAD * (turns[e] + row)) / rate
        cost[e] = math.inf


@kernel
def _lay_out(pair, rule, curves, begin, size, duration, grid):
    """Fill a grid with events from number ``begin`` on; late arrivals may be absent."""
    grid = borrowed(grid)
    start, half_turns = co_elliptic.first_departure(pair)
    half_period, lap = math.pi / pair.rate_i, TURN_RAD / pair.rate_j
    offset = rule.standoff / pair.radius_j
    rows = grid.time.shape[0]
    # Counted from one before the first that there is.
    origin = math.floor((pair.phase_j - offset + pair.rate_j * (start + pair.shortest)) / math.pi)
    phase, turns = np.empty(size), np.empty(size)
    for e in range(size):
        grid.departure[e] = start + (begin + e) * half_period
        lead = co_elliptic.target_lead(pair, grid.departure[e], half_turns + begin + e)
        phase[e] = 3.0 * math.pi - lead + offset
        turns[e] = math.ceil((pair.shortest * pair.rate_j - phase[e]) / TURN_RAD)
        time = (phase[e] + TURN_RAD * turns[e]) / pair.rate_j
        angle = pair.phase_j - offset + pair.rate_j * (grid.departure[e] + time)
        grid.crossing[e] = math.floor(angle / math.pi + 0.5) - origin + 1
    for row in range(rows):
        _begin_row(phase, turns, pair.rate_j, row, grid.time[row], grid.cost[row])
    last = duration - rule.approach_revolutions * lap - pair.shortest + SLACK_S
    for k in range(rule.max_phasing_revolutions + 1):
        least, most = k * pair.shortest_lap, pair.longest - pair.shortest + k * pair.longest_lap
        for row in range(max(int(least / lap - 1e-6), 0), min(int(most / lap + 1e-6) + 1, rows)):
            in_time = int(max((last - row * lap - start) / half_period, -1.0)) + 1 - begin
            phasing.lower(
                pair,
                rule,
                curves,
                k,
                phasing.Flights(grid.departure[0], grid.time[row], max(min(in_time, size), 0)),
                grid.cost[row],
                grid.revolutions[row],
            )


@kernel
def _cheapest_open(pair, rule, first, departure, time, below):
    """Least ΔV below a limit of a sequence that avoids all zones, and its k; +inf if none.

    ``first`` is the k of the least ΔV of all sequences, which is looked at first.
    """
    best, best_k = math.inf, -1
    for turn in range(-1, rule.max_phasing_revolutions + 1):
        k = first if turn < 0 else turn
        if pair.shortest + k * pair.shortest_lap > time:
            break
        if pair.longest + k * pair.longest_lap < time or turn == first:
            continue
        r = co_elliptic.phasing_radius(pair, rule, k, time)
        delta_v = co_elliptic.leg_delta_v(pair, rule, k, r, departure, time, pair.turn)
        if delta_v < min(best, below) and not zones.is_blocked(pair, rule, k, r, departure):
            best, best_k = delta_v, k
            if turn < 0:
                break
    return best, best_k


@kernel
def _sift(pair, rule, sieve, grid, e, known, kept):
    """The undominated rows of an event in order of arrival; returns their number.

    Parameters
    ----------
    pair : Pair
    rule : TransferRule
    sieve : _Sieve
    grid : CrossingGrid
    e : int
        The event in it.
    known : (crossings,) float64
        Least ΔV of later departures that arrive at each crossing [m/s]; brought up to date.
    kept : (rows,) int64
        Written; their costs in the grid are those of sequences that meet no zone.
    """
    grid, known, kept = borrowed(grid), borrowed(known), borrowed(kept)
    zoned, approach, resolution = sieve.zoned, sieve.approach, sieve.resolution
    count, cheapest = 0, math.inf
    crossing = grid.crossing[e]
    latest = min(sieve.longest, sieve.duration - grid.departure[e] - approach)
    # Events are sifted from the last to the first. So a connection is dominated just where one that
    # is known, by a crossing no later than its own, costs no more: rows are in order of arrival,
    # and what was least at the crossings before is carried along. Rows are two crossings apart.
    for row in range(grid.time.shape[0]):
        if grid.time[row, e] > latest:
            break
        cheapest = min(cheapest, min(known[crossing - 1], known[crossing]))
        # No sequence of the pair costs less than its floor: nothing later can be kept.
        if cheapest - resolution <= pair.floor_delta_v:
            break
        if grid.cost[row, e] < cheapest - resolution:
            if zoned and zones.any_closed(
                rule.zones, grid.departure[e], grid.departure[e] + grid.time[row, e] + approach
            ):
                grid.cost[row, e], grid.revolutions[row, e] = _cheapest_open(
                    pair,
                    rule,
                    grid.revolutions[row, e],
                    grid.departure[e],
                    grid.time[row, e],
                    cheapest - resolution,
                )
            if grid.cost[row, e] < math.inf:
                cheapest = known[crossing] = grid.cost[row, e]
                kept[count] = row
                count += 1
        crossing += 2
    return count


@kernel
def of_pair(orbit_i, orbit_j, extra_delta_v, rule, duration, resolution, since=-math.inf):
    """All undominated connections of a pair that leave from some time on.

    Parameters
    ----------
    orbit_i, orbit_j : (4,) float64
        Rows of :data:`adr_opt.kernels.orbits.ephemeris.ORBIT_COLUMNS`.
    extra_delta_v : float
        What matching the eccentricity vectors alone would cost [m/s].
    rule : TransferRule
        Its time value is not looked at.
    duration : float
        Connections that arrive later are left out [s].
    resolution : float
        A connection that saves no more than this is dominated [m/s].
    since : float
        Nobody leaves before [s]: of earlier events, some are listed and most are not.

    Returns
    -------
    ConnectionArrays
    """
    pair = co_elliptic.prepare(orbit_i, orbit_j, extra_delta_v, rule, EPOCH_S)
    first = co_elliptic.first_departure(pair)[0]
    lap = TURN_RAD / pair.rate_j
    approach = rule.approach_revolutions * lap
    events = max(math.floor((duration - first) * pair.rate_i / math.pi) + 1, 0)
    passed = int(max((since - first) * pair.rate_i / math.pi - 1.0, 0.0))
    passed = min(passed, events)
    longest = pair.longest + rule.max_phasing_revolutions * pair.longest_lap
    rows = int((longest - pair.shortest) / lap + 1e-6) + 1
    size = min(events - passed, BLOCK)
    grid = CrossingGrid(
        np.empty(size),
        np.empty(size, np.int64),
        np.empty((rows, size)),
        np.empty((rows, size)),
        np.empty((rows, size), np.int64),
    )
    known = np.empty(int(max(duration - first, 0.0) / lap * 2.0) + 2 * rows + 8)
    for crossing in range(known.size):
        known[crossing] = math.inf
    kept = np.empty(rows, np.int64)
    # Filled from the end, as events are gone through.
    room = rows * (events - passed)
    departures, arrivals, costs = np.empty(room), np.empty(room), np.empty(room)
    laps, crossings = np.empty(room, np.int8), np.empty(room, np.int32)
    at = room
    sieve = _Sieve(rule.zones.shape[0] > 0, approach, longest, duration, resolution)
    curves = phasing.curves_of(pair, rule)
    # Blocks are a matter of storage: `known` is carried from one to the next, so that what is kept
    # does not depend on their size.
    for end in range(events, passed, -BLOCK):
        begin = max(end - BLOCK, passed)
        _lay_out(pair, rule, curves, begin, end - begin, duration, grid)
        for e in range(end - begin - 1, -1, -1):
            count = _sift(pair, rule, sieve, grid, e, known, kept)
            for c in range(count - 1, -1, -1):
                at -= 1
                departures[at] = grid.departure[e]
                arrivals[at] = grid.departure[e] + grid.time[kept[c], e] + approach
                costs[at], laps[at] = grid.cost[kept[c], e], grid.revolutions[kept[c], e]
                crossings[at] = grid.crossing[e] + 2 * kept[c]
    return ConnectionArrays(
        ending(departures, at),
        ending(arrivals, at),
        ending(costs, at),
        ending(laps, at),
        ending(crossings, at),
        filled(room - at, SHORT),
    )


@kernel
def best_from(departure, arrival, delta_v, worth, time_value):
    """The best of each connection and all later ones of its pair.

    Parameters
    ----------
    departure, arrival, delta_v : (connections,) float64
        Of one pair, in order of departure [s], [s], [m/s].
    worth, time_value : float
        The best has the least worth·ΔV + time_value·arrival; ties go to the earlier arrival, then
        to the lesser ΔV. (1, 0) is the cheapest, (0, 1) the earliest.

    Returns
    -------
    best : (connections,) int64
        Index of the best one from each on: what a chaser takes that is ready at its departure, or
        after the departure before it.
    """
    best = np.empty(departure.size, np.int64)
    taken = departure.size - 1
    for c in range(departure.size - 1, -1, -1):
        here = worth * delta_v[c] + time_value * arrival[c]
        there = worth * delta_v[taken] + time_value * arrival[taken]
        if here < there or (
            here == there
            and (
                arrival[c] < arrival[taken]
                or (arrival[c] == arrival[taken] and delta_v[c] < delta_v[taken])
            )
        ):
            taken = c
        best[c] = taken
    return best
