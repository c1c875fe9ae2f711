"""Connections between planes that drift: short transfers at events, long ones on a grid of times.

As :mod:`.connections` for two bodies, but that nothing is regular any more. The lines of nodes
move, so events are found one by one (:mod:`.precession`); sequences of one event leave within
seconds of it, and those that meet the target on one crossing arrive within seconds of each other.
To be found in one row of a network, departures are rounded down to whole steps from the event: who
takes the connection has to be ready by then, and leaves up to a step later.

A sequence is settled exactly only where an estimate says that it may be worth it: its ε is read off
at the flight time that it would have without, and moves both ends in proportion.
"""

import math
from typing import NamedTuple

import numpy as np

from . import drift, eccentricity, keep_out, phasing, precession, transfer
from .compile import inlined, kernel
from .connections import Found
from .constants import SLACK_S
from .lists import chosen, rising, wider
from .transfer import TWO_PI

BAND_S = 300.0
"""A sequence whose flight time is estimated so far from what its revolutions allow is left out."""

SURE_STEPS = 3
"""A fixed point that takes no more is found again from anywhere near."""

NEAR_RAD = 0.003
"""Where planes are so near, that is not sure [rad]."""

ERROR_M_S, BEND_M_S = 0.05, 400.0
"""How far the estimate of a ΔV may be off: so much, and so much times (ε/θ)²."""


class Times(NamedTuple):
    """When transfers may leave, and how long they may take.

    Attributes
    ----------
    interval : float
        Between departure events of a pair, at least [s].
    step, longest : float
        Of the grid of long transfers, and the longest of them, 0 for none [s].
    most : float
        Transfers that cost more are of no use to anybody [m/s].
    """

    interval: float
    step: float
    longest: float
    most: float


@kernel
def events_of(pair, duration, spacing):
    """The departure events of a mission, not closer than a spacing [s].

    Returns
    -------
    half_turns : (events,) int64
    numbers : (7, events) float64
        The other fields of :class:`.precession.Event`, event by event.
    """
    steps = max(1, math.ceil(spacing * pair.rate_i / math.pi - 1e-9))
    most = int(max(duration, 0.0) * pair.rate_i / math.pi / steps) + 3
    half_turns, numbers = np.empty(most, np.int64), np.empty((7, most))
    event = precession.first_event(pair)
    count = 0
    while event.time <= duration and count < most:
        half_turns[count] = event.half_turns
        numbers[0, count], numbers[1, count] = event.time, event.lag
        numbers[2, count], numbers[3, count] = event.alpha_i, event.alpha_j
        numbers[4, count], numbers[5, count] = event.turn_i, event.turn_j
        numbers[6, count] = event.theta
        count += 1
        event = precession.later_event(pair, event, steps)
    return half_turns[:count], numbers[:, :count]


@inlined
def _listed(event, departure):
    """By when a chaser has to be ready that leaves at a time near an event [s]."""
    steps = math.floor((departure - event + precession.ROUNDING_S) / precession.STEP_S)
    return min(departure, event + steps * precession.STEP_S)


@kernel
def short(pair, rule, duration, spacing, most, resolution):
    """The short transfers of a pair that no other one dominates.

    Parameters
    ----------
    pair : Pair
    rule : TransferRule
    duration : float
        Those that arrive later are left out [s].
    spacing : float
        Between departure events, at least [s].
    most : float
        Dearer ones are left out [m/s].
    resolution : float
        A transfer that saves no more than this is dominated [m/s].

    Returns
    -------
    departure, arrival, delta_v : (transfers,) float64
        In order of events from the last to the first, then of arrival [s], [s], [m/s].
    revolutions : (transfers,) int8
    """
    half_turns, numbers = events_of(pair, duration, spacing)
    curves = phasing.curves_of(pair, rule)
    lap, approach = TWO_PI / pair.rate_j, rule.approach_revolutions * TWO_PI / pair.rate_j
    longest = pair.longest + rule.max_phasing_revolutions * pair.longest_lap + BAND_S
    sines = 4.0 * math.sin(pair.inclination_i) * math.sin(pair.inclination_j)
    tilt = 4.0 * math.sin(0.5 * (pair.inclination_j - pair.inclination_i)) ** 2
    size = 1024
    departures, arrivals, costs = np.empty(size), np.empty(size), np.empty(size)
    laps = np.empty(size, np.int8)
    count = 0
    # By crossing of the target: what later departures cost that arrive there, and until when.
    crossings = int(max(duration, 0.0) / lap * 2.0) + 8
    known, until = np.empty(crossings), np.empty(crossings)
    for c in range(crossings):
        known[c], until[c] = math.inf, math.inf
    least_turn = (1.0 - 1e-9) * pair.speed_i * math.sqrt(
        2.0 * pair.radius_i * pair.radius_i
        / (rule.max_radius * (pair.radius_i + rule.max_radius))
    )  # fmt: skip
    offset = rule.standoff / pair.radius_j
    for e in range(half_turns.size - 1, -1, -1):
        event, lag, alpha_i, alpha_j = numbers[0, e], numbers[1, e], numbers[2, e], numbers[3, e]
        theta = numbers[6, e]
        if least_turn * math.sin(min(0.9 * theta, 0.5 * math.pi)) > most:
            continue
        matching = eccentricity.matching(pair, event)
        moves = numbers[5, e] / pair.rate_j - numbers[4, e] / pair.rate_i
        met = precession.meeting(
            pair, rule, half_turns[e], alpha_j, event + pair.shortest - BAND_S + 0.5 * lap
        )
        latest = min(longest, duration - event - approach + BAND_S)
        cheapest = most + resolution
        while met - event <= latest:
            base = met - event
            turned = pair.latitude_j + pair.rate_j * met - offset - alpha_j
            crossing = math.floor(turned / math.pi + 0.5) + 1
            crossing = min(max(crossing, 1), crossings - 1)
            best, best_k = math.inf, -1
            best_d = best_a = 0.0
            for k in range(rule.max_phasing_revolutions + 1):
                if pair.shortest + k * pair.shortest_lap > base + BAND_S:
                    break
                if pair.longest + k * pair.longest_lap < base - BAND_S:
                    continue
                left, there = event, met
                if curves.time.shape[0] > 0:
                    shift = phasing.parts_at(curves, k, base)[4]
                    time = base + moves * shift
                    climb, rest, chord, square, shift = phasing.parts_at(curves, k, time)
                    angle = tilt + sines * math.sin(0.5 * (lag + shift)) ** 2
                    estimate = transfer.whole(climb, rest, chord, square * angle, matching)
                    estimate += pair.fixed_delta_v
                    off = ERROR_M_S + BEND_M_S * (shift / theta) ** 2
                    if estimate - off >= min(cheapest - resolution, best):
                        continue
                    left += numbers[4, e] * shift / pair.rate_i
                    there += numbers[5, e] * shift / pair.rate_j
                found = precession.settle(
                    pair, rule, half_turns[e], k, left, there, alpha_i, alpha_j
                )
                if found.delta_v >= min(cheapest - resolution, best):
                    continue
                if found.departure < -SLACK_S or abs(found.stand_off - met) > 0.5 * lap:
                    continue
                if rule.zones.shape[0] > 0 and keep_out.is_blocked(
                    pair, rule, k, found.radius, found.departure
                ):
                    continue
                listed = max(_listed(event, found.departure), 0.0)
                if found.steps > SURE_STEPS or theta < NEAR_RAD:
                    # Who flies it must find the departure again.
                    again = precession.leaving(pair, rule, k, listed, found.stand_off)
                    if not abs(again - found.departure) < precession.ROUNDING_S:
                        continue
                best, best_k = found.delta_v, k
                best_d, best_a = listed, found.stand_off + approach
            for c in range(max(crossing - 3, 0), crossing + 1):
                if best_k < 0 or until[c] <= best_a + SLACK_S:
                    cheapest = min(cheapest, known[c])
            if best_k >= 0 and best < cheapest - resolution and best_a <= duration:
                if count == departures.size:
                    departures, arrivals = wider(departures, count), wider(arrivals, count)
                    costs, laps = wider(costs, count), wider(laps, count)
                departures[count], arrivals[count] = best_d, best_a
                costs[count], laps[count] = best, best_k
                count += 1
                cheapest = best
                until[crossing] = (
                    best_a if known[crossing] == math.inf else max(until[crossing], best_a)
                )
                known[crossing] = min(known[crossing], best)
            met += lap
    return departures[:count], arrivals[:count], costs[:count], laps[:count]


@kernel
def _by_departure(departure, arrival):
    """Order of connections by departure, and of those that leave together by arrival."""
    order = rising(departure, departure.size)
    for place in range(1, order.size):
        new, at = order[place], place
        while (
            at > 0
            and departure[order[at - 1]] == departure[new]
            and arrival[order[at - 1]] > arrival[new]
        ):
            order[at] = order[at - 1]
            at -= 1
        order[at] = new
    return order


@kernel
def _ranks(arrival):
    """The place of each arrival among all, the same for equal ones."""
    order = rising(arrival, arrival.size)
    rank = np.empty(arrival.size, np.int32)
    number = -1
    for place in range(order.size):
        if place == 0 or arrival[order[place]] > arrival[order[place - 1]]:
            number += 1
        rank[order[place]] = number
    return rank


@kernel
def _merged(departure, arrival, cost, laps, kept, leaves, lands, long_cost, step):
    """Short and long transfers in one list, by departure and then by arrival: a :class:`Found`."""
    ranks = _ranks(arrival)
    order = rising(arrival, arrival.size)
    highest = 0 if lands.size == 0 else lands.max()
    # So many short transfers arrive before a time of the grid, at as many different times at most.
    before = np.empty(highest + 1, np.int32)
    place = 0
    for t in range(highest + 1):
        while place < order.size and arrival[order[place]] < t * step:
            place += 1
        before[t] = 0 if place == 0 else ranks[order[place - 1]] + 1
    shorts = 0
    for c in range(kept.size):
        shorts += kept[c]
    size = shorts + leaves.size
    departures, arrivals, costs = np.empty(size), np.empty(size), np.empty(size)
    revolutions, crossing = np.empty(size, np.int8), np.empty(size, np.int32)
    short, long = 0, 0
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
            costs[at], revolutions[at] = long_cost[long], -1
            crossing[at] = lands[long] + before[lands[long]]
            long += 1
        else:
            departures[at], arrivals[at] = departure[short], arrival[short]
            costs[at], revolutions[at] = cost[short], laps[short]
            crossing[at] = ranks[short] + min(math.ceil(arrival[short] / step), highest + 1)
            short += 1
    return Found(departures, arrivals, costs, revolutions, crossing)


@kernel
def of_pair(orbit_i, orbit_j, extra_delta_v, rule, times, duration, resolution):
    """All connections of a pair that no other one dominates.

    Parameters
    ----------
    orbit_i, orbit_j : (columns,) float64
        Rows of :data:`adr_opt.kernels.orbits.ORBIT_COLUMNS`.
    extra_delta_v : float
        As :func:`.transfer.prepare` takes it [m/s].
    rule : TransferRule
        Its time value is not looked at.
    times : Times
    duration : float
        Connections that arrive later are left out [s].
    resolution : float
        A connection that saves no more than this is dominated [m/s].

    Returns
    -------
    Found
        Long transfers have −1 revolutions.
    """
    pair = transfer.prepare(orbit_i, orbit_j, extra_delta_v, rule)
    departure, arrival, cost, laps = short(
        pair, rule, duration, times.interval, times.most, resolution
    )
    order = _by_departure(departure, arrival)
    shorts = order.size
    departure, arrival = chosen(departure, order, shorts), chosen(arrival, order, shorts)
    cost, laps = chosen(cost, order, shorts), chosen(laps, order, shorts)
    if times.longest < times.step:
        return Found(departure, arrival, cost, laps, _ranks(arrival))
    drifts = drift.prepare(orbit_i, orbit_j, rule.min_radius, rule.max_radius, rule.oblateness)
    kept = np.empty(shorts, np.bool_)
    leaves, lands, long_cost = drift.of_pair(
        drifts, rule.zones, times.step, times.longest, duration, times.most, resolution,
        departure, arrival, cost, kept,
    )  # fmt: skip
    return _merged(departure, arrival, cost, laps, kept, leaves, lands, long_cost, times.step)
