"""The timetable: the connection chosen at each departure event of each pair.

A chaser ready for an event may take any connection that departs then or later. A *choice* settles
which: the one of least ΔV + w · arrival, where w is the value of time (docs/model.md section 4).
Between two events nothing depends on the time but the wait, so a table over events is exact. How
events are spaced and where entries lie is known to this module alone, to the one that makes tables
(:mod:`.timetable_making`) and to the one that lays them side by side (:mod:`.stacked_timetables`):
planners ask :func:`next_event` and :func:`lookup`.

The events of two-body motion are half a period apart, and are counted. Where nodes drift they are
not; then a table holds when the connections depart that are ever chosen, and nothing else.

A table need not hold all pairs. Those that it does not hold have no event. With too many bodies
for the memory of all pairs, each origin has room for its nearest destinations
alone, and :attr:`Table.slot` tells their places; or it holds none at all (:mod:`.on_demand`).
"""

import math
from typing import NamedTuple

import numpy as np

from ..core.compile import inlined, kernel
from ..core.events import counted_event, earliest_taken
from . import on_demand


class Table(NamedTuple):
    """ΔV and arrival of the connection chosen at every departure event, exactly.

    Attributes
    ----------
    first : (bodies, slots) float64
        Time of the first departure event of the pair (origin, destination) [s].
    spacing : (bodies,) float64
        Time between events of an origin: half its period, or its multiple; 0 where events are not
        regular [s].
    total : (bodies, slots) int32
        Number of events at or before the end of the mission; 0 on the diagonal, and of a pair that
        the table does not hold.
    entries : (bodies, events, slots, 2) float64
        ΔV [m/s] and arrival, the end of the approach [s], of (origin, event, destination);
        both +inf where no connection departs at the event or later. Destinations lie side by side
        because planners ask for all of them at one time, and their events then have equal or
        adjacent numbers.
    departure : (bodies, events, slots) float64
        When an event is [s]; without events where they are regular.
    slot : (bodies, bodies) int16
        Slot of each destination at an origin, −1 for none; without bodies where each destination
        has the slot of its number.
    source : Source or None
        Where nothing is held, and rows are worked out on demand: then there are no slots and no
        events, and :func:`lookup` is all that can be asked.
    """

    first: np.ndarray
    spacing: np.ndarray
    total: np.ndarray
    entries: np.ndarray
    departure: np.ndarray
    slot: np.ndarray
    source: on_demand.Source | None = None


NO_SLOTS = np.empty((0, 0), dtype=np.int16)
"""Slots equal to destination indices, for tables of all pairs."""

NO_SLOTS.setflags(write=False)  # as in a finished table, or kernels would be compiled for both


@inlined
def slot_of(table, i, j):
    """Slot of a destination at an origin; −1 if there is none."""
    if table.slot.shape[0] > 0:
        return np.int64(table.slot[i, j])
    return np.int64(j)


def source_of(table: Table) -> on_demand.Source | None:
    """Source of rows on demand, or None for a filled table."""
    return table.source


@inlined
def asks(table):
    """Whether the table is empty and rows are computed on demand."""
    return _is_there(table.source)


@inlined
def _is_there(source):
    return source is not None


@inlined
def looked_at(table, targets):
    """Number of destinations that searches examine per body; all targets for a filled table."""
    return _ranks(table.source, targets)


@inlined
def _ranks(source, targets):
    if source is None:
        return targets
    return source.near.shape[2]


@inlined
def destination(table, first_target, body, time, rank):
    """A destination by rank: a target by number, or one of the nearest bodies at a time."""
    return _ranked(table.source, first_target, body, time, rank)


@inlined
def _ranked(source, first_target, body, time, rank):
    if source is None:
        return np.int64(first_target + rank)
    period = min(int(time / source.period), source.near.shape[0] - 1)
    return np.int64(source.near[period, body, rank])


def size_of(bodies: int, most: int, slots: int) -> int:
    """Size of a table [bytes]."""
    return bodies * slots * (16 * most + 12) + (2 * bodies**2 if slots < bodies else 0)


def most_events(table: Table) -> int:
    """Maximum number of departure events per pair."""
    return int(table.entries.shape[-3])


def is_regular(table: Table) -> bool:
    """Whether events are equally spaced in time."""
    return int(table.departure.shape[-2]) == 0


def count_entries(table: Table) -> int:
    """Total number of departure events of all pairs."""
    return int(table.total.sum())


def shortest_spacing(table: Table) -> float:
    """Least time between two departure events of a pair [s]."""
    if is_regular(table):
        return float(table.spacing.min())
    steps = np.diff(table.departure, axis=1)
    return float(np.min(steps, where=np.isfinite(steps), initial=math.inf))


@inlined
def events(table, i, j):
    """Number of departure events of the pair, numbered from 0 in time order."""
    slot = slot_of(table, i, j)
    return table.total[i, slot] if slot >= 0 else np.int32(0)


@inlined
def departure_at(table, i, j, event):
    """Time of a departure event of the pair [s]."""
    slot = slot_of(table, i, j)
    if table.departure.shape[1] > 0:
        return table.departure[i, event, slot]
    return table.first[i, slot] + event * table.spacing[i]


@inlined
def entry_at(table, i, j, event):
    """ΔV [m/s] and arrival [s] of the transfer that leaves at an event; +inf for none."""
    slot = slot_of(table, i, j)
    return table.entries[i, event, slot, 0], table.entries[i, event, slot, 1]


@inlined
def _next_in(table, i, slot, ready):
    """Event of a slot taken by a chaser that is ready at a time."""
    earliest = earliest_taken(ready)
    if table.departure.shape[1] > 0:
        low, high = 0, table.total[i, slot]
        while low < high:
            middle = (low + high) // 2
            if table.departure[i, middle, slot] < earliest:
                low = middle + 1
            else:
                high = middle
        return low
    return counted_event(table.first[i, slot], table.spacing[i], table.total[i, slot], earliest)


@inlined
def next_event(table, i, j, ready):
    """Event taken by a chaser ready at a time; :func:`events` of the pair if none is left."""
    slot = slot_of(table, i, j)
    return _next_in(table, i, slot, ready) if slot >= 0 else 0


@inlined
def lookup(table, i, j, time):
    """Transfer from body i to body j of a chaser that is ready at a time.

    Returns
    -------
    delta_v : float
        [m/s]; +inf where there is no transfer.
    arrival : float
        End of the approach, before service [s].
    """
    return _looked_up(table.source, table, i, j, time)


@inlined
def _looked_up(source, table, i, j, time):
    if source is not None:
        return on_demand.chosen(source, i, j, time)
    slot = slot_of(table, i, j)
    if slot < 0:
        return math.inf, math.inf
    m = _next_in(table, i, slot, time)
    if m >= table.total[i, slot]:
        return math.inf, math.inf
    return table.entries[i, m, slot, 0], table.entries[i, m, slot, 1]


@kernel
def transfer_exists(table):
    """Mask of the bodies that can be reached at all, from any body at any event."""
    bodies = table.spacing.size
    found = np.zeros(bodies, dtype=np.bool_)
    for i in range(bodies):
        for j in range(bodies):
            # A chaser ready for the first event may wait for all others.
            if not found[j] and events(table, i, j) > 0:
                found[j] = math.isfinite(entry_at(table, i, j, 0)[0])
    return found


@kernel
def sample(table, departures, delta_v, duration):
    """Sample the table at a list of ready times, into arrays (departure, origin, destination)."""
    bodies = table.spacing.size
    for d in range(departures.size):
        for i in range(bodies):
            for j in range(bodies):
                if i == j:
                    delta_v[d, i, j] = 0.0
                    duration[d, i, j] = 0.0
                else:
                    dv, arrival = lookup(table, i, j, departures[d])
                    delta_v[d, i, j] = dv
                    duration[d, i, j] = arrival - departures[d]


@kernel
def from_source(source, origins, ready, destinations, delta_v, arrival):
    """Connections computed on demand.

    Parameters
    ----------
    source : adr_opt.kernels.tables.on_demand.Source
    origins : (legs,) int64
    ready : (legs,) float64
        Since when a chaser is free there [s].
    destinations : (legs,) int64
    delta_v, arrival : (legs,) float64
        Written: [m/s], [s]; +inf where there is none.
    """
    for leg in range(destinations.size):
        delta_v[leg], arrival[leg] = on_demand.chosen(
            source, origins[leg], destinations[leg], ready[leg]
        )
