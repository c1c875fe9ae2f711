"""Time that objects and fragments stay in orbit (docs/worth.md, equations 6 and 7)."""

from __future__ import annotations

import numpy as np

from ...common.constants import EARTH_RADIUS_M
from ...kernels.orbits.decay import drag_time
from .air import FLOAT, table

DRAG_COEFFICIENT = 2.2

YEAR_S = 365.25 * 86400.0

LOWEST_M, HIGHEST_M = 150e3, 2000e3
"""Altitudes between which lifetimes of fragments are tabulated; higher fragments count as there."""


def lifetimes(shells: FLOAT, area_to_mass: FLOAT, activity: str, most_years: float) -> FLOAT:
    """Lifetimes of objects by drag [years].

    Parameters
    ----------
    shells : (object, 2) float64
        Radii of perigee and apogee [m].
    area_to_mass : (object,) float64
        [m²/kg].
    activity : str
        Solar activity, one of :data:`.air.ACTIVITIES`, constant meanwhile.
    most_years : float
        Lifetimes beyond it are not told apart.
    """
    altitudes, logs = table(activity)
    found = np.empty(len(shells))
    for at, ((perigee, apogee), area) in enumerate(zip(shells, area_to_mass, strict=True)):
        ballistic = DRAG_COEFFICIENT * area
        most = most_years * YEAR_S * ballistic
        found[at] = drag_time(perigee, apogee, altitudes, logs, most) / (ballistic * YEAR_S)
    return found


def circular_drag_times(altitudes_m: FLOAT, activity: str) -> FLOAT:
    """Equation 6: lifetimes on circles times drag coefficient and area over mass [s m²/kg]."""
    altitudes, logs = table(activity)
    return np.array(
        [
            drag_time(EARTH_RADIUS_M + height, EARTH_RADIUS_M + height, altitudes, logs, np.inf)
            for height in altitudes_m
        ]
    )
