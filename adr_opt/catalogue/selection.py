"""Which records of a catalogue become targets, and why the others do not."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import numpy.typing as npt

from .filters import Filters
from .propagation import FLOAT
from .records import Dropped, Record
from .station import plane_angles

ROWS = npt.NDArray[np.intp]


def named(
    records: Sequence[Record], host: Record | None, filters: Filters, dropped: list[Dropped]
) -> list[Record]:
    """The records whose names fit, without that of the station; the others go to ``dropped``."""
    named = []
    for record in records:
        if record is host:
            continue
        if filters.match_name(record):
            named.append(record)
        else:
            dropped.append(Dropped.of(record, "name", "its name does not fit --name"))
    return named


def within_limits(
    candidates: list[Record], elements: FLOAT, filters: Filters, dropped: list[Dropped]
) -> ROWS:
    """The rows that SGP4 found and the filters let pass; what these stop goes to ``dropped``."""
    keep = np.isfinite(elements[:, 0])
    for reason, outside in filters.outside(elements).items():
        limits = f"it is outside --{reason}"
        for row in np.flatnonzero(keep & outside):
            dropped.append(Dropped.of(candidates[row], reason, limits))
        keep &= ~outside
    return np.flatnonzero(keep)


def nearest(
    candidates: list[Record],
    elements: FLOAT,
    rows: ROWS,
    place: FLOAT,
    most: int,
    dropped: list[Dropped],
) -> ROWS:
    """The rows whose planes are nearest to that of a place; the others go to ``dropped``."""
    angles = plane_angles(elements[rows], place[2], place[3])
    # Equally near ones in the order of the file.
    order = np.argsort(angles, kind="stable")
    for row in np.sort(rows[order[most:]]):
        dropped.append(
            Dropped.of(candidates[row], "max-targets", "nearer planes fill --max-targets")
        )
    nearest: ROWS = np.sort(rows[order[:most]])
    return nearest
