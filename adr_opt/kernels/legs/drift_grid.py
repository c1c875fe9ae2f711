"""Drift legs on a grid of departure and arrival times: those that no other dominates.

A leg is priced with its phase (:mod:`.drift`) only where the optimum of free phase is cheap
enough to be listed. From one arrival to the next that optimum changes by no more than the node
moves on any drift orbit that could be paid for, so arrivals that are too dear are skipped.
"""

import math
from typing import NamedTuple

import numpy as np

from ..core.compile import kernel
from ..core.lists import chosen, wider
from ..orbits import ephemeris
from ..orbits.ephemeris import EPOCH_S
from . import drift_pair
from .drift import split
from .drift_free import first_guess, free_phase, matched, rest_of
from .drift_pair import margin, radius_of, shape_on, task_of

SLACK_M_S = 0.3
"""Largest excess of :mod:`.drift_free` over the ΔV with phase [m/s]: its tips are rounded off, and
arcs beside the drift orbit are taken as halfway to it."""


class LongTransfers(NamedTuple):
    """Long transfers of a pair, in order of departure, then of arrival.

    Attributes
    ----------
    departure, arrival : (long,) int32
        Numbers of times of the grid.
    delta_v : (long,) float64
        [m/s].
    """

    departure: np.ndarray
    arrival: np.ndarray
    delta_v: np.ndarray


@kernel
def is_blocked(pair, zones, departure, arrival, climb):
    """Whether a keep-out zone forbids a drift leg.

    When its arcs are flown is settled later, so a zone forbids the leg if it is closed at some
    moment of it, in a band that any of its orbits may touch.

    Parameters
    ----------
    pair : DriftPair
    zones : (zones, 4) float64
        As in :class:`.co_elliptic.TransferRule`.
    departure, arrival : float
        [s].
    climb : float
        b_y of its split [m/s].
    """
    linear = pair.linear
    drifting = radius_of(pair, climb)
    off = margin(drifting - linear.radius_i)
    low = min(min(linear.radius_i, linear.radius_j), drifting - off)
    high = max(max(linear.radius_i, linear.radius_j), drifting + off)
    for z in range(zones.shape[0]):
        if (
            zones[z, 0] <= high
            and zones[z, 1] >= low
            and zones[z, 2] <= arrival
            and zones[z, 3] >= departure
        ):
            return True
    return False


@kernel
def _change(pair, step, budget):
    """Largest change of the free-phase optimum between neighbouring arrivals of a grid [m/s].

    Only optima that cost no more than a budget have to be found: their first burn changes size and
    inclination by no more than half of the budget and of all there is to change.
    """
    linear = pair.linear
    most = 0.5 * (budget + math.hypot(pair.climb, linear.tilt))
    fastest = 0.0
    for up in (-1.0, 1.0):
        climb = min(max(up * most, pair.least_climb), pair.most_climb)
        radius = radius_of(pair, climb)
        for tilted in (-1.0, 1.0):
            inclination = pair.inclination_i + tilted * most / linear.speed
            rate = ephemeris.node_rate(radius, min(max(inclination, 0.0), math.pi), pair.oblateness)
            fastest = max(fastest, abs(rate - pair.node_rate_j))
    shape = 0.5 * linear.speed * abs(linear.perigee_lag_rate)
    shape *= min(linear.eccentricity_i, linear.eccentricity_j)
    return step * (linear.speed * linear.sine * fastest + shape)


@kernel
def first_to_last(departures, arrivals, costs, count):
    """Transfers found from the last departure to the first, reversed into ascending order.

    Parameters
    ----------
    departures, arrivals, costs : (room,) array
    count : int
        How many of them there are.

    Returns
    -------
    LongTransfers
    """
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
    return LongTransfers(
        chosen(departures, order, count),
        chosen(arrivals, order, count),
        chosen(costs, order, count),
    )


@kernel
def of_pair(orbits_i, orbit_j, rule, times, duration, resolution, shorts, kept):
    """Undominated transfers of a pair: short ones, and long ones on a grid of times.

    Parameters
    ----------
    orbits_i : (1 or times, columns) float64
        The origin as it is left, at each time of the grid if it is another body then; its size,
        shape and inclination stay.
    orbit_j : (columns,) float64
    rule : TransferRule
    times : Times
    duration : float
        The last arrival [s].
    resolution : float
        A transfer that saves no more than this is dominated [m/s].
    shorts : Shorts
        None of them dominates another, in order of departure.
    kept : (short,) bool
        Written: those that no long one dominates.

    Returns
    -------
    LongTransfers
    """
    pair, zones = drift_pair.prepare(orbits_i[0], orbit_j, rule, EPOCH_S), rule.zones
    departure, arrival, delta_v = shorts.departure, shorts.arrival, shorts.delta_v
    step, most = times.step, times.most
    points = math.floor(duration / step) + 1
    furthest = min(math.floor(times.longest / step), points - 1)
    # The least cost of all that leave later and arrive by then.
    stair, shape = np.empty(points), np.empty((points, 3))
    for t in range(points):
        stair[t] = math.inf
        shape[t, 0], shape[t, 1], shape[t, 2] = shape_on(pair, t * step)
    room = 1024
    departures, arrivals = np.empty(room, np.int32), np.empty(room, np.int32)
    costs_found = np.empty(room)
    count, short = 0, departure.size - 1
    # Whatever is drifted, radius and inclination have to be changed in all.
    floor = math.hypot(pair.climb, pair.linear.tilt)
    budget, change = most, _change(pair, step, most)
    for begin in range(points - 1, -1, -1):
        while short >= 0 and departure[short] >= begin * step:
            kept[short] = True
            for t in range(begin + 1, min(math.floor(arrival[short] / step), points - 1) + 1):
                kept[short] = kept[short] and delta_v[short] < stair[t] - resolution
            there = math.ceil(arrival[short] / step)
            if there < points:
                stair[there] = min(stair[there], delta_v[short])
            short -= 1
        if floor > most or begin * step > times.leave_by:
            continue
        if orbits_i.shape[0] > 1:
            pair = drift_pair.prepare(orbits_i[begin], orbit_j, rule, EPOCH_S)
            for t in range(begin + 1, points if pair.linear.eccentricity_i > 0.0 else 0):
                shape[t, 0], shape[t, 1], shape[t, 2] = shape_on(pair, t * step)
        last = min(begin + furthest, points - 1)
        cheapest = most + resolution
        looked, lag = begin + 1, math.inf
        climb = tilt = before_climb = before_tilt = 0.0
        last_t, before_t = begin, -1
        for t in range(begin + 1, last + 1):
            cheapest = min(cheapest, stair[t])
            if t < looked:
                continue
            below = cheapest - resolution
            if below <= floor:
                break
            if pair.free and below <= math.hypot(2.0 * shape[t, 0], pair.linear.tilt):
                continue
            leg = task_of(pair, begin * step, t * step, shape[t])
            if not abs(leg.lag - lag) < 0.1:
                start_climb, start_tilt = first_guess(pair, leg)
                before_t = -1
            elif before_t < 0:
                start_climb, start_tilt, before_t = climb, tilt, last_t
            else:
                # The optimum goes on as it went.
                more = (t - last_t) / (last_t - before_t)
                start_climb = climb + more * (climb - before_climb)
                start_tilt = tilt + more * (tilt - before_tilt)
                before_t = last_t
            before_climb, before_tilt = climb, tilt
            rest_of_node = rest_of(pair, leg)
            free = free_phase(pair, leg, rest_of_node, start_climb, start_tilt)
            climb, tilt = free.climb, free.tilt
            lag, last_t = leg.lag, t
            if free.least - SLACK_M_S < below:
                free = matched(pair, leg, rest_of_node, free)
            least = free.least
            if least - SLACK_M_S >= below:
                # No leg costs less than the optimum of free phase, up to the slack, and that
                # changes by `change` at most from one arrival to the next: so arrivals are passed
                # over until it may have come down to the limit.
                if below < 0.7 * budget or below > budget:
                    budget, change = below, _change(pair, step, below)
                looked = t + max(1, math.floor((least - SLACK_M_S - below) / change))
                continue
            way = split(pair, leg, free)
            if way.delta_v < below:
                if zones.shape[0] > 0 and is_blocked(
                    pair, zones, begin * step, t * step, way.climb
                ):
                    continue
                if count == departures.size:
                    departures, arrivals = wider(departures, count), wider(arrivals, count)
                    costs_found = wider(costs_found, count)
                departures[count], arrivals[count] = begin, t
                cheapest = costs_found[count] = stair[t] = way.delta_v
                count += 1
    return first_to_last(departures, arrivals, costs_found, count)
