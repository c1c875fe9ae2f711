"""The quickest connections of each pair: who is ready later arrives no earlier.

Where the end of the mission alone counts and no tank runs dry, the earliest arrival at a body makes
all others there superfluous. So of a pair those connections are kept that end earlier than all
that depart later. Both times then rise with the place of a connection, and either is looked up by
halving.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from adr_opt.kernels.core.compile import inlined, kernel
from adr_opt.kernels.core.events import earliest_taken
from adr_opt.kernels.core.windows import service_ends
from adr_opt.mission.mission import Mission

FloatArray = npt.NDArray[np.float64]
IntArray = npt.NDArray[np.int64]


class QuickestLegs(NamedTuple):
    """Undominated connections of all pairs, by origin and destination.

    Attributes
    ----------
    first : (bodies² + 1,) int64
        Place of the first connection of each pair: origin · bodies + destination.
    departure, end : (connections,) float64
        Departure, and end of the service at the destination; both rise within a pair [s].
    into : (pairs,) int64
        Bodies with a connection to a body, destination by destination.
    into_first : (bodies + 1,) int64
        Place of the first of each destination.
    bodies : int
    """

    first: IntArray
    departure: FloatArray
    end: FloatArray
    into: IntArray
    into_first: IntArray
    bodies: int


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


def quickest_legs(
    ends: tuple[npt.NDArray[np.integer], npt.NDArray[np.integer]],
    departure: FloatArray,
    end: FloatArray,
    *,
    bodies: int,
) -> QuickestLegs:
    """The table of some connections, in any order.

    Parameters
    ----------
    ends : tuple of (connections,) int
        Origins and destinations.
    departure, end : (connections,) float64
        [s].
    bodies : int
    """
    pair = ends[0].astype(np.int64) * bodies + ends[1]
    # Of those that leave together the first is the earliest: the others are dropped by it.
    order = np.lexsort((-end, departure, pair))
    pair, departure, end = pair[order], departure[order], end[order]
    kept = np.empty(pair.size, dtype=np.bool_)
    _sift(pair, departure, end, kept)
    pair, departure, end = pair[kept], departure[kept], end[kept]
    first = np.searchsorted(pair, np.arange(bodies**2 + 1))
    joined = np.unique(pair % bodies * bodies + pair // bodies)
    into_first = np.searchsorted(joined, np.arange(bodies + 1) * bodies)
    return QuickestLegs(first, departure, end, joined % bodies, into_first, bodies)


def quickest_legs_of(mission: Mission) -> QuickestLegs:
    """The table of a mission over given connections, without looking at its timetable."""
    instance, rules = mission.instance, mission.rules
    given, bodies = instance.given, rules.service.size
    assert given is not None
    number = {name: body for body, name in enumerate(instance.names)}
    bodies_of = np.array([number[name] for name in given.names], dtype=np.int64)
    origin, destination = bodies_of[given.origin], bodies_of[given.destination]
    end = service_ends(given.arrival, rules.opens[destination], rules.service[destination])
    closes = np.minimum(rules.closes, rules.duration)
    wanted = (end <= closes[destination]) & (destination >= rules.first_target)
    columns = origin, destination, given.departure, end
    kept = tuple(column[wanted] for column in columns)
    if mission.chaser.is_launched:
        first = mission.connecting.found(rules.start, rules.first_target)
        since = np.full(bodies - rules.first_target, float(first.departure[0]))
        to = np.arange(rules.first_target, bodies)
        ends = service_ends(since, rules.opens[to], rules.service[to])
        launches = np.full(to.size, rules.start), to, since, ends
        there = ends <= closes[to]
        kept = tuple(
            np.concatenate([some, more[there]]) for some, more in zip(kept, launches, strict=True)
        )
    return quickest_legs(kept[:2], *kept[2:], bodies=bodies)


@inlined
def arrives(legs, i, j, ready):
    """Earliest end at a body, from a ready time at another; +inf for none [s]."""
    pair = i * legs.bodies + j
    low, last = legs.first[pair], legs.first[pair + 1]
    high, earliest = last, earliest_taken(ready)
    while low < high:
        middle = (low + high) // 2
        if legs.departure[middle] < earliest:
            low = middle + 1
        else:
            high = middle
    return legs.end[low] if low < last else math.inf


@inlined
def leaves(legs, i, j, latest):
    """Latest ready time at a body, to end by a time at another; −inf for none [s]."""
    pair = i * legs.bodies + j
    begin = low = legs.first[pair]
    high = legs.first[pair + 1]
    while low < high:
        middle = (low + high) // 2
        if legs.end[middle] <= latest:
            low = middle + 1
        else:
            high = middle
    return legs.departure[low - 1] if low > begin else -math.inf


@inlined
def has_leg(legs, i, j):
    """Whether some connection leads from one body to another."""
    pair = i * legs.bodies + j
    return legs.first[pair] < legs.first[pair + 1]


@kernel
def shortest(legs):
    """Least time from departure to end of each pair [s]."""
    bodies = legs.bodies
    least = np.full((bodies, bodies), np.inf)
    for i in range(bodies):
        for j in range(bodies):
            pair = i * bodies + j
            for c in range(legs.first[pair], legs.first[pair + 1]):
                least[i, j] = min(least[i, j], legs.end[c] - legs.departure[c])
    return least
