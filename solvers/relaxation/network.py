"""The time-expanded network with waiting arcs: every connection once, at its own departure.

A chaser at a body waits from one departure event to the next one. So a *row* stands for a body at
a departure event: its moves are the connections that leave there and then, all to one destination,
and to wait for the next row. Times and ΔV are exact: this is what labels move on. Walks move on a
coarser one, see :mod:`.buckets`.
"""

from __future__ import annotations

import math
from concurrent.futures import ThreadPoolExecutor
from typing import NamedTuple

import numpy as np

from adr_opt.kernels import connections
from adr_opt.kernels.compile import kernel
from adr_opt.kernels.lists import chosen, rising
from adr_opt.kernels.timetable import earliest_taken
from adr_opt.mission import Mission


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
        possible = np.empty(departure.size, np.int64)
        count = 0
        for c in range(departure.size):
            arrival[c] = max(arrival[c], rules.opens[j]) + rules.service[j]
            if delta_v[c] <= rules.budget and arrival[c] <= rules.closes[j]:
                possible[count] = c
                count += 1
        departures.append(chosen(departure, possible, count))
        ends.append(chosen(arrival, possible, count))
        costs.append(chosen(delta_v, possible, count))
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
    order = rising(time, rows)
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
    return Outgoing(chosen(time, order, rows), chosen(body, order, rows), first, end, delta_v)


@kernel
def _signpost(departure, start, duration, post):
    """First row of its body at or after each of as many equal steps of time as it has rows."""
    for i in range(start.size - 1):
        row, rows = start[i], start[i + 1] - start[i]
        for step in range(rows):
            # The closing row departs never.
            while departure[row] < duration * step / rows:
                row += 1
            post[start[i] + step] = row


@kernel
def _land(departure, start, post, duration, outgoing, landing):
    """Landing rows of a body's legs."""
    for r in range(outgoing.departure.size):
        j = outgoing.destination[r]
        rows = start[j + 1] - start[j]
        for leg in range(outgoing.first[r], outgoing.first[r + 1]):
            time = earliest_taken(outgoing.end[leg])
            # One step early, whatever is rounded.
            step = min(max(int(time / duration * rows) - 1, 0), rows - 1)
            row = post[start[j] + step]
            while departure[row] < time:
                row += 1
            landing[leg] = row


def build(mission: Mission, *, jobs: int) -> Network:
    """The network of a mission.

    Parameters
    ----------
    mission : Mission
    jobs : int
        Threads. The network does not depend on it.
    """
    inputs, rules = mission.transfer_inputs, mission.rules
    bodies = rules.service.size
    with ThreadPoolExecutor(jobs) as pool:
        found = list(pool.map(lambda i: _from_body(i, *inputs, rules), range(bodies)))
        start = np.zeros(bodies + 1, dtype=np.int64)
        start[1:] = np.cumsum([outgoing.departure.size + 1 for outgoing in found])
        departure = np.full(int(start[-1]), math.inf)
        for i, outgoing in enumerate(found):
            departure[start[i] : start[i + 1] - 1] = outgoing.departure
        post = np.empty(departure.size, dtype=np.int32)
        _signpost(departure, start, rules.duration, post)
        landings = [np.empty(outgoing.end.size, dtype=np.int32) for outgoing in found]
        list(
            pool.map(
                lambda i: _land(departure, start, post, rules.duration, found[i], landings[i]),
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
        joined([outgoing.first for outgoing in found]),
        np.concatenate(landings),
        np.concatenate([outgoing.delta_v for outgoing in found]),
        rules.is_station,
        rules.may_end,
        int(start[rules.start] + np.searchsorted(ahead, earliest_taken(rules.ready))),
        shortest,
    )


def joined(firsts: list[np.ndarray]) -> np.ndarray:
    """One list of first legs out of those of all bodies; what closes a body has none."""
    before = np.cumsum([0, *(int(first[-1]) for first in firsts)])
    parts = [first + legs for first, legs in zip(firsts, before[:-1], strict=True)]
    return np.append(np.concatenate(parts), before[-1])
