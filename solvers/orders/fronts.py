"""How far an order of targets can be flown, from both of its ends, over many connections a pair.

Towards the end of the order: all ways to have come so far that are worth having, *stairs* of (time
ready, ΔV left), the later the richer. Towards its beginning: all that suffices to fly the rest,
stairs of (latest time ready, least ΔV needed). Between any two targets the chaser may refuel at a
station. An order can be flown if at one of its targets a way to have come there suffices for the
rest; so whether a target fits in between two others is answered without looking at the others.

Stairs that are hardly higher than the one before are left out: they cost plans, not legality.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from adr_opt.kernels.core.compile import inlined, kernel
from adr_opt.kernels.core.events import earliest_taken
from adr_opt.kernels.core.memory import borrowed

from ..beams.levels import STRAIGHT

MOST_STAIRS = 64

STEPS = 60
"""A stair is higher than the one before by this part of a tank."""


class ParetoFront(NamedTuple):
    """Stairs at several places, side by side.

    Attributes
    ----------
    size : (places,) int64
        Number of stairs.
    time : (places, MOST_STAIRS) float64
        Forwards: ready since, ascending; backwards: ready at the latest, descending [s].
    tank : (places, MOST_STAIRS) float64
        Forwards: ΔV left, ascending; backwards: ΔV needed, descending [m/s].
    parent, via : (places, MOST_STAIRS) int16
        Forwards only: stair at the place before, and station on the way or STRAIGHT.
    """

    size: np.ndarray
    time: np.ndarray
    tank: np.ndarray
    parent: np.ndarray
    via: np.ndarray


class Workspace(NamedTuple):
    """Memory to work in.

    Attributes
    ----------
    tank : (connections,) float64
        By connection of a pair [m/s].
    parent : (connections,) int16
        By connection of a pair.
    parts : ParetoFront
        Three places, for stairs before they are merged.
    """

    tank: np.ndarray
    parent: np.ndarray
    parts: ParetoFront


@kernel
def new_stairs(places):
    """Room for stairs."""
    return ParetoFront(
        np.zeros(places, np.int64), np.empty((places, MOST_STAIRS)),
        np.empty((places, MOST_STAIRS)), np.empty((places, MOST_STAIRS), np.int16),
        np.empty((places, MOST_STAIRS), np.int16),
    )  # fmt: skip


@kernel
def new_desk(lines):
    """Memory to work in, enough for any pair."""
    most = max(1, lines.total.max())
    return Workspace(np.empty(most), np.empty(most, np.int16), new_stairs(3))


@inlined
def first_at(numbers, low, high, least):
    """The first place in ascending numbers where they are at least so large."""
    while low < high:
        middle = (low + high) // 2
        if numbers[middle] < least:
            low = middle + 1
        else:
            high = middle
    return low


@inlined
def first_by_end(lines, begin, total, least):
    """The first place in the order of ends where they are at least so large."""
    low, high = 0, total
    while low < high:
        middle = (low + high) // 2
        if lines.end[begin + lines.by_end[begin + middle]] < least:
            low = middle + 1
        else:
            high = middle
    return low


@inlined
def put(stairs, place, size, time, tank, parent, via):
    """Add the next stair; returns how many there are."""
    stairs.time[place, size], stairs.tank[place, size] = time, tank
    stairs.parent[place, size], stairs.via[place, size] = parent, via
    return size + 1


@kernel
def _fly(lines, i, j, here, at, latest, step, desk, there, to, via):
    """Stairs that the connections of a pair lead to, none after a time; returns how many."""
    lines = borrowed(lines)
    here = borrowed(here)
    there = borrowed(there)
    desk = borrowed(desk)
    begin, total = lines.first[i, j], lines.total[i, j]
    size = here.size[at]
    if total == 0 or here.tank[at, size - 1] < lines.least[i, j]:
        return 0
    low = first_at(
        lines.departure, begin, begin + total, earliest_taken(here.time[at, 0])
    )  # fmt: skip
    stair, high = 0, low
    while high < begin + total and lines.departure[high] <= latest:
        while (
            stair + 1 < size and earliest_taken(here.time[at, stair + 1]) <= lines.departure[high]
        ):
            stair += 1
        desk.tank[high - begin] = here.tank[at, stair] - lines.delta_v[high]
        desk.parent[high - begin] = stair
        high += 1
    if high == low:
        return 0
    most = here.tank[at, stair] - lines.least[i, j] - step
    count, best = 0, -step
    for place in range(first_by_end(lines, begin, total, lines.departure[low]), total):
        c = np.int64(lines.by_end[begin + place])
        end = lines.end[begin + c]
        if end > latest:
            break
        if c < low - begin or c >= high - begin:
            continue
        left = desk.tank[c]
        if left < 0.0 or left <= best + step:
            continue
        best = left
        count = put(there, to, count, end, left, desk.parent[c], via)
        if count == MOST_STAIRS or best >= most:
            break
    return count


@kernel
def _refuelled(lines, i, s, here, at, latest):
    """When a chaser may be refuelled at a station at the earliest [s], and by which stair."""
    lines = borrowed(lines)
    here = borrowed(here)
    begin, total = lines.first[i, s], lines.total[i, s]
    size = here.size[at]
    if total == 0 or here.tank[at, size - 1] < lines.least[i, s]:
        return np.inf, 0
    ready = earliest_taken(here.time[at, 0])
    for place in range(first_by_end(lines, begin, total, ready), total):
        c = begin + lines.by_end[begin + place]
        if lines.end[c] > latest:
            break
        departure = lines.departure[c]
        if departure < ready:
            continue
        low, high = 0, size
        while low < high:
            middle = (low + high) // 2
            if earliest_taken(here.time[at, middle]) <= departure:
                low = middle + 1
            else:
                high = middle
        if here.tank[at, low - 1] >= lines.delta_v[c]:
            return lines.end[c], low - 1
    return np.inf, 0


@kernel
def _merge(count, parts, rest, step, to, at):
    """Merge two ascending staircases, at the places 0 and 1 of ``parts``."""
    parts = borrowed(parts)
    to = borrowed(to)
    a, b, size, best = 0, 0, 0, -step
    while (a < count or b < rest) and size < MOST_STAIRS:
        if b == rest or (a < count and parts.time[0, a] <= parts.time[1, b]):
            place, stair = 0, a
            a += 1
        else:
            place, stair = 1, b
            b += 1
        if parts.tank[place, stair] > best + step:
            best = parts.tank[place, stair]
            size = put(
                to, at, size, parts.time[place, stair], best, parts.parent[place, stair],
                parts.via[place, stair],
            )  # fmt: skip
    to.size[at] = size
    return size


@kernel
def forwards(rules, lines, i, j, refuels, here, at, latest, desk, there, to):
    """Stairs at the next target of an order, none after a time.

    Parameters
    ----------
    rules : Rules
    lines : Lines
    i, j : int
        Where the stairs ``at`` of ``here`` are, and the next target.
    refuels : bool
        Whether the chaser may come by a station: it has serviced a target since the last.
    latest : float
        [s].
    desk : Workspace
    there : ParetoFront
        Written at the place ``to``.

    Returns
    -------
    size : int
        0 if the target cannot be reached.
    """
    lines, here, there = borrowed(lines), borrowed(here), borrowed(there)
    desk = borrowed(desk)
    parts = desk.parts
    step = rules.budget / STEPS
    count = _fly(lines, i, j, here, at, latest, step, desk, parts, 0, STRAIGHT)
    size = _merge(count, parts, 0, step, there, to)
    if not refuels:
        return size
    for s in range(rules.stations):
        if s == i:
            continue
        full, stair = _refuelled(lines, i, s, here, at, latest)
        if full == np.inf:
            continue
        parts.size[2], parts.time[2, 0], parts.tank[2, 0] = 1, full, rules.budget
        rest = _fly(lines, s, j, parts, 2, latest, step, desk, parts, 1, s)
        for b in range(rest):
            parts.parent[1, b] = stair
        if rest > 0:
            for a in range(size):
                put(
                    parts, 0, a, there.time[to, a], there.tank[to, a], there.parent[to, a],
                    there.via[to, a],
                )  # fmt: skip
            size = _merge(size, parts, rest, step, there, to)
    return size


@kernel
def take(source, at, destination, to):
    """Copy stairs; whether the same ones were there."""
    source, destination = borrowed(source), borrowed(destination)
    size = source.size[at]
    same = destination.size[to] == size
    destination.size[to] = size
    for a in range(size):
        time, tank = source.time[at, a], source.tank[at, a]
        same = same and time == destination.time[to, a] and tank == destination.tank[to, a]
        destination.time[to, a], destination.tank[to, a] = time, tank
        destination.parent[to, a] = source.parent[at, a]
        destination.via[to, a] = source.via[at, a]
    return same


@inlined
def slack(came, at, suffices, to):
    """How much later a chaser might be and still fly the rest [s]; −inf if it cannot."""
    best, stair = -np.inf, 0
    size = came.size[at]
    for rest in range(suffices.size[to] - 1, -1, -1):
        while stair < size and came.tank[at, stair] < suffices.tank[to, rest]:
            stair += 1
        if stair == size:
            break
        best = max(best, suffices.time[to, rest] - came.time[at, stair])
    return best if best >= 0.0 else -np.inf
