"""Pareto fronts of (time, ΔV) along an order of targets, over many connections per pair.

Forwards, the Pareto front at a target has the ways to have come so far that are worth having:
points of (time ready, ΔV left), the later the richer. Backwards it has what suffices to fly the
rest: points of (latest time ready, least ΔV needed). Between any two targets the chaser may refuel
at a station. An order can be flown if at one of its targets a way to have come there suffices for
the rest; so whether a target fits in between two others is answered without looking at the others.

Points that are hardly better than the one before are left out: they cost plans, not legality. As
all connections of a pair are flown at once, and services leave ΔV as it is, fronts are staircases
of two numbers and not :class:`adr_opt.kernels.rules.resources.Resources`.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from adr_opt.kernels.core.compile import inlined, kernel
from adr_opt.kernels.core.events import earliest_taken
from adr_opt.kernels.core.lists import first_at
from adr_opt.kernels.core.memory import borrowed

from ..beams.levels import STRAIGHT
from .connection_table import STEPS

MOST_POINTS = 64

DIRECT, BY_STATION, AT_STATION = 0, 1, 2
"""Indices of the parts of a front: direct arrival, arrival via a station, and at the station."""


class ParetoFront(NamedTuple):
    """Pareto fronts at several places, as columns.

    Attributes
    ----------
    size : (places,) int64
        Number of points.
    time : (places, MOST_STAIRS) float64
        Forwards: ready since, ascending; backwards: ready at the latest, descending [s].
    tank : (places, MOST_STAIRS) float64
        Forwards: ΔV left, ascending; backwards: ΔV needed, descending [m/s].
    parent, via : (places, MOST_STAIRS) int16
        Forwards only: point at the place before, and station on the way or STRAIGHT.
    """

    size: np.ndarray
    time: np.ndarray
    tank: np.ndarray
    parent: np.ndarray
    via: np.ndarray


class Workspace(NamedTuple):
    """Scratch arrays.

    Attributes
    ----------
    before : (places + 1,) int64
        Body before each position of an order.
    room : (places + 1,) float64
        Time between being ready there and having to be ready at the next body [s].
    tank : (connections,) float64
        By connection of a pair [m/s].
    parent : (connections,) int16
        By connection of a pair.
    parts : ParetoFront
        Three places, for fronts before they are merged.
    trial : ParetoFront
        Two places, for fronts that are tried.
    """

    before: np.ndarray
    room: np.ndarray
    tank: np.ndarray
    parent: np.ndarray
    parts: ParetoFront
    trial: ParetoFront


@kernel
def new_front(places):
    """Empty storage for fronts."""
    return ParetoFront(
        np.zeros(places, np.int64),
        np.empty((places, MOST_POINTS)),
        np.empty((places, MOST_POINTS)),
        np.empty((places, MOST_POINTS), np.int16),
        np.empty((places, MOST_POINTS), np.int16),
    )


@kernel
def new_workspace(connections):
    """Scratch arrays, large enough for any pair."""
    most = max(1, connections.total.max())
    places = connections.total.shape[0] + 1
    return Workspace(
        np.empty(places, np.int64),
        np.empty(places),
        np.empty(most),
        np.empty(most, np.int16),
        new_front(3),
        new_front(2),
    )


@inlined
def first_by_end(connections, begin, total, least):
    """First index in the order of ends of at least a value."""
    low, high = 0, total
    while low < high:
        middle = (low + high) // 2
        if connections.end[begin + connections.by_end[begin + middle]] < least:
            low = middle + 1
        else:
            high = middle
    return low


@inlined
def put(front, place, size, time, tank, parent, via):
    """Append a point; returns the new number of points."""
    front.time[place, size], front.tank[place, size] = time, tank
    front.parent[place, size], front.via[place, size] = parent, via
    return size + 1


@kernel
def _fly(connections, i, j, here, at, latest, workspace, to):
    """Points reached by a pair's connections up to a time; returns their number.

    They are written into the parts of the workspace at ``to``, DIRECT or BY_STATION, which is i.
    """
    connections = borrowed(connections)
    here = borrowed(here)
    workspace = borrowed(workspace)
    there, step = workspace.parts, connections.budget / STEPS
    via = STRAIGHT if to == DIRECT else i
    begin, total = connections.first[i, j], connections.total[i, j]
    size = here.size[at]
    if total == 0 or here.tank[at, size - 1] < connections.least[i, j]:
        return 0
    low = first_at(connections.departure, begin, begin + total, earliest_taken(here.time[at, 0]))
    # From a single point ΔV left need not be worked out beforehand; most searches end early.
    alone = size == 1
    point, high = 0, begin + total if alone else low
    until = latest - connections.shortest[i, j]
    while not alone and high < begin + total and connections.departure[high] <= until:
        while (
            point + 1 < size
            and earliest_taken(here.time[at, point + 1]) <= connections.departure[high]
        ):
            point += 1
        workspace.tank[high - begin] = here.tank[at, point] - connections.delta_v[high]
        workspace.parent[high - begin] = point
        high += 1
    if high == low or connections.departure[low] > until:
        return 0
    soonest = connections.departure[low] + connections.shortest[i, j]
    most = here.tank[at, point] - connections.least[i, j] - step
    count, best = 0, -step
    for place in range(first_by_end(connections, begin, total, soonest), total):
        c = np.int64(connections.by_end[begin + place])
        end = connections.end[begin + c]
        if end > latest:
            break
        if c < low - begin or c >= high - begin:
            continue
        left = here.tank[at, 0] - connections.delta_v[begin + c] if alone else workspace.tank[c]
        if left < 0.0 or left <= best + step:
            continue
        best = left
        parent = 0 if alone else np.int64(workspace.parent[c])
        count = put(there, to, count, end, left, parent, via)
        if count == MOST_POINTS or best >= most:
            break
    return count


@kernel
def _refuelled(connections, i, s, here, latest):
    """Earliest refuelling at a station [s], and the point it comes from."""
    connections = borrowed(connections)
    here = borrowed(here)
    begin, total = connections.first[i, s], connections.total[i, s]
    size = here.size[i]
    if total == 0 or here.tank[i, size - 1] < connections.least[i, s]:
        return np.inf, 0
    ready = earliest_taken(here.time[i, 0])
    soonest = ready + connections.shortest[i, s]
    for place in range(first_by_end(connections, begin, total, soonest), total):
        c = begin + connections.by_end[begin + place]
        if connections.end[c] > latest:
            break
        departure = connections.departure[c]
        if departure < ready:
            continue
        low, high = 0, size
        while low < high:
            middle = (low + high) // 2
            if earliest_taken(here.time[i, middle]) <= departure:
                low = middle + 1
            else:
                high = middle
        if here.tank[i, low - 1] >= connections.delta_v[c]:
            return connections.end[c], low - 1
    return np.inf, 0


@kernel
def _merge(count, parts, rest, step, to, at):
    """Merge two ascending fronts, at indices 0 and 1 of ``parts``."""
    parts = borrowed(parts)
    to = borrowed(to)
    a, b, size, best = 0, 0, 0, -step
    while (a < count or b < rest) and size < MOST_POINTS:
        if b == rest or (a < count and parts.time[0, a] <= parts.time[1, b]):
            place, point = 0, a
            a += 1
        else:
            place, point = 1, b
            b += 1
        if parts.tank[place, point] > best + step:
            best = parts.tank[place, point]
            size = put(
                to,
                at,
                size,
                parts.time[place, point],
                best,
                parts.parent[place, point],
                parts.via[place, point],
            )
    to.size[at] = size
    return size


@kernel
def forwards(rules, connections, i, j, refuels, here, latest, workspace):
    """Front at the next target of an order up to a time, for a trial: index 0.

    Parameters
    ----------
    rules : Rules
    connections : ConnectionTable
    i, j : int
        Where the chaser comes from, and the next target.
    refuels : bool
        Whether the chaser may come by a station: it has serviced a target since the last.
    here : ParetoFront
        By body; the one at ``i`` counts.
    latest : float
        [s].
    workspace : Workspace
        The front is written into its trial.

    Returns
    -------
    size : int
        0 if the target cannot be reached.
    """
    connections, here, workspace = borrowed(connections), borrowed(here), borrowed(workspace)
    parts, there = workspace.parts, workspace.trial
    step = connections.budget / STEPS
    count = _fly(connections, i, j, here, i, latest, workspace, DIRECT)
    size = _merge(count, parts, 0, step, there, 0)
    if not refuels:
        return size
    for s in range(rules.stations):
        if s == i or connections.total[i, s] == 0 or connections.total[s, j] == 0:
            continue
        full, point = _refuelled(connections, i, s, here, latest)
        if full == np.inf:
            continue
        parts.size[AT_STATION] = 1
        parts.time[AT_STATION, 0], parts.tank[AT_STATION, 0] = full, connections.budget
        rest = _fly(connections, s, j, parts, AT_STATION, latest, workspace, BY_STATION)
        for b in range(rest):
            parts.parent[BY_STATION, b] = point
        if rest > 0:
            for a in range(size):
                put(
                    parts,
                    DIRECT,
                    a,
                    there.time[0, a],
                    there.tank[0, a],
                    there.parent[0, a],
                    there.via[0, a],
                )
            size = _merge(size, parts, rest, step, there, 0)
    return size


@kernel
def copy_front(source, at, destination, to):
    """Copy a front; returns whether it was unchanged."""
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
    """Slack of a chaser that can still fly the rest [s]; −inf if it cannot."""
    best, point = -np.inf, 0
    size = came.size[at]
    for rest in range(suffices.size[to] - 1, -1, -1):
        while point < size and came.tank[at, point] < suffices.tank[to, rest]:
            point += 1
        if point == size:
            break
        best = max(best, suffices.time[to, rest] - came.time[at, point])
    return best if best >= 0.0 else -np.inf
