"""Stacked timetables, for stepping hundreds of missions at once.

They have a leading axis of slots.
"""

import numpy as np

from ..core.compile import inlined
from .timetable import Table


def allocate_slots(slots: int, bodies: int, most: int, *, regular: bool) -> Table:
    """Stacked tables, without departure events yet."""
    listed = 0 if regular else most
    return Table(
        first=np.zeros((slots, bodies, bodies)),
        spacing=np.ones((slots, bodies)),
        total=np.zeros((slots, bodies, bodies), dtype=np.int32),
        entries=np.full((slots, bodies, most, bodies, 2), np.inf),
        departure=np.full((slots, bodies, listed, bodies), np.inf),
        slot=np.empty((slots, 0, 0), dtype=np.int16),
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
