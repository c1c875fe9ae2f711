"""Connections: every flyable transfer of a pair that no other one makes superfluous.

A *connection* is a transfer with everything settled: departure, arrival, ΔV, and the revolutions
that it phases. One connection dominates another of its pair if it departs no earlier, arrives no
later and costs no more, up to a resolution: a chaser that may wait never needs the other one. What
is left of all sequences (k, m) of all departure events is what a chaser can choose from.

How the sequences are sifted. Events are gone through from the last to the first and the sequences
of an event by flight time, so all that could dominate a sequence is known before it: a *staircase*
of (arrival, ΔV), where later means cheaper. Most sequences cost far more than the stair at their
arrival. That is seen without solving for their phasing radius: a quadratic inversion finds it to
some kilometres, and a table over the radius holds what a sequence costs there at least.

All arrivals of a pair lie where the target crosses the line of nodes, so different departures meet
in the same one; the slack of the model keeps rounding from telling them apart.
"""

import math

import numpy as np

from . import transfer
from .compile import kernel
from .constants import SLACK_S
from .lists import chosen, wider, with_stair
from .transfer import TWO_PI

CELLS = 256
"""Cells of the table of least ΔV over the phasing radius."""

WIDE = 0.25
"""Where an altitude limit is farther than this from the mean radius (relative), the quadratic
inversion is worth nothing, and every sequence is solved for."""


@kernel
def least_delta_v(pair, rule, least):
    """Least ΔV of a sequence whose phasing radius is estimated to lie in a cell.

    A direct sequence (k = 0) is never dearer than one that phases at the same radius, since it
    makes one burn of two. Within a cell the ΔV falls below its ends by no more than the steepest
    slope near it allows. The estimate is off by the third order of the inversion, d³/(6 r²) at a
    distance d from the mean radius r; half as much again covers what follows it.

    Parameters
    ----------
    pair : Pair
    rule : TransferRule
    least : (CELLS,) float64
        Written [m/s].
    """
    far = max(rule.max_radius - pair.reference, pair.reference - rule.min_radius)
    if far > WIDE * pair.reference:
        for c in range(CELLS):
            least[c] = -math.inf
        return
    ends = np.empty(CELLS + 1)
    width = (rule.max_radius - rule.min_radius) / CELLS
    off = 1 + math.ceil(0.25 * far**3 / pair.reference**2 / width)
    for c in range(CELLS + 1):
        ends[c] = transfer.sequence_delta_v(pair, rule, 0, rule.min_radius + c * width)
    for c in range(CELLS):
        low, steepest = math.inf, 0.0
        for b in range(max(c - off, 0), min(c + off + 1, CELLS)):
            low = min(low, min(ends[b], ends[b + 1]))
            steepest = max(steepest, abs(ends[b + 1] - ends[b]))
        least[c] = low - 0.6 * steepest - 1e-3


@kernel
def _estimated_cell(pair, rule, revolutions, time):
    """Cell of the phasing radius at which a sequence takes a time, by a quadratic inversion."""
    slope = pair.flight_1 + revolutions * pair.lap_1
    d = (time - pair.flight - revolutions * pair.lap) / slope
    d -= 0.5 * (pair.flight_2 + revolutions * pair.lap_2) / slope * d * d
    share = (pair.reference + d - rule.min_radius) / (rule.max_radius - rule.min_radius)
    return min(max(int(share * CELLS), 0), CELLS - 1)


@kernel
def of_pair(orbit_i, orbit_j, extra_delta_v, rule, duration, resolution):
    """All connections of a pair that no other one dominates.

    Parameters
    ----------
    orbit_i, orbit_j : (4,) float64
        Rows of :data:`adr_opt.kernels.orbits.ORBIT_COLUMNS`.
    extra_delta_v : float
        Cost of matching the eccentricity vectors [m/s].
    rule : TransferRule
        Its time value is not looked at.
    duration : float
        Connections that arrive later are left out [s].
    resolution : float
        A connection that saves no more than this is dominated [m/s].

    Returns
    -------
    departure, arrival, delta_v : (connections,) float64
        [s], [s], [m/s]; in order of departure, then of arrival. The arrival is the end of the
        approach.
    revolutions : (connections,) int8
        Phasing revolutions k.
    """
    pair = transfer.prepare(orbit_i, orbit_j, extra_delta_v, rule)
    half_period = math.pi / pair.rate_i
    lap = TWO_PI / pair.rate_j
    approach = rule.approach_revolutions * lap
    first, half_turns = transfer.first_departure(pair)
    most = rule.max_phasing_revolutions
    longest = pair.longest + most * pair.longest_lap
    least = np.empty(CELLS)
    least_delta_v(pair, rule, least)

    room = 1024
    departures, arrivals = np.empty(room), np.empty(room)
    costs, laps = np.empty(room), np.empty(room, np.int8)
    count = 0
    # The staircase of the events that were gone through, in order of arrival.
    steps = 64
    step_arrival, step_cost = np.empty(steps), np.empty(steps)
    size = 0

    events = math.floor((duration - first) / half_period) + 1 if first <= duration else 0
    for m in range(events - 1, -1, -1):
        departure = first + m * half_period
        lead = transfer.target_lead(pair, departure, half_turns + m)
        phase = 3.0 * math.pi - lead + rule.standoff / pair.radius_j
        s = math.ceil((pair.shortest * pair.rate_j - phase) / TWO_PI)
        latest = min(longest, duration - departure - approach)
        begin, stair, fewest, cheapest = count, 0, 0, math.inf
        while cheapest - resolution > pair.floor_delta_v:
            time = (phase + TWO_PI * s) / pair.rate_j
            s += 1
            if time > latest:
                break
            arrival = departure + time + approach
            while stair < size and step_arrival[stair] <= arrival + SLACK_S:
                cheapest = min(cheapest, step_cost[stair])
                stair += 1
            while pair.longest + fewest * pair.longest_lap < time:
                fewest += 1
            best, best_k = cheapest - resolution, -1
            k = fewest
            while k <= most and pair.shortest + k * pair.shortest_lap <= time:
                if least[_estimated_cell(pair, rule, k, time)] < best:
                    r = transfer.phasing_radius(pair, rule, k, time)
                    delta_v = transfer.sequence_delta_v(pair, rule, k, r)
                    if delta_v < best and not (
                        rule.zones.shape[0] > 0 and transfer.is_blocked(pair, rule, k, r, departure)
                    ):
                        best, best_k = delta_v, k
                k += 1
            if best_k < 0:
                continue
            if count == departures.size:
                departures, arrivals = wider(departures, count), wider(arrivals, count)
                costs, laps = wider(costs, count), wider(laps, count)
            departures[count], arrivals[count] = departure, arrival
            costs[count], laps[count] = best, best_k
            count += 1
            cheapest = best
        # Into the staircase of all that depart no earlier than the next event to be looked at.
        for c in range(begin, count):
            low = 0
            while low < size and step_arrival[low] < arrivals[c] - SLACK_S:
                low += 1
            if size == step_arrival.size:
                step_arrival, step_cost = wider(step_arrival, size), wider(step_cost, size)
            size = with_stair(step_arrival, step_cost, size, low, arrivals[c], costs[c])
        # Nothing that departs earlier arrives after these.
        while size > 1 and step_arrival[size - 1] > departure + longest + approach:
            size -= 1
    # From the last event to the first, each by arrival: turned round event by event.
    order = np.empty(count, np.int64)
    high, at = count, 0
    while high > 0:
        low = high - 1
        while low > 0 and departures[low - 1] == departures[high - 1]:
            low -= 1
        for c in range(low, high):
            order[at] = c
            at += 1
        high = low
    return (
        chosen(departures, order, count),
        chosen(arrivals, order, count),
        chosen(costs, order, count),
        chosen(laps, order, count),
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
