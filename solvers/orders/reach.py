"""Lower bounds on legs between two times, which reject positions of an order quickly.

A target fits in between two others if the chaser can come there and go on, straight or by a
station, between the earliest time at which it is ready at the one and the latest at which it has
to be ready at the other. Hardly ever it can: what a plane costs to change into depends on when,
and most are far. So the least ΔV of the connections that lie within some span of time is kept, for
spans of whole cells of time, and a position is timed only where these bounds allow it.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from adr_opt.kernels.core.compile import inlined, kernel
from adr_opt.kernels.core.events import earliest_taken
from adr_opt.kernels.core.memory import borrowed

from .connection_table import ConnectionTable

CELLS = 73
"""Number of time cells per mission: five days each if it takes a year."""

SPANS = (1, 2, 3, 4, 6, 8, 12, 16, 24, 32, 48, CELLS)
"""Spans in cells for which bounds are kept; others use the next longer one."""


class Reach(NamedTuple):
    """Bounds on legs.

    Attributes
    ----------
    cell_s : float
        [s].
    rank : (CELLS + 1,) int64
        Index of the least span of at least this number of cells.
    least : (bodies, bodies, spans, CELLS) float32
        Least ΔV of the connections of a pair that leave and end within a span that begins with a
        cell, +inf for none [m/s].
    straight, shortest : (bodies, bodies) float64
        Least time from a departure to the end of the service at the destination, without a station
        on the way, and with one allowed [s].
    into : (bodies, bodies) float64
        The latter by destination and origin [s].
    """

    cell_s: float
    rank: np.ndarray
    least: np.ndarray
    straight: np.ndarray
    shortest: np.ndarray
    into: np.ndarray


@kernel
def _by_span(connections, i, j, cell_s, spans, cheapest, least):
    """Fill in the bounds of a pair; returns the least duration of its connections [s]."""
    connections = borrowed(connections)
    for g in range(CELLS):
        for n in range(CELLS):
            cheapest[g, n] = np.inf
    straight = np.inf
    begin = connections.first[i, j]
    for c in range(begin, begin + connections.total[i, j]):
        departure, end = connections.departure[c], connections.end[c]
        straight = min(straight, end - departure)
        g = min(max(int(departure / cell_s), 0), CELLS - 1)
        n = min(max(int(end / cell_s), g), CELLS - 1) - g
        cheapest[g, n] = min(cheapest[g, n], connections.delta_v[c])
    for n in range(1, CELLS):
        for g in range(CELLS):
            later = cheapest[g + 1, n - 1] if g + 1 < CELLS else np.inf
            cheapest[g, n] = min(cheapest[g, n], min(cheapest[g, n - 1], later))
    for rank in range(spans.size):
        for g in range(CELLS):
            least[i, j, rank, g] = (1.0 - 1e-6) * cheapest[g, spans[rank] - 1]
    return straight


@kernel
def _reach_of(connections, stations, duration, spans):
    bodies = connections.total.shape[0]
    cell_s = max(duration, 1.0) / CELLS
    least = np.empty((bodies, bodies, spans.size, CELLS), np.float32)
    cheapest = np.empty((CELLS, CELLS))
    straight = np.empty((bodies, bodies))
    for i in range(bodies):
        for j in range(bodies):
            straight[i, j] = _by_span(connections, i, j, cell_s, spans, cheapest, least)
    shortest = straight.copy()
    for i in range(bodies):
        for j in range(bodies):
            for s in range(stations):
                shortest[i, j] = min(shortest[i, j], straight[i, s] + straight[s, j])
    rank = np.zeros(CELLS + 1, np.int64)
    for cells in range(1, CELLS + 1):
        while spans[rank[cells]] < cells:
            rank[cells] += 1
        if cells < CELLS:
            rank[cells + 1] = rank[cells]
    return Reach(cell_s, rank, least, straight, shortest, shortest.T.copy())


def reach_of(connections: ConnectionTable, stations: int, duration: float) -> Reach:
    """Bounds on the legs of a mission of a given duration [s], from its table."""
    reach: Reach = _reach_of(connections, stations, duration, np.array(SPANS, dtype=np.int64))
    return reach


@inlined
def leg(reach, i, j, begin, end):
    """Least ΔV of connections of a pair that leave and end between two times [m/s]."""
    cost = np.inf
    if end - earliest_taken(begin) >= reach.straight[i, j]:
        first = min(max(int(earliest_taken(begin) / reach.cell_s), 0), CELLS - 1)
        last = min(max(int(end / reach.cell_s), first), CELLS - 1)
        cost = np.float64(reach.least[i, j, reach.rank[last - first + 1], first])
    return cost


@kernel
def may_fit(rules, reach, i, j, k, times, tanks, refuels):
    """Whether a chaser may reach a target from one body and continue to another in time.

    Parameters
    ----------
    rules : Rules
    reach : Reach
    i, j, k : int
        Bodies; ``k`` is −1 where the order ends with ``j``.
    times : tuple of float
        When it is ready at ``i`` at the earliest, and has to be ready at ``k`` at the latest [s].
    tanks : tuple of float
        ΔV that it has left at ``i`` at most, and that it needs at ``k`` at least [m/s].
    refuels : bool
        Whether it may come to ``j`` by a station.

    Returns
    -------
    bool
        If not, there is no such way; if so, there may be one.
    """
    ready, latest = times
    left, need = tanks
    to_begin, to_end = ready, latest
    on_begin, on = ready + reach.shortest[i, j], 0.0
    if k >= 0:
        to_end = latest - reach.shortest[j, k]
        on = leg(reach, j, k, on_begin, latest)
    if earliest_taken(on_begin) > to_end:
        return False
    to = leg(reach, i, j, to_begin, to_end)
    if to + on + need <= left:
        return True
    to_full, on_full = np.inf, np.inf
    for s in range(rules.stations):
        if refuels and s != i and leg(reach, i, s, to_begin, to_end - reach.straight[s, j]) <= left:
            begin = to_begin + reach.straight[i, s]
            to_full = min(to_full, leg(reach, s, j, begin, to_end))
        if k >= 0:
            begin = on_begin + reach.straight[j, s]
            if leg(reach, s, k, begin, latest) + need <= rules.budget:
                end = latest - reach.straight[s, k]
                on_full = min(on_full, leg(reach, j, s, on_begin, end))
    return (
        to_full + on + need <= rules.budget
        or to + on_full <= left
        or to_full + on_full <= rules.budget
    )
