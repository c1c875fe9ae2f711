"""Time-expanded network with waiting arcs: every connection once, at its own departure.

A chaser at a body waits from one departure event to the next one. So a *row* stands for a body at
a departure event: its moves are the connections that leave there and then, all to one destination,
and to wait for the next row. Times and ΔV are exact: this is what labels move on. Walks move on a
coarser one, see :mod:`.buckets`.

A leg is *stale* for a chaser that was ready when another one left for the same body that lands no
later and costs no more. Connections cannot tell, since a chaser ready in between has a use for
it. Of those that labels could take again and again while they wait, nearly all are stale.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from concurrent.futures import ThreadPoolExecutor
from typing import NamedTuple

import numpy as np

from adr_opt.common.stop import TimeIsOver
from adr_opt.kernels.core.compile import inlined, kernel
from adr_opt.kernels.core.events import earliest_taken
from adr_opt.kernels.core.lists import chosen, rising
from adr_opt.kernels.core.windows import service_end
from adr_opt.kernels.legs import connections
from adr_opt.kernels.legs.found import ConnectionArrays
from adr_opt.mission.mission import Mission

from .arrays import Network, joined

LOOK_BACK = 8
"""Number of earlier departures to compare each leg with; an omission is harmless."""


class RowLegs(NamedTuple):
    """Legs by row.

    Attributes
    ----------
    destination, first, delta_v
        As in :class:`.arrays.Network`.
    landing : (legs,) int32 or float64
        When legs land, in any measure of time.
    """

    destination: np.ndarray
    first: np.ndarray
    landing: np.ndarray
    delta_v: np.ndarray


@kernel
def mark_stale(begin, end, bodies, legs, since, fresh):
    """Find from which ready row on the legs of a body are dominated.

    Parameters
    ----------
    begin, end : int
        The rows of the body.
    bodies : int
    legs : RowLegs
    since : (legs,) int32
        Written: the leg is dominated for a chaser ready by this row; −1 for none.
    fresh : (rows,) int32
        Written: all legs of the row are dominated for a chaser ready by this row.
    """
    destination, first, landing, delta_v = legs
    earlier = np.full((bodies, LOOK_BACK), -1)
    for row in range(begin, end):
        ahead = earlier[destination[row]]
        for leg in range(first[row], first[row + 1]):
            since[leg] = -1
        for other in ahead:
            if other < 0:
                break
            least, at = np.inf, first[other]
            for leg in range(first[row], first[row + 1]):
                while at < first[other + 1] and landing[at] <= landing[leg]:
                    least = min(least, delta_v[at])
                    at += 1
                if since[leg] < 0 and least <= delta_v[leg]:
                    since[leg] = other
        fresh[row] = row
        for leg in range(first[row], first[row + 1]):
            fresh[row] = min(fresh[row], since[leg])
        for place in range(LOOK_BACK - 1, 0, -1):
            ahead[place] = ahead[place - 1]
        ahead[0] = row


class Outgoing(NamedTuple):
    """Rows and legs of one body, with local indices.

    Attributes
    ----------
    departure : (rows,) float64
        [s].
    destination : (rows,) int32
    first : (rows + 1,) int64
    delta_v : (legs,) float64
        [m/s].
    service : (legs,) int32
        Number of the service that the leg leads to: far fewer than legs, since all arrivals at
        a body from this one at one time are serviced by one time.
    end : (services,) float64
        End of it [s].
    body : (services,) int32
        Where it is.
    shortest : float
        Least time from departure to the end of service of any leg, +inf without any [s].
    """

    departure: np.ndarray
    destination: np.ndarray
    first: np.ndarray
    delta_v: np.ndarray
    service: np.ndarray
    end: np.ndarray
    body: np.ndarray
    shortest: float


@kernel
def _possible(j, departure, arrival, delta_v, crossing, rules, before, end):
    """Keep the connections to j that fit into the mission, at the front of their arrays.

    Of those that leave together none is kept that costs no less than one that arrives no later:
    corrections of what short transfers and those that drift cost may have left some.

    Parameters
    ----------
    departure, arrival, delta_v, crossing : (connections,)
        As in :mod:`adr_opt.kernels.legs.found`; crossings become numbers of services.
    before : int
        Services of the bodies before.
    end : (crossings,) float64
        Written: earliest end of service after an arrival there [s].

    Returns
    -------
    count : int
        Connections kept.
    rows : int
        Their departures.
    shortest : float
        [s].
    """
    count, rows, shortest = 0, 0, np.inf
    for c in range(departure.size):
        done = service_end(rules.windows, j, arrival[c], rules.service[j])
        together = count > 0 and departure[c] == departure[count - 1]
        if together and delta_v[c] >= delta_v[count - 1]:
            continue
        if delta_v[c] <= rules.budget and done < np.inf:
            end[crossing[c]] = min(end[crossing[c]], done)
            shortest = min(shortest, done - departure[c])
            rows += not together
            departure[count], delta_v[count] = departure[c], delta_v[c]
            crossing[count] = before + crossing[c]
            count += 1
    return count, rows, shortest


@inlined
def reachable(i, j, rules, is_start):
    """Whether a move is possible: not to the same body or a start orbit, no unearned refuelling.

    Nor from the start orbit of another chaser.
    """
    if i < rules.first_target and not rules.is_station[i] and not is_start[i]:
        return False
    if rules.is_station[j]:
        return i >= rules.first_target and i != j
    return j != i and j >= rules.first_target


@kernel
def found_of(i, j, leaving, orbits, extra_delta_v, transfer_rule, listed, last):
    """Connections of a pair: computed, or copied if listed.

    The same ones as schedules are made of: what a leg that comes too late dominates is gone.
    """
    # Compiled for one of the two: whether there are lists is told by a type.
    if listed is None:
        return connections.of_pair(
            leaving[i], orbits[j], extra_delta_v[i, j], transfer_rule, last, 0.0
        )
    begin = listed.first[j]
    size = listed.first[j + 1] - begin if last > 0.0 else 0
    departure, arrival, delta_v = np.empty(size), np.empty(size), np.empty(size)
    crossing = np.empty(size, np.int32)
    for c in range(size):
        departure[c], arrival[c] = listed.departure[begin + c], listed.arrival[begin + c]
        delta_v[c], crossing[c] = listed.delta_v[begin + c], listed.crossing[begin + c]
    none = np.empty(0, np.int8)  # neither laps nor families are asked for here
    return ConnectionArrays(departure, arrival, delta_v, none, crossing, none)


@kernel
def _from_body(i, leaving, orbits, extra_delta_v, transfer_rule, listed, rules, is_start):
    """All legs of a body that fit into the mission: an :class:`Outgoing`."""
    bodies = rules.service.size
    departures, costs, numbers = [np.empty(0)], [np.empty(0)], [np.empty(0, np.int32)]
    ends, counts = [np.empty(0)], np.empty(bodies, np.int64)
    rows, legs, services, shortest = 0, 0, 0, np.inf
    for j in range(bodies):
        last = rules.duration if reachable(i, j, rules, is_start) else -1.0
        departure, arrival, delta_v, _, crossing, _ = found_of(
            i, j, leaving, orbits, extra_delta_v, transfer_rule, listed, last
        )
        crossings = 0
        for c in range(crossing.size):
            crossings = max(crossings, crossing[c] + 1)
        end = np.empty(crossings)
        for q in range(crossings):
            end[q] = np.inf
        counts[j], more, least = _possible(
            j, departure, arrival, delta_v, crossing, rules, services, end
        )
        rows, legs, services = rows + more, legs + counts[j], services + crossings
        shortest = min(shortest, least)
        departures.append(departure)
        costs.append(delta_v)
        numbers.append(crossing)
        ends.append(end)
    time, destination = np.empty(rows), np.empty(rows, np.int32)
    end, body = np.empty(services), np.empty(services, np.int32)
    row, service = 0, 0
    for j in range(bodies):
        departure = departures[j + 1]
        for c in range(counts[j]):
            if c == 0 or departure[c] != departure[c - 1]:
                time[row], destination[row] = departure[c], j
                row += 1
        for done in ends[j + 1]:
            end[service], body[service] = done, j
            service += 1
    order = rising(time, rows)
    first, taken = np.empty(rows + 1, np.int64), np.zeros(bodies, np.int64)
    delta_v, number = np.empty(legs), np.empty(legs, np.int32)
    leg = 0
    for r in range(rows):
        j = destination[order[r]]
        departure, cost, own = departures[j + 1], costs[j + 1], numbers[j + 1]
        first[r] = leg
        c = taken[j]
        while c < counts[j] and departure[c] == time[order[r]]:
            delta_v[leg], number[leg] = cost[c], own[c]
            leg += 1
            c += 1
        taken[j] = c
    first[rows] = leg
    return Outgoing(
        chosen(time, order, rows),
        chosen(destination, order, rows),
        first,
        delta_v,
        number,
        end,
        body,
        shortest,
    )


@kernel
def _signpost(departure, start, duration, post):
    """First row of the body at or after equidistant times, as many as it has rows."""
    for i in range(start.size - 1):
        row, rows = start[i], start[i + 1] - start[i]
        for step in range(rows):
            # The closing row departs never.
            while departure[row] < duration * step / rows:
                row += 1
            post[start[i] + step] = row


@kernel
def _land(departure, start, post, duration, outgoing, landing, delta_v):
    """Landing rows and ΔV of a body's legs."""
    row_of = np.empty(outgoing.end.size, np.int32)
    for service in range(outgoing.end.size):
        # To a service that no leg leads to the end of time belongs, and the closing row.
        time, j = earliest_taken(outgoing.end[service]), outgoing.body[service]
        rows = start[j + 1] - start[j]
        # One step early, whatever is rounded.
        step = min(max(int(min(time / duration, 1.0) * rows) - 1, 0), rows - 1)
        row = post[start[j] + step]
        while departure[row] < time:
            row += 1
        row_of[service] = row
    for leg in range(landing.size):
        landing[leg] = row_of[outgoing.service[leg]]
        delta_v[leg] = outgoing.delta_v[leg]


def build(
    mission: Mission,
    *,
    others: Sequence[Mission] = (),
    jobs: int,
    with_ends: bool = False,
    over: Callable[[], bool] = lambda: False,
) -> Network:
    """The network of a mission.

    Parameters
    ----------
    mission : Mission
    others : sequence of Mission
        That move on it as well: they differ from the first in where and when they start alone, and
        none of them begins before it.
    jobs : int
        Threads. The network does not depend on it.
    with_ends : bool
        Whether ends of services are kept, for walks that pay for time. They are where prizes fall.
    over : callable
        Asked before each body.

    Raises
    ------
    TimeIsOver
    """
    inputs, rules = mission.transfer_inputs, mission.rules
    with_ends = with_ends or rules.falls is not None
    bodies = rules.service.size
    starting = [each.rules for each in (mission, *others)]
    launched = {each.start for each in starting}.intersection(mission.instance.launches)
    is_start = np.zeros(bodies, dtype=np.bool_)
    is_start[[each.start for each in starting]] = True

    def leaving(i: int) -> Outgoing:
        if over():
            raise TimeIsOver
        found: Outgoing = _from_body(i, *inputs, listed_of(mission, i), rules, is_start)
        return found

    with ThreadPoolExecutor(jobs) as pool:
        found = list(pool.map(leaving, range(bodies)))
        for i in launched:
            # It takes no time, so it stands before all that it leads to.
            found[i].departure[:] = min(0.0, rules.ready) - 1.0
        start = np.zeros(bodies + 1, dtype=np.int64)
        start[1:] = np.cumsum([outgoing.departure.size + 1 for outgoing in found])
        departure = np.full(int(start[-1]), math.inf)
        for i, outgoing in enumerate(found):
            departure[start[i] : start[i + 1] - 1] = outgoing.departure
        post = np.empty(departure.size, dtype=np.int32)
        _signpost(departure, start, rules.duration, post)
        first = joined([outgoing.first for outgoing in found])
        landing, since = np.empty((2, int(first[-1])), dtype=np.int32)
        delta_v, fresh = np.empty(landing.size), np.empty(departure.size, dtype=np.int32)
        end = np.empty(landing.size if with_ends else 0)
        destination = np.concatenate(
            [np.append(outgoing.destination, np.int32(i)) for i, outgoing in enumerate(found)]
        )

        def land(i: int) -> None:
            if over():
                raise TimeIsOver
            own = slice(first[start[i]], first[start[i + 1]])
            _land(departure, start, post, rules.duration, found[i], landing[own], delta_v[own])
            if with_ends:
                end[own] = found[i].end[found[i].service]
            # Within a row of landing, too, an earlier end is useful if time has a price.
            legs = RowLegs(destination, first, end if with_ends else landing, delta_v)
            mark_stale(start[i], start[i + 1], bodies, legs, since, fresh)

        list(pool.map(land, range(bodies)))
    flown = [each.shortest for i, each in enumerate(found) if i not in launched]
    shortest = min(rules.duration, *flown)
    roots = [
        start[each.start]
        + (
            0
            if each.start in launched
            else np.searchsorted(found[each.start].departure, earliest_taken(each.ready))
        )
        for each in starting
    ]
    return Network(
        start,
        departure,
        destination,
        first,
        landing,
        delta_v,
        since,
        fresh,
        rules.is_station,
        rules.may_end,
        np.array(roots, dtype=np.int64),
        shortest,
        end,
    )


class Listed(NamedTuple):
    """Connections of one origin, destination after destination.

    Attributes
    ----------
    first : (bodies + 1,) int64
        First connection to each destination.
    departure, arrival, delta_v : (connections,) float64
    crossing : (connections,) int32
        As in :class:`adr_opt.kernels.legs.found.ConnectionArrays`.
    """

    first: np.ndarray
    departure: np.ndarray
    arrival: np.ndarray
    delta_v: np.ndarray
    crossing: np.ndarray


def listed_of(mission: Mission, i: int) -> Listed | None:
    """Listed connections of an origin; None if they are computed one by one."""
    connecting = mission.connecting
    if not connecting.is_listed:
        return None
    there = [(j, connecting.found(i, j)) for j in range(len(mission.names)) if j != i]
    first = np.zeros(len(mission.names) + 1, dtype=np.int64)
    for j, found in there:
        first[j + 1] = found.departure.size
    # Of a station alone there is none, and arrays of nothing have to be of their kind.
    none, nowhere = np.empty(0), np.empty(0, dtype=np.int32)
    return Listed(
        np.cumsum(first),
        np.concatenate([none, *(found.departure for _, found in there)]),
        np.concatenate([none, *(found.arrival for _, found in there)]),
        np.concatenate([none, *(found.delta_v for _, found in there)]),
        np.concatenate([nowhere, *(found.crossing for _, found in there)]),
    )
