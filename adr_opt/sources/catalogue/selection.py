"""Selection of targets from the records of a catalogue, with reasons for rejection."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import numpy.typing as npt

from ...common.errors import InputError
from .demands import ObjectChoice
from .filters import Filters
from .propagation import FLOAT
from .records import Dropped, ElementSet
from .station import plane_angles

ROWS = npt.NDArray[np.intp]


def named(
    records: Sequence[ElementSet],
    host: ElementSet | None,
    filters: Filters,
    dropped: list[Dropped],
    choice: ObjectChoice,
) -> list[ElementSet]:
    """Records with matching names, except the station's; the others go to ``dropped``."""
    named = []
    for record in records:
        if record is host:
            continue
        if id(record) in choice.excluded:
            option = choice.excluded[id(record)]
            dropped.append(Dropped.of(record, option, f"--{option} leaves it out"))
        elif id(record) in choice.musts or filters.match_name(record):
            named.append(record)
        else:
            dropped.append(Dropped.of(record, "name", "its name does not fit --name"))
    return named


def within_limits(
    candidates: list[ElementSet],
    elements: FLOAT,
    filters: Filters,
    dropped: list[Dropped],
    choice: ObjectChoice,
) -> ROWS:
    """Rows propagated by SGP4 and passed by the filters; the others go to ``dropped``."""
    keep = np.isfinite(elements[:, 0])
    free = np.array([id(record) not in choice.musts for record in candidates])
    for reason, outside in filters.outside(elements).items():
        limits = f"it is outside --{reason}"
        for row in np.flatnonzero(keep & outside & free):
            dropped.append(Dropped.of(candidates[row], reason, limits))
        keep &= ~(outside & free)
    return np.flatnonzero(keep)


def nearest(
    candidates: list[ElementSet],
    elements: FLOAT,
    rows: ROWS,
    place: FLOAT,
    most: int,
    dropped: list[Dropped],
    choice: ObjectChoice,
) -> ROWS:
    """Rows whose planes are nearest to that of a place; the others go to ``dropped``.

    Raises
    ------
    InputError
        More objects than that have to be kept.
    """
    angles = plane_angles(elements[rows], place[2], place[3])
    is_must = np.array([id(candidates[row]) in choice.musts for row in rows])
    if is_must.sum() > most:
        raise InputError(f"--max-targets {most}: --must keeps {is_must.sum()}; allow as many")
    # Equally near ones in the order of the file.
    order = np.argsort(np.where(is_must, -1.0, angles), kind="stable")
    for row in np.sort(rows[order[most:]]):
        dropped.append(
            Dropped.of(candidates[row], "max-targets", "nearer planes fill --max-targets")
        )
    nearest: ROWS = np.sort(rows[order[:most]])
    return nearest
