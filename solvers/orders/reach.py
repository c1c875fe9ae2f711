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

from adr_opt.common.memory import available_bytes
from adr_opt.common.stop import Stop, TimeIsOver
from adr_opt.kernels.core.compile import inlined, kernel
from adr_opt.kernels.core.events import earliest_taken
from adr_opt.kernels.core.memory import borrowed

from ..progress.halting import halted_by
from .connection_table import ConnectionTable

CELLS = 73
"""Number of time cells per mission: five days each if it takes a year."""

PAIR_S, TIME_SHARE = 15e-6, 0.25
"""Time to compute the bounds of a pair [s], and largest share of the remaining time for all."""

MEMORY_SHARE = 0.25
"""Share of free memory that the bounds may take."""

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
    row : (bodies, bodies) int32
        Number of each pair among those that have connections.
    least : (pairs, spans, CELLS) float32
        Least ΔV of the connections of such a pair that leave and end within a span that begins with
        a cell, +inf for none [m/s].
    straight, shortest : (bodies, bodies) float64
        Least time from a departure to the end of the service at the destination, without a station
        on the way, and with one allowed [s].
    into : (bodies, bodies) float64
        The latter by destination and origin [s].
    """

    cell_s: float
    rank: np.ndarray
    row: np.ndarray
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
            least[rank, g] = (1.0 - 1e-6) * cheapest[g, spans[rank] - 1]
    return straight


@kernel
def _fill(connections, row, cell_s, spans, least, straight, halt):
    """Fill in the bounds of all pairs that have connections."""
    cheapest = np.empty((CELLS, CELLS))
    for i in range(straight.shape[0]):
        if halt[0]:
            return
        for j in range(straight.shape[0]):
            if row[i, j] >= 0:
                place = least[row[i, j]]
                straight[i, j] = _by_span(connections, i, j, cell_s, spans, cheapest, place)


@kernel
def _by_stations(straight, stations):
    """Least times with a station on the way allowed [s]."""
    shortest = straight.copy()
    for i in range(straight.shape[0]):
        for j in range(straight.shape[0]):
            for s in range(stations):
                shortest[i, j] = min(shortest[i, j], straight[i, s] + straight[s, j])
    return shortest


def reach_of(
    connections: ConnectionTable, stations: int, duration: float, stop: Stop | None = None
) -> Reach:
    """Bounds on the legs of a mission of a given duration [s], from its table.

    Raises
    ------
    TimeIsOver
        The time of ``stop`` is over, or too short for that, or there is no memory.
    """
    there = connections.total > 0
    pairs, cell_s = int(there.sum()), max(duration, 1.0) / CELLS
    if stop is not None and PAIR_S * pairs > TIME_SHARE * stop.remaining_s():
        raise TimeIsOver
    spans = np.array(SPANS, dtype=np.int64)
    if 4.0 * pairs * spans.size * CELLS > MEMORY_SHARE * available_bytes():
        raise TimeIsOver
    row = np.where(there, np.cumsum(there).reshape(there.shape) - 1, -1).astype(np.int32)
    least = np.empty((pairs, spans.size, CELLS), dtype=np.float32)
    straight = np.full(there.shape, np.inf)
    with halted_by(stop) as halt:
        _fill(connections, row, cell_s, spans, least, straight, halt)
    if halt[0]:
        raise TimeIsOver
    shortest = _by_stations(straight, stations)
    rank = np.searchsorted(spans, np.arange(CELLS + 1))
    return Reach(cell_s, rank, row, least, straight, shortest, shortest.T.copy())


@inlined
def leg(reach, i, j, begin, end):
    """Least ΔV of connections of a pair that leave and end between two times [m/s]."""
    cost = np.inf
    if end - earliest_taken(begin) >= reach.straight[i, j]:
        first = min(max(int(earliest_taken(begin) / reach.cell_s), 0), CELLS - 1)
        last = min(max(int(end / reach.cell_s), first), CELLS - 1)
        cost = np.float64(reach.least[reach.row[i, j], reach.rank[last - first + 1], first])
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
