"""The time-expanded network with waiting arcs: every connection once, at its own departure.

A chaser at a body waits from one departure event to the next one. So a *row* stands for a body at
a departure event: its moves are the connections that leave there and then, all to one destination,
and to wait for the next row. Times are exact. ΔV is exact for labels, and in slots, rounded down,
for walks; there many connections become superfluous, because they cost no less in slots and land
no earlier than another one that leaves no earlier.
"""

from __future__ import annotations

import math
from concurrent.futures import ThreadPoolExecutor
from typing import NamedTuple

import numpy as np

from adr_opt.kernels import connections
from adr_opt.kernels.compile import kernel
from adr_opt.kernels.timetable import earliest_taken
from adr_opt.mission import Mission

SLACK = 1e-9
"""Guard of roundings to slots, always in the optimistic direction [slots]."""


class Network(NamedTuple):
    """Rows, body after body, each body's in order of departure, and their legs.

    One row more closes each body: nothing leaves any more.

    Attributes
    ----------
    start : (bodies + 1,) int64
        First row of each body.
    departure : (rows,) float64
        [s]; +inf in closing rows.
    destination : (rows,) int32
        Of all legs of the row.
    first : (rows + 1,) int64
        First leg of each row; the legs of a row in order of arrival.
    landing : (legs,) int32
        Row of the destination at the end of service.
    delta_v : (legs,) float64
        [m/s].
    first_kept : (rows + 1,) int64
    landing_kept, cost : (legs kept,) int32
        The legs that count when ΔV is in slots, and their slots.
    least : (legs kept,) float64
        Least ΔV of any leg between the same bodies in so many slots [m/s].
    is_station, may_end : (bodies,) bool
        As in :class:`adr_opt.kernels.rules.Rules`.
    root : int
        Row at which the mission begins.
    shortest : float
        Least time from departure to the end of service of any leg [s].
    """

    start: np.ndarray
    departure: np.ndarray
    destination: np.ndarray
    first: np.ndarray
    landing: np.ndarray
    delta_v: np.ndarray
    first_kept: np.ndarray
    landing_kept: np.ndarray
    cost: np.ndarray
    least: np.ndarray
    is_station: np.ndarray
    may_end: np.ndarray
    root: int
    shortest: float


class Outgoing(NamedTuple):
    """Rows and legs of one body, counted within it.

    Attributes
    ----------
    departure : (rows,) float64
        [s].
    destination : (rows,) int32
    first : (rows + 1,) int64
    end : (legs,) float64
        End of service [s].
    delta_v : (legs,) float64
        [m/s].
    """

    departure: np.ndarray
    destination: np.ndarray
    first: np.ndarray
    end: np.ndarray
    delta_v: np.ndarray


@kernel
def _from_body(i, orbits, extra_delta_v, transfer_rule, rules):
    """All legs of a body that fit into the mission: an :class:`Outgoing`."""
    bodies = rules.service.size
    departures = [np.empty(0)]
    ends = [np.empty(0)]
    costs = [np.empty(0)]
    for j in range(bodies):
        # Nobody goes to where he is, back to an orbit that is no body's, or to refuel unearned.
        reachable = j != i and j >= rules.first_target
        if rules.is_station[j]:
            reachable = i >= rules.first_target
        # The same lists as schedules are made of: what a leg that comes too late dominates is gone.
        last = rules.duration if reachable else -1.0
        departure, arrival, delta_v, _ = connections.of_pair(
            orbits[i], orbits[j], extra_delta_v[i, j], transfer_rule, last, 0.0
        )
        end = np.maximum(arrival, rules.opens[j]) + rules.service[j]
        possible = (delta_v <= rules.budget) & (end <= rules.closes[j])
        departures.append(departure[possible])
        ends.append(end[possible])
        costs.append(delta_v[possible])
    rows, legs = 0, 0
    for j in range(bodies):
        departure = departures[j + 1]
        legs += departure.size
        for c in range(departure.size):
            rows += c == 0 or departure[c] != departure[c - 1]
    time = np.empty(rows)
    body = np.empty(rows, np.int32)
    begin = np.empty(rows, np.int64)
    row = 0
    for j in range(bodies):
        departure = departures[j + 1]
        for c in range(departure.size):
            if c == 0 or departure[c] != departure[c - 1]:
                time[row], body[row], begin[row] = departure[c], j, c
                row += 1
    order = np.argsort(time, kind="mergesort")
    first = np.empty(rows + 1, np.int64)
    end, delta_v = np.empty(legs), np.empty(legs)
    leg = 0
    for r in range(rows):
        q = order[r]
        j = body[q]
        departure = departures[j + 1]
        first[r] = leg
        c = begin[q]
        while c < departure.size and departure[c] == time[q]:
            end[leg], delta_v[leg] = ends[j + 1][c], costs[j + 1][c]
            leg += 1
            c += 1
    first[rows] = leg
    return Outgoing(time[order], body[order], first, end, delta_v)


@kernel
def _land(departure, start, outgoing, slot, slots, landing):
    """Landing rows of a body's legs, and which of them count in slots.

    Returns
    -------
    first_kept : (rows + 1,) int64
    landing_kept, cost : (legs kept,) int32
    least : (legs kept,) float64
    """
    bodies = start.size - 1
    time, body, first, end, delta_v = outgoing
    legs = end.size
    # Earliest landing row of the later legs to a body that cost no more than so many slots.
    earliest = np.full((bodies, slots), np.int32(2**31 - 1), np.int32)
    cheapest = np.full((bodies, slots), np.inf)
    kept = np.zeros(legs, np.bool_)
    price = np.empty(legs, np.int32)
    size = 0
    for r in range(time.size - 1, -1, -1):
        j = body[r]
        ahead = departure[start[j] : start[j + 1] - 1]
        for leg in range(first[r], first[r + 1]):
            landing[leg] = start[j] + np.searchsorted(ahead, earliest_taken(end[leg]))
            price[leg] = max(0, math.floor(delta_v[leg] / slot - SLACK))
            cheapest[j, price[leg]] = min(cheapest[j, price[leg]], delta_v[leg])
            if earliest[j, price[leg]] <= landing[leg]:
                continue
            kept[leg] = True
            size += 1
            for c in range(price[leg], slots):
                if earliest[j, c] <= landing[leg]:
                    break
                earliest[j, c] = landing[leg]
    first_kept = np.empty(time.size + 1, np.int64)
    landing_kept, cost = np.empty(size, np.int32), np.empty(size, np.int32)
    least = np.empty(size)
    at = 0
    for r in range(time.size):
        first_kept[r] = at
        for leg in range(first[r], first[r + 1]):
            if kept[leg]:
                landing_kept[at], cost[at] = landing[leg], price[leg]
                least[at] = cheapest[body[r], price[leg]]
                at += 1
    first_kept[time.size] = at
    return first_kept, landing_kept, cost, least


def build(mission: Mission, slot_m_s: float, *, jobs: int) -> Network:
    """The network of a mission.

    Parameters
    ----------
    mission : Mission
    slot_m_s : float
        Slot of the ΔV axis of walks [m/s].
    jobs : int
        Threads. The network does not depend on it.
    """
    inputs, rules = mission.transfer_inputs, mission.rules
    bodies = rules.service.size
    slots = math.floor(rules.budget / slot_m_s + SLACK) + 1
    with ThreadPoolExecutor(jobs) as pool:
        found = list(pool.map(lambda i: _from_body(i, *inputs, rules), range(bodies)))
        start = np.zeros(bodies + 1, dtype=np.int64)
        start[1:] = np.cumsum([outgoing.departure.size + 1 for outgoing in found])
        departure = np.full(int(start[-1]), math.inf)
        for i, outgoing in enumerate(found):
            departure[start[i] : start[i + 1] - 1] = outgoing.departure
        landings = [np.empty(outgoing.end.size, dtype=np.int32) for outgoing in found]
        kept = list(
            pool.map(
                lambda i: _land(departure, start, found[i], slot_m_s, slots, landings[i]),
                range(bodies),
            )
        )
    shortest = rules.duration
    for outgoing in found:
        if outgoing.end.size:
            left = np.repeat(outgoing.departure, np.diff(outgoing.first))
            shortest = min(shortest, float((outgoing.end - left).min()))
    ahead = found[rules.start].departure
    return Network(
        start,
        departure,
        np.concatenate(
            [np.append(outgoing.destination, np.int32(i)) for i, outgoing in enumerate(found)]
        ),
        _joined([outgoing.first for outgoing in found]),
        np.concatenate(landings),
        np.concatenate([outgoing.delta_v for outgoing in found]),
        _joined([each[0] for each in kept]),
        np.concatenate([each[1] for each in kept]),
        np.concatenate([each[2] for each in kept]),
        np.concatenate([each[3] for each in kept]),
        rules.is_station,
        rules.may_end,
        int(start[rules.start] + np.searchsorted(ahead, earliest_taken(rules.ready))),
        shortest,
    )


def _joined(firsts: list[np.ndarray]) -> np.ndarray:
    """One list of first legs out of those of all bodies; closing rows have none."""
    before = np.cumsum([0, *(int(first[-1]) for first in firsts)])
    parts = [first + legs for first, legs in zip(firsts, before[:-1], strict=True)]
    return np.append(np.concatenate(parts), before[-1])
