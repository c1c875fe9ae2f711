"""Tours of all places with the earliest end, where a few ways may be exceptions.

Given are earliest arrivals by ready time, with waiting allowed, so that being ready later never
leads to an earlier arrival. Of all states with the same places done, the same last place and
equal exceptions used, the earliest is therefore never worse than another (Held and Karp, 1962),
nor is one with fewer exceptions that is no later. Level by level all such states are kept, or the
earliest of them if there are too many. If none was left out, the tour found is the best one.

Ways that are no exceptions often join few places with each other; states from which what is left
can be met in no order without more exceptions than are left are gone.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from adr_opt.kernels.core.compile import inlined, kernel

MOST_PLACES = 58
"""Maximum number of places: a set of places, the last place and the exceptions used are packed in
words of 64 and 16 bits."""

ONE = np.uint64(1)
ROOM = 0.7
"""Maximum load of a hash table."""


class Arrivals(NamedTuple):
    """Earliest arrivals.

    Attributes
    ----------
    step : float
        Of the times at which one may be ready.
    row : (2, places, places) int64
        Where the arrivals of a way stand, usual ones and exceptions; −1 where there is no way.
    arrival : (rows, times) float64 or float32
        For ready times from ``k step`` on and before ``(k + 1) step``. Never falls with k;
        infinite where there is none. There are no departures later than the last time.
    near : (places,) uint64
        Bit j where a usual way leads to j or from it.
    exceptions : int
        How many there may be.
    linear : bool
        Between two times that are less than ``3 step`` apart arrivals are linear, else those of the
        later time: ``arrival[k]`` is that of a ready time ``k step``.
    """

    step: float
    row: npt.NDArray[np.int64]
    arrival: npt.NDArray[np.floating]
    near: npt.NDArray[np.uint64]
    exceptions: int
    linear: bool


class States(NamedTuple):
    """States of a level: places done, last place, exceptions used, time, and predecessor."""

    done: npt.NDArray[np.uint64]
    here: npt.NDArray[np.int64]
    used: npt.NDArray[np.int64]
    time: npt.NDArray[np.float64]
    parent: npt.NDArray[np.int64]


def chosen(states: States, places: npt.NDArray[np.int64] | npt.NDArray[np.bool_]) -> States:
    """A selection of a level's states, in an order."""
    return States(
        states.done[places], states.here[places], states.used[places], states.time[places],
        states.parent[places],
    )  # fmt: skip


def room_for(size: int) -> States:
    """Storage for states."""
    return States(
        np.empty(size, np.uint64), np.empty(size, np.int64), np.empty(size, np.int64),
        np.empty(size), np.empty(size, np.int64),
    )  # fmt: skip


class Found(NamedTuple):
    """Outcome of a search.

    Attributes
    ----------
    end : float
        Of the best tour; infinite if there is none.
    order : tuple of int
    exceptional : tuple of bool
        By way.
    whole : bool
        No state was left out, so that no tour ends earlier (and before the limit of the search).
    levels : tuple of States
    """

    end: float
    order: tuple[int, ...]
    exceptional: tuple[bool, ...]
    whole: bool
    levels: tuple[States, ...]


def arrivals_of(
    step: float,
    usual: npt.NDArray[np.floating],
    special: npt.NDArray[np.floating],
    exceptions: int,
    *,
    linear: bool = False,
) -> Arrivals:
    """Arrivals from complete tables.

    Parameters
    ----------
    step : float
    usual, special : (places, places, times) float64
        As :attr:`Arrivals.arrival`, infinite where there is no way.
    exceptions : int
    linear : bool
    """
    both = np.stack([usual, special])
    there = np.asarray(np.isfinite(both).any(axis=3))
    row = np.full(there.shape, -1, dtype=np.int64)
    row[there] = np.arange(there.sum())
    return Arrivals(step, row, both[there], near_of(there[0]), exceptions, linear)


def near_of(there: npt.NDArray[np.bool_]) -> npt.NDArray[np.uint64]:
    """Sets of places with a way from or to each place."""
    joined = there | there.T
    return np.array(
        [sum(1 << int(j) for j in np.flatnonzero(line)) for line in joined], dtype=np.uint64
    )


@inlined
def _size(members):
    """Number of places in a set."""
    members = members - ((members >> ONE) & np.uint64(0x5555555555555555))
    pairs = np.uint64(0x3333333333333333)
    members = (members & pairs) + ((members >> np.uint64(2)) & pairs)
    members = (members + (members >> np.uint64(4))) & np.uint64(0x0F0F0F0F0F0F0F0F)
    return int((members * np.uint64(0x0101010101010101)) >> np.uint64(56))


@kernel
def exceptions_needed(left, here, near):
    """Lower bound on the exceptions needed by the rest of a tour.

    A place with fewer than two usual ways to others that count has the rest of its two by
    exception, but the last place, wherever it is, has one less; and what no usual ways hold
    together is joined by exceptions.

    Parameters
    ----------
    left : uint64
        Set of places to be met.
    here : int
        From which one goes on.
    near : (places,) uint64
    """
    if left == 0:
        return 0
    whole = left | (ONE << np.uint64(here))
    missing = 0 if near[here] & left else 1
    last = 0
    for place in range(near.size):
        if (left >> np.uint64(place)) & ONE:
            ways = _size(near[place] & whole)
            if ways < 2:
                missing += 2 - ways
                last = 1
    parts = 0
    rest = whole
    while rest:
        parts += 1
        edge = rest & (~rest + ONE)
        part = edge
        while edge:
            beyond = np.uint64(0)
            for place in range(near.size):
                if (edge >> np.uint64(place)) & ONE:
                    beyond |= near[place]
            edge = beyond & rest & ~part
            part |= edge
        rest &= ~part
    return max((missing - last + 1) // 2, parts - 1)


@inlined
def _arrival(arrivals, kind, i, j, time):
    """Arrival from a ready time."""
    row = arrivals.row[kind, i, j]
    if row < 0:
        return math.inf
    line = arrivals.arrival[row]
    k = int(time / arrivals.step)
    if k >= line.size - arrivals.linear:
        return math.inf
    if not arrivals.linear:
        return max(float(line[k]), time)
    here, then = float(line[k]), float(line[k + 1])
    if not then - here <= 3.0 * arrivals.step:
        return then
    return max(here + (time / arrivals.step - k) * (then - here), time)


@inlined
def _place_of(done, here, used, table, filled):
    """Index of a state in a hash table, present or not."""
    mask = np.uint64(filled.size - 1)
    mixed = (done * np.uint64(0x9E3779B97F4A7C15)) ^ (
        np.uint64(here * 64 + used) * np.uint64(0xC2B2AE3D27D4EB4F)
    )
    mixed = (mixed ^ (mixed >> np.uint64(29))) * np.uint64(0xBF58476D1CE4E5B9)
    place = (mixed >> np.uint64(13)) & mask
    while filled[place] and not (
        table.done[place] == done and table.here[place] == here and table.used[place] == used
    ):
        place = (place + ONE) & mask
    return place


@kernel
def _extend(arrivals, states, latest, table, filled):
    """All successors that arrive by ``latest``, written to a table; returns whether all fit."""
    whole, found = True, 0
    every = (ONE << np.uint64(arrivals.near.size)) - ONE
    for state in range(states.here.size):
        left = every & ~states.done[state]
        here, used, time = states.here[state], states.used[state], states.time[state]
        for j in range(arrivals.near.size):
            bit = ONE << np.uint64(j)
            if not left & bit:
                continue
            needed, sooner = -1, math.inf
            for kind in range(min(arrivals.exceptions - used, 1) + 1):
                arrival = _arrival(arrivals, kind, here, j, time)
                if arrival > latest or arrival >= sooner:
                    continue
                sooner = arrival
                done = states.done[state] | bit
                place = _place_of(done, j, used + kind, table, filled)
                if not filled[place]:
                    if needed < 0:
                        needed = exceptions_needed(left & ~bit, j, arrivals.near)
                    if used + kind + needed > arrivals.exceptions:
                        continue
                    if found >= ROOM * filled.size:
                        whole = False
                        continue
                    found += 1
                    filled[place] = True
                    table.done[place], table.here[place] = done, j
                    table.used[place], table.time[place] = used + kind, math.inf
                if arrival < table.time[place]:
                    table.time[place], table.parent[place] = arrival, state
    return whole


def _survivors(level: States, exceptions: int, width: int) -> tuple[States, bool]:
    """Undominated states, the earliest of them; returns whether these are all."""
    order = np.lexsort((level.used, level.here, level.done))
    level = chosen(level, order)
    kept = np.ones(level.here.size, dtype=bool)
    for lag in range(1, min(exceptions + 1, level.here.size)):
        alike = level.done[lag:] == level.done[:-lag]
        alike &= level.here[lag:] == level.here[:-lag]
        kept[lag:] &= ~(alike & (level.time[:-lag] <= level.time[lag:]))
    places = np.flatnonzero(kept)
    whole = places.size <= width
    places = places[np.argsort(level.time[places], kind="stable")[:width]]
    return chosen(level, places), whole


def earliest_tour(
    arrivals: Arrivals, latest: float, *, width: int = 1_000_000, begin: float = 0.0
) -> Found:
    """The tour of all places with the earliest end, from any of them.

    Parameters
    ----------
    arrivals : Arrivals
    latest : float
        No tour that ends later is looked for.
    width : int
        States of a level that are kept.
    begin : float
    """
    count = arrivals.near.size
    if count > MOST_PLACES:
        raise ValueError(f"{count} places; at most {MOST_PLACES}")
    numbers = np.arange(count, dtype=np.int64)
    zeros = np.zeros(count, dtype=np.int64)
    done = ONE << numbers.astype(np.uint64)
    levels = [States(done, numbers, zeros, np.full(count, begin), zeros)]
    whole = True
    room = 1 << 12
    while len(levels) < count:
        while True:
            table = room_for(room)
            filled = np.zeros(room, dtype=np.bool_)
            fitted = bool(_extend(arrivals, levels[-1], latest, table, filled))
            if fitted or room >= 8 * width:
                break
            room *= 4
        level = chosen(table, np.flatnonzero(filled))
        level, all_kept = _survivors(level, arrivals.exceptions, width)
        whole = whole and fitted and all_kept
        levels.append(level)
        if not level.here.size:
            return Found(math.inf, (), (), whole, tuple(levels))
    best = int(np.argmin(levels[-1].time))
    end = float(levels[-1].time[best])
    order, used = [], []
    for level in levels[::-1]:
        order.append(int(level.here[best]))
        used.append(int(level.used[best]))
        best = int(level.parent[best])
    steps = np.diff(used[::-1])
    return Found(end, tuple(order[::-1]), tuple(bool(one) for one in steps), whole, tuple(levels))
