"""Campaigns with their impulses, and the file that one is kept in."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from adr_opt.common.errors import InputError

from ..reading import FloatArray, floats_of, read_object, sequence_of
from .campaign import Removals, Stop


class Flight(NamedTuple):
    """Impulses of a leg.

    Attributes
    ----------
    times_s : (impulses,) float64
        Since its departure.
    impulses_m_s : (impulses, 3) float64
        Inertial.
    """

    times_s: FloatArray
    impulses_m_s: FloatArray


@dataclass(frozen=True)
class FlownMission:
    """A mission in time, and the flights of its legs."""

    removals: Removals
    flights: tuple[Flight, ...]


def read_flown(path: Path, debris: int) -> tuple[FlownMission, ...]:
    """The missions of a file of impulses.

    Parameters
    ----------
    path : Path
    debris : int
        How many there are.
    """
    found = []
    for number, mission in enumerate(sequence_of(read_object(path), "missions", str(path))):
        where = f"{path}: missions[{number}]"
        if not isinstance(mission, dict):
            raise InputError(f"{where}: not a JSON object; give the file as it is")
        rows = sequence_of(mission, "stops", where)
        stops = [Stop(*_row({"stops": row}, "stops", 3, where)) for row in rows]
        if not stops or any(not 0 <= stop.debris < debris for stop in stops):
            raise InputError(f"{where}: stops are debris from 0 to {debris - 1}")
        if any(stop.debris != int(stop.debris) for stop in stops):
            raise InputError(f"{where}: debris are whole numbers")
        legs = sequence_of(mission, "legs", where)
        if len(legs) != len(stops) - 1:
            raise InputError(f"{where}: {len(legs)} legs between {len(stops)} stops")
        stops = [stop._replace(debris=int(stop.debris)) for stop in stops]
        flights = tuple(_flight(leg, where) for leg in legs)
        found.append(FlownMission(Removals(tuple(stops)), flights))
    return tuple(found)


def _row(content: dict[str, Any], key: str, count: int, where: str) -> tuple[Any, ...]:
    return floats_of(content, key, count, where)


def _flight(leg: Any, where: str) -> Flight:
    """Impulses: rows of a time [s] and three components [m/s]."""
    impulses = sequence_of({"legs": leg}, "legs", where)
    rows = np.array([floats_of({"legs": row}, "legs", 4, where) for row in impulses])
    rows = rows.reshape(-1, 4)
    return Flight(rows[:, 0].copy(), rows[:, 1:].copy())
