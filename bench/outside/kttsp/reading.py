"""Instances and decision vectors."""

from __future__ import annotations

import json
import math
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import numpy.typing as npt

from adr_opt.common.errors import InputError
from adr_opt.common.files import read_text

from ..reading import FloatArray, filled_lines, numbers_of

FILE = "small.kttsp"


@dataclass(frozen=True)
class Problem:
    """An instance.

    Attributes
    ----------
    name : str
    begin_d, least_flight_d, longest_d : float
        Begin, shortest flight of a leg, and when all must be met [d].
    most_m_s, most_exception_m_s : float
        ΔV of a leg, and of a leg that is an exception.
    exceptions : int
        How many there may be.
    elements : (targets, 6) float64
        Semi-major axis [m], eccentricity, inclination, RAAN, argument of periapsis and anomaly at
        t = 0 [rad].
    """

    name: str
    begin_d: float
    least_flight_d: float
    longest_d: float
    most_m_s: float
    most_exception_m_s: float
    exceptions: int
    elements: FloatArray

    @property
    def targets(self) -> int:
        """How many there are."""
        return len(self.elements)


@dataclass(frozen=True)
class Tour:
    """A solution: departures and flights of the legs [d], and the targets in order."""

    departures_d: FloatArray
    flights_d: FloatArray
    order: npt.NDArray[np.int64]


def read_problem(path: Path) -> Problem:
    """An instance: a line ``p kttsp`` with six figures, then six elements of each target.

    Lines that begin with ``c`` say something to people.
    """
    header: list[float] | None = None
    rows: list[list[float]] = []
    for number, line in filled_lines(path, "c"):
        where = f"{path}: line {number}"
        if line.startswith("p"):
            kind, _, figures = line[1:].strip().partition(" ")
            if kind.lower() != "kttsp" or header is not None:
                raise InputError(f"{where}: not the one line 'p kttsp …'; give the file as it is")
            header = numbers_of(figures, 6, where)
            continue
        row = numbers_of(line, 6, where)
        if row[0] <= 0.0 or not 0.0 <= row[1] < 1.0:
            raise InputError(f"{where}: no closed orbit; give the file as it is")
        rows.append(row)
    if header is None or not rows:
        raise InputError(f"{path}: no line 'p kttsp …' or no targets; give the file as it is")
    if header[5] != math.floor(header[5]):
        raise InputError(f"{path}: {header[5]:g} exceptions; give the file as it is")
    return Problem(path.stem, *header[:5], int(header[5]), np.array(rows))


def tour_of(vector: FloatArray, targets: int, where: str) -> Tour:
    """A decision vector: N − 1 departures, N − 1 flights [d], N targets in order."""
    if vector.shape != (3 * targets - 2,):
        raise InputError(f"{where}: {vector.size} figures instead of {3 * targets - 2}")
    order = vector[2 * targets - 2 :]
    if (order != np.floor(order)).any():
        raise InputError(f"{where}: targets are whole numbers")
    departures, flights = vector[: targets - 1], vector[targets - 1 : 2 * targets - 2]
    return Tour(departures, flights, order.astype(np.int64))


def read_tour(path: Path, targets: int) -> Tour:
    """A solution as it is submitted: a list of one object with a `decisionVector`."""
    try:
        content = json.loads(read_text(path))
        vector = np.array(content[0]["decisionVector"], dtype=float)
    except (json.JSONDecodeError, LookupError, TypeError, ValueError):
        raise InputError(f"{path}: no decisionVector of numbers in it") from None
    if not np.isfinite(vector).all():
        raise InputError(f"{path}: a decisionVector with figures that are not finite")
    return tour_of(vector, targets, str(path))
