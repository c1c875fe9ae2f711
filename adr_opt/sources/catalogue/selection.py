"""Selection of targets from the records of a catalogue, and placement of the station."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
import numpy.typing as npt

from ...common.constants import EARTH_RADIUS_M
from ...common.errors import InputError
from .demands import ObjectChoice
from .filters import Filters
from .propagation import FLOAT
from .records import Dropped, ElementSet, shown

NEIGHBOUR_RAD = math.radians(2.0)
"""Angle within which planes are neighbours: about 260 m/s in low orbit."""

BLOCK = 1024
"""Number of rows of plane angles computed at once."""


def normals(elements: FLOAT) -> FLOAT:
    """Unit vectors of the angular momenta, shape (object, 3)."""
    inclination, raan = elements[:, 2], elements[:, 3]
    sine = np.sin(inclination)
    found: FLOAT = np.column_stack((np.sin(raan) * sine, -np.cos(raan) * sine, np.cos(inclination)))
    return found


def plane_angles(elements: FLOAT, inclination: float, raan: float) -> FLOAT:
    """Angles between planes and one plane, shape (object,) [rad], exact for small ones."""
    one = normals(np.array([[0.0, 0.0, inclination, raan]]))[0]
    chords = np.linalg.norm(normals(elements) - one, axis=1)
    angles: FLOAT = 2.0 * np.arcsin(np.minimum(0.5 * chords, 1.0))
    return angles


def densest(elements: FLOAT) -> FLOAT:
    """A circular orbit in the middle of the densest planes.

    The object with the most planes within :data:`NEIGHBOUR_RAD` is found (the first of several);
    the station gets the mean plane and the median semi-major axis of these, at the node.

    Parameters
    ----------
    elements : (object, element) float64
        At least one row.

    Returns
    -------
    (element,) float64
        Columns of :data:`~.propagation.ELEMENTS`.
    """
    # By inclination, so that most of the objects need not be compared: planes are no nearer
    # than their inclinations.
    order = np.argsort(elements[:, 2], kind="stable")
    tilt = elements[order, 2]
    vectors = normals(elements[order])
    least = math.cos(NEIGHBOUR_RAD)
    counts = np.zeros(len(order), dtype=int)
    for begin in range(0, len(order), BLOCK):
        end = min(begin + BLOCK, len(order))
        first = np.searchsorted(tilt, tilt[begin] - NEIGHBOUR_RAD)
        last = np.searchsorted(tilt, tilt[end - 1] + NEIGHBOUR_RAD, side="right")
        near = vectors[begin:end] @ vectors[first:last].T >= least
        counts[begin:end] = near.sum(axis=1)
    best = int(min(order[counts == counts.max()]))
    centre = normals(elements[best : best + 1])[0]
    group = elements[normals(elements) @ centre >= least]
    x, y, z = normals(group).sum(axis=0)
    return np.array(
        [np.median(group[:, 0]), 0.0, math.atan2(math.hypot(x, y), z), math.atan2(x, -y), 0.0, 0.0]
    )


def parse_orbit(text: str) -> FLOAT | None:
    """A circular orbit given as ``ALTITUDE_KM,INCLINATION,RAAN[,U]`` (degrees).

    Returns
    -------
    (element,) float64 or None
        None if the text is not a list of numbers, so perhaps an object.

    Raises
    ------
    InputError
        Too few or many numbers, or one out of range.
    """
    try:
        numbers = [float(part) for part in text.split(",")]
    except ValueError:
        return None
    if len(numbers) == 1:
        return None
    if len(numbers) not in (3, 4) or not all(map(math.isfinite, numbers)):
        raise InputError(
            f"--station {shown(text)!r}: give ALTITUDE_KM,INCLINATION,RAAN or one number more, "
            "the argument of latitude, in degrees"
        )
    altitude_km, inclination, raan, latitude = (*numbers, 0.0)[:4]
    if not 0.0 < altitude_km <= 100_000.0:
        raise InputError(f"--station: altitude {altitude_km:g} km: must be between 0 and 100000")
    if not 0.0 <= inclination <= 180.0:
        raise InputError(f"--station: inclination {inclination:g}: must be between 0 and 180")
    if max(abs(raan), abs(latitude)) > 360.0:
        raise InputError(f"--station {shown(text)!r}: angles must be between -360 and 360")
    inclination, raan, latitude = map(math.radians, (inclination, raan, latitude))
    return np.array([EARTH_RADIUS_M + 1e3 * altitude_km, 0.0, inclination, raan, 0.0, latitude])


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
    """Rows propagated by SGP4 and passed by the filters; the others go to ``dropped``.

    Parameters
    ----------
    candidates : list of ElementSet
    elements : (object, element) float64
        Columns of :data:`~.propagation.ELEMENTS`; rows of NaN where SGP4 fails.
    filters : Filters
    dropped : list of Dropped
        Appended to, with the reason.
    choice : ObjectChoice
        Objects that pass whatever the filters say.
    """
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
    """Rows whose planes are nearest to that of a reference orbit; the others go to ``dropped``.

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
