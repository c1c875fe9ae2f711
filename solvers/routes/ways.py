"""The timing oracle of the route engine: earliest arrivals and latest departures.

Where no tank runs dry on the way, being earlier is never worse, so that of each pair two functions
say all there is: the earliest end of a service after one is ready elsewhere, and the latest time of
being ready for an end. Both are looked up by halving: among breakpoints of a given function of
time, or among the given connections that arrive before all that depart later.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from adr_opt.common.constants import SLACK_S
from adr_opt.kernels.core.compile import inlined, kernel
from adr_opt.kernels.core.events import earliest_taken
from adr_opt.kernels.core.lists import first_at
from adr_opt.kernels.core.windows import Windows, latest_arrival, service_end, service_ends
from adr_opt.kernels.legs.given import leg_of
from adr_opt.legs.service_limits import limits_of
from adr_opt.mission.problem import Problem
from adr_opt.problem.chasers import AtStation
from adr_opt.problem.rules import FIRST
from adr_opt.problem.support import follows_all

FloatArray = npt.NDArray[np.float64]
IntArray = npt.NDArray[np.int64]

FOLLOWS = (FIRST - {"prizes that fall"}) | {
    "several chasers",
    "functions of time",
    "functions of time for several chasers",
    "capture windows",
}
"""Rules that the engine follows; missions with other rules go to other searches."""

ROUNDED = 1e-14
"""Relative rounding of a function's inverse, such that no departure becomes too late."""


class Ways(NamedTuple):
    """Legs between *nodes*: all bodies, then the start and the end of each chaser.

    Attributes
    ----------
    body : (nodes,) int64
        Body of each node; −1 for the end of a chaser that may end anywhere.
    first : (bodies² + 1,) int64
        Place of the first row of each pair of bodies: origin · bodies + destination.
    departure, arrival : (rows,) float64
        Breakpoints of functions, and connections, of which both times rise within a pair [s].
    is_function : (pairs,) bool
    cost : (pairs,) float64
        The most that a leg of a pair costs [m/s].
    least : (pairs,) float64
        No less is it from a ready time to the end of the service, +inf without a leg [s].
    least_into : (pairs,) float64
        The same by destination · bodies + origin, side by side for one destination.
    windows : Windows
        Of services at the nodes; that of a start opens when the chaser is ready there.
    service, closes : (nodes,) float64
        How long services take, and when they have to be over [s].
    bodies : int
    """

    body: IntArray
    first: IntArray
    departure: FloatArray
    arrival: FloatArray
    is_function: npt.NDArray[np.bool_]
    cost: FloatArray
    least: FloatArray
    least_into: FloatArray
    windows: Windows
    service: FloatArray
    closes: FloatArray
    bodies: int


@inlined
def pair_of(ways, a, b):
    """Number of the pair of bodies of two nodes; −1 if there is no leg between them."""
    pair = np.int64(-1)
    if ways.body[b] >= 0 and (a < ways.bodies or b < ways.bodies):
        pair = ways.body[a] * ways.bodies + ways.body[b]
    return pair


@inlined
def arrives(ways, a, b, ready):
    """Earliest end of the service at a node, from a ready time at another; +inf for none [s].

    A chaser that flies nowhere, or ends where it is, ends as it is ready.
    """
    pair = pair_of(ways, a, b)
    if pair < 0:
        return ready
    low, last = ways.first[pair], ways.first[pair + 1]
    lands = math.inf
    if ways.is_function[pair]:
        _, lands = leg_of(ways.departure, ways.arrival, low, last, ready)
    else:
        low = first_at(ways.departure, low, last, earliest_taken(ready))
        if low < last:
            lands = ways.arrival[low]
    return service_end(ways.windows, b, lands, ways.service[b])


@inlined
def _is_over(ways, b, row):
    """End of the service at a node after the arrival of a row; +inf if it may not begin [s]."""
    return service_end(ways.windows, b, ways.arrival[row], ways.service[b])


@inlined
def leaves(ways, a, b, latest):
    """Latest ready time at a node, to end by a time at another; −inf for none [s]."""
    pair = pair_of(ways, a, b)
    if pair < 0:
        return latest
    begin, last = ways.first[pair], ways.first[pair + 1]
    arrive = latest_arrival(ways.windows, b, latest - ways.service[b])
    # The end of the service decides who is in time, and a difference only where to look.
    low = first_at(ways.arrival, begin, last, arrive)
    while low > begin and not _is_over(ways, b, low - 1) <= latest:
        low -= 1
    while low < last and _is_over(ways, b, low) <= latest:
        low += 1
    if low == begin:
        return -math.inf
    known = ways.departure[low - 1]
    if low < last and ways.is_function[pair]:
        rise = ways.arrival[low] - ways.arrival[low - 1]
        share = (arrive - ways.arrival[low - 1]) / rise
        known += max(share - ROUNDED, 0.0) * (ways.departure[low] - known)
        known -= ROUNDED * abs(known)
    return known


@kernel
def _sift(pair, departure, end, kept):
    """Mark the connections of each pair that end earlier than all that depart later."""
    known = math.inf
    for c in range(pair.size - 1, -1, -1):
        if c + 1 < pair.size and pair[c + 1] != pair[c]:
            known = math.inf
        kept[c] = end[c] < known
        if kept[c]:
            known = end[c]


@kernel
def _least(first, departure, arrival, least):
    """Fill in the least time from departure to arrival of each pair [s]."""
    for pair in range(least.size):
        least[pair] = math.inf
        for row in range(first[pair], first[pair + 1]):
            least[pair] = min(least[pair], arrival[row] - departure[row])


def serves(problem: Problem) -> bool:
    """Whether only arrivals of legs matter: given legs whose costs never exhaust a tank.

    Or whose cost is a number for each pair, as of functions of time.
    """
    instance, given = problem.instance, problem.instance.given
    if given is None or not instance.targets or problem.connecting.corrections:
        return False
    if not follows_all(instance, FOLLOWS):
        return False
    dearest = float(given.cost.max(initial=0.0))
    return all(
        (len(instance.targets) + 1) * dearest
        <= mission.chaser.usable.delta_v_m_s - mission.chaser.spent_m_s - mission.reserve_m_s
        for mission in problem.missions
    )


def ways_of(problem: Problem) -> Ways:
    """The ways of a problem that the engine serves, without a timetable."""
    instance, given = problem.instance, problem.instance.given
    assert given is not None
    names, chasers = instance.names, instance.chasers
    bodies, begin = len(names), instance.first_target
    number = {name: body for body, name in enumerate(names)}
    limits = [limits_of(instance, chaser) for chaser in range(len(chasers))]
    everybody = limits_of(instance)
    ends = [number[c.end.station] if isinstance(c.end, AtStation) else -1 for c in chasers]
    starts = [instance.starts[chaser] for chaser in range(len(chasers))]
    nodes = [*range(bodies), *(n for pair in zip(starts, ends, strict=True) for n in pair)]
    body = np.array(nodes, dtype=np.int64)
    service, windows = everybody.service[body], everybody.windows.of(np.maximum(body, 0))
    for chaser, its in enumerate(limits):
        start, end = bodies + 2 * chaser, bodies + 2 * chaser + 1
        service[start] = 0.0
        windows = windows.only(start, its.ready, its.duration)
        latest = its.duration - service[end]
        latest = min(latest, windows.closing[end]) if ends[chaser] >= 0 else latest
        windows = windows.only(end, windows.opening[end], latest)
    closes = windows.closing + service
    named = np.array([number.get(name, -1) for name in given.names], dtype=np.int64)
    i, j = named[given.origin], named[given.destination]
    wanted = (i >= 0) & (j >= 0) & ((j >= begin) | np.isin(j, ends))
    pair, paid = (i * bodies + j)[wanted], given.cost[wanted]
    departure, arrival = given.departure[wanted], given.arrival[wanted]
    cost = np.zeros(bodies**2)
    np.maximum.at(cost, pair, paid)
    for chaser, its in enumerate(limits):
        if chasers[chaser].is_launched:  # it is wherever it first goes, once it is launched
            to = np.arange(begin, bodies)
            pair = np.append(pair, starts[chaser] * bodies + to)
            departure, arrival = (
                np.append(each, np.full(to.size, its.ready)) for each in (departure, arrival)
            )
    to = pair % bodies
    over = service_ends(everybody.windows, to, arrival, everybody.service[to])
    possible = np.isfinite(over)
    pair, over = pair[possible], over[possible]
    departure, arrival = departure[possible], arrival[possible]
    # Of those that leave together the first is the earliest: the others are dropped by it.
    order = np.lexsort((-arrival, departure, pair))
    kept = np.empty(order.size, dtype=np.bool_)
    _sift(pair[order], departure[order], over[order], kept)
    order = order[kept]
    pair, departure, arrival = pair[order], departure[order], arrival[order]
    is_function = np.zeros(bodies**2, dtype=np.bool_)
    functions = given.functions
    if functions is not None:
        named = np.array([number.get(name, -1) for name in functions.names], dtype=np.int64)
        i, j = named[functions.origin], named[functions.destination]
        wanted = (i >= 0) & (j >= 0) & ((j >= begin) | np.isin(j, ends))
        sizes = np.diff(functions.first)
        rows = np.repeat(wanted, sizes)
        is_function[(i * bodies + j)[wanted]] = True
        cost[(i * bodies + j)[wanted]] = functions.cost[wanted]
        pair = np.concatenate([pair, np.repeat(i * bodies + j, sizes)[rows]])
        departure = np.concatenate([departure, functions.departure[rows]])
        arrival = np.concatenate([arrival, functions.arrival[rows]])
        order = np.argsort(pair, kind="stable")
        pair, departure, arrival = pair[order], departure[order], arrival[order]
    first = np.searchsorted(pair, np.arange(bodies**2 + 1))
    least = np.empty(bodies**2)
    _least(first, departure, arrival, least)
    least += np.tile(everybody.service, bodies) - SLACK_S
    into = np.ascontiguousarray(least.reshape(bodies, bodies).T).ravel()
    return Ways(
        body,
        first,
        departure,
        arrival,
        is_function,
        cost,
        least,
        into,
        windows,
        service,
        closes,
        bodies,
    )
