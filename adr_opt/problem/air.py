"""Density of the air by altitude and solar activity, for decades.

Means of NRLMSIS 2.1 (J. T. Emmert et al., Journal of Geophysical Research: Space Physics 127,
2022) over latitudes, longitudes, hours and seasons: at a constant F10.7 of 70 (low) and 200 (high),
and over a cycle in which F10.7 swings between both (mean). They are facts coded here, so that no
package is needed: ``bench/worth.py air`` computes them by ``pymsis``. Above 1,000 km the model is
extrapolated.
"""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from ..common.constants import EARTH_RADIUS_M
from ..kernels.orbits.decay import drag_time

FLOAT = npt.NDArray[np.float64]

TABLE = """
altitude_km        low       mean       high
        120  1.634e-08  1.688e-08  1.742e-08
        130  5.917e-09  6.063e-09  6.218e-09
        140  2.796e-09  2.924e-09  3.061e-09
        150  1.517e-09  1.644e-09  1.776e-09
        175  4.465e-10  5.482e-10   6.49e-10
        200  1.649e-10  2.352e-10  3.048e-10
        225  6.907e-11  1.153e-10   1.62e-10
        250  3.155e-11  6.146e-11  9.273e-11
        275  1.538e-11  3.477e-11  5.577e-11
        300  7.888e-12  2.056e-11  3.478e-11
        350  2.313e-12  7.921e-12  1.465e-11
        400  7.509e-13  3.341e-12  6.648e-12
        450  2.632e-13  1.503e-12  3.181e-12
        500  9.957e-14  7.099e-13  1.584e-12
        550  4.138e-14  3.495e-13  8.147e-13
        600  1.939e-14  1.786e-13  4.309e-13
        650  1.044e-14  9.478e-14  2.341e-13
        700  6.413e-15  5.231e-14  1.307e-13
        750  4.374e-15  3.014e-14   7.51e-14
        800  3.202e-15   1.82e-14   4.46e-14
        850   2.45e-15  1.156e-14  2.749e-14
        900  1.928e-15   7.73e-15  1.765e-14
        950  1.544e-15  5.433e-15  1.184e-14
       1000  1.254e-15  3.993e-15    8.3e-15
       1100  8.517e-16  2.405e-15  4.618e-15
       1200  5.992e-16  1.601e-15   2.93e-15
       1300  4.356e-16  1.132e-15  2.027e-15
       1400  3.268e-16  8.303e-16  1.477e-15
       1500  2.526e-16  6.243e-16  1.111e-15
       1700  1.636e-16   3.72e-16  6.634e-16
       2000  9.974e-17  1.895e-16  3.327e-16
"""
"""Altitudes [km] and densities [kg/m³] by solar activity."""

_HEADINGS, *_ROWS = (line.split() for line in TABLE.strip().splitlines())
ALTITUDES_KM, *_DENSITIES = (tuple(map(float, column)) for column in zip(*_ROWS, strict=True))

DENSITIES_KG_M3 = dict(zip(_HEADINGS[1:], _DENSITIES, strict=True))
"""Solar activity → densities at :data:`ALTITUDES_KM`."""

ACTIVITIES = tuple(DENSITIES_KG_M3)


def table(activity: str) -> tuple[FLOAT, FLOAT]:
    """Altitudes [m] and logarithms of densities [ln kg/m³] at a solar activity."""
    return 1e3 * np.array(ALTITUDES_KM, dtype=float), np.log(DENSITIES_KG_M3[activity])


DRAG_COEFFICIENT = 2.2

YEAR_S = 365.25 * 86400.0

LOWEST_M, HIGHEST_M = 150e3, 2000e3
"""Altitudes between which lifetimes are tabulated; higher fragments count as at the upper one."""


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
