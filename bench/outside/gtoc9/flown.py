"""Campaigns with their impulses, and the file that one is kept in."""

from __future__ import annotations

import json
from dataclasses import dataclass
from pathlib import Path
from typing import NamedTuple

import numpy as np

from adr_opt.common.files import read_text

from ..reading import FloatArray, published
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


@published
def read_flown(path: Path, debris: int) -> tuple[FlownMission, ...]:
    """The missions of a file of impulses, between debris of so many.

    Each has its `stops`, rows of a debris, its arrival and its departure, and the impulses of each
    of its `legs`, rows of a time [s] and three components [m/s].
    """
    found = []
    for mission in json.loads(read_text(path))["missions"]:
        stops = tuple(Stop(*stop) for stop in mission["stops"])
        legs = [np.array(leg, dtype=float).reshape(-1, 4) for leg in mission["legs"]]
        if len(legs) != len(stops) - 1 or any(one.debris not in range(debris) for one in stops):
            raise ValueError("stops are of no debris, or legs do not lie between them")
        flights = tuple(Flight(leg[:, 0].copy(), leg[:, 1:].copy()) for leg in legs)
        found.append(FlownMission(Removals(stops), flights))
    return tuple(found)
