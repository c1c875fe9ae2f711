"""Stacked timetables, for stepping hundreds of missions at once.

They have a leading axis of slots, and the entries of one destination are packed, as a
:class:`PackedColumn`.
"""

import math
from typing import NamedTuple

import numpy as np

from ..core.compile import inlined, kernel
from ..core.events import counted_event, earliest_taken
from .timetable import Table, departure_at, entry_at, events


class PackedColumn(NamedTuple):
    """Entries of one destination, packed into half the memory.

    Attributes
    ----------
    first : (bodies,) float64
        Time of the first departure event of each origin [s].
    total : (bodies,) int32
        Number of events; 0 for the destination itself.
    entries : (bodies, events, 2) float32
        ΔV [m/s], and arrival after the departure event [s].
    departure : (bodies, events) float64
        As in :class:`Table` [s].
    """

    first: np.ndarray
    total: np.ndarray
    entries: np.ndarray
    departure: np.ndarray


def allocate_slots(
    slots: int, bodies: int, most: int, *, regular: bool
) -> tuple[Table, PackedColumn]:
    """Stacked tables and columns, without departure events yet."""
    listed = 0 if regular else most
    return Table(
        first=np.zeros((slots, bodies, bodies)),
        spacing=np.ones((slots, bodies)),
        total=np.zeros((slots, bodies, bodies), dtype=np.int32),
        entries=np.full((slots, bodies, most, bodies, 2), np.inf),
        departure=np.full((slots, bodies, listed, bodies), np.inf),
        slot=np.empty((slots, 0, 0), dtype=np.int16),
    ), PackedColumn(
        first=np.zeros((slots, bodies)),
        total=np.zeros((slots, bodies), dtype=np.int32),
        entries=np.zeros((slots, bodies, most, 2), dtype=np.float32),
        departure=np.full((slots, bodies, listed), np.inf),
    )


def size_of_slots(slots: int, bodies: int, most: int, *, regular: bool) -> float:
    """Memory of the entries and departures that :func:`allocate_slots` would make [bytes]."""
    return float(slots) * bodies * most * bodies * 8 * (2 if regular else 3)


def put(tables: Table, slot: int, table: Table) -> None:
    """Copy a table of all pairs into a slot that may have space for more bodies and events."""
    bodies, most = table.entries.shape[:2]
    tables.first[slot, :bodies, :bodies] = table.first
    tables.spacing[slot, :bodies] = table.spacing
    tables.total[slot, :bodies, :bodies] = table.total
    tables.entries[slot] = np.inf
    tables.entries[slot, :bodies, :most, :bodies] = table.entries
    tables.departure[slot] = np.inf
    tables.departure[slot, :bodies, : table.departure.shape[1], :bodies] = table.departure


def listed_in(tables: Table, slot: int, i: int, j: int) -> tuple[np.ndarray, np.ndarray]:
    """Departures and arrivals of the connections of a pair where events are irregular [s]."""
    count = int(tables.total[slot, i, j])
    return tables.departure[slot, i, :count, j], tables.entries[slot, i, :count, j, 1]


@inlined
def in_slot(tables, slot):
    """One of the stacked tables."""
    return Table(
        tables.first[slot],
        tables.spacing[slot],
        tables.total[slot],
        tables.entries[slot],
        tables.departure[slot],
        tables.slot[slot],
        None,
    )


@inlined
def column_in_slot(columns, slot):
    """One of the stacked columns."""
    return PackedColumn(
        columns.first[slot], columns.total[slot], columns.entries[slot], columns.departure[slot]
    )


@kernel
def fill_column(table, j, column):
    """Pack the entries of a destination into a column that may have space for more."""
    for i in range(table.spacing.size):
        column.first[i], column.total[i] = 0.0, 0
        if i != j and events(table, i, j) > 0:
            column.first[i], column.total[i] = departure_at(table, i, j, 0), events(table, i, j)
            for m in range(events(table, i, j)):
                delta_v, arrival = entry_at(table, i, j, m)
                column.entries[i, m, 0] = delta_v
                departure = departure_at(table, i, j, m)
                column.entries[i, m, 1] = arrival - departure
                if column.departure.shape[1] > 0:
                    column.departure[i, m] = departure


@inlined
def lookup_in_column(column, table, i, ready):
    """ΔV [m/s] and time [s] from ready to arrival at the destination; +inf without a transfer."""
    if column.departure.shape[1] > 0:
        low, high = 0, column.total[i]
        while low < high:
            middle = (low + high) // 2
            if column.departure[i, middle] < earliest_taken(ready):
                low = middle + 1
            else:
                high = middle
        if low >= column.total[i]:
            return math.inf, math.inf
        time = column.departure[i, low] - ready + column.entries[i, low, 1]
        return column.entries[i, low, 0], time
    spacing = table.spacing[i]
    m = counted_event(column.first[i], spacing, column.total[i], earliest_taken(ready))
    if m >= column.total[i]:
        return math.inf, math.inf
    time = column.first[i] + m * spacing - ready + column.entries[i, m, 1]
    return column.entries[i, m, 0], time
