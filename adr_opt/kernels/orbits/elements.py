"""Elements of many bodies at one time, or of one body at many times, as NumPy arrays.

As :mod:`.ephemeris` has them for kernels. Bodies are rows of :data:`.columns.ORBIT_COLUMNS`, shape
(bodies, columns), and a time is one for all of them; or a single row, shape (columns,), and times
of any shape. NaN for bodies without an orbit.
"""

from __future__ import annotations

import math

import numpy as np
import numpy.typing as npt

from . import columns, ephemeris

FloatArray = npt.NDArray[np.float64]


def _column(bodies: npt.ArrayLike, column: int) -> FloatArray:
    numbers: FloatArray = np.asarray(bodies, dtype=np.float64)[..., column]
    return numbers


def _moved(bodies: npt.ArrayLike, column: int, rate: int, time_s: npt.ArrayLike) -> FloatArray:
    return _column(bodies, column) + _column(bodies, rate) * np.asarray(time_s, dtype=np.float64)


def radii(bodies: npt.ArrayLike, time_s: npt.ArrayLike) -> FloatArray:
    """Radii of the circles [m]."""
    return _column(bodies, columns.RADIUS)


def inclinations(bodies: npt.ArrayLike, time_s: npt.ArrayLike) -> FloatArray:
    """Inclinations [rad]."""
    return _column(bodies, columns.INCLINATION)


def nodes(bodies: npt.ArrayLike, time_s: npt.ArrayLike) -> FloatArray:
    """RAANs [rad]."""
    return _moved(bodies, columns.RAAN, columns.RAAN_RATE, time_s)


def node_rates(bodies: npt.ArrayLike, time_s: npt.ArrayLike) -> FloatArray:
    """Rates of the nodes [rad/s]."""
    return _column(bodies, columns.RAAN_RATE)


def latitudes(bodies: npt.ArrayLike, time_s: npt.ArrayLike) -> FloatArray:
    """Arguments of latitude [rad]."""
    time = np.asarray(time_s, dtype=np.float64)
    steady = _moved(bodies, columns.ARGUMENT_OF_LATITUDE, columns.LATITUDE_RATE, time)
    return steady + 0.5 * _column(bodies, columns.LATITUDE_ACCELERATION) * time * time


def latitude_rates(bodies: npt.ArrayLike, time_s: npt.ArrayLike) -> FloatArray:
    """Rates of the arguments of latitude [rad/s]."""
    return _moved(bodies, columns.LATITUDE_RATE, columns.LATITUDE_ACCELERATION, time_s)


def eccentricities(bodies: npt.ArrayLike, time_s: npt.ArrayLike) -> FloatArray:
    """Eccentricities of the true orbits."""
    return _column(bodies, columns.ECCENTRICITY)


def perigees(bodies: npt.ArrayLike, time_s: npt.ArrayLike) -> FloatArray:
    """Arguments of perigee of the true orbits [rad]."""
    return _moved(bodies, columns.PERIGEE, columns.PERIGEE_RATE, time_s)


def equinoctial_at(row: FloatArray, time_s: float) -> tuple[FloatArray, FloatArray]:
    """Mean equinoctial elements of a body on its true orbit, and the frame of its plane.

    Parameters
    ----------
    row : (columns,) float64
    time_s : float
        Since the epoch.

    Returns
    -------
    elements : (6,) float64
        In that frame, as :mod:`.equinoctial` has them [m, –, rad].
    frame : (3, 3) float64
        Towards the ascending node, a quarter of a revolution later, and along the normal.
    """
    inclination, node = ephemeris.inclination_at(row, time_s), ephemeris.node_at(row, time_s)
    perigee = float(ephemeris.perigee_at(row, time_s))
    e = float(ephemeris.eccentricity_at(row, time_s))
    longitude = math.remainder(float(ephemeris.latitude_at(row, time_s)), math.tau)
    radius = float(ephemeris.radius_at(row, time_s))
    mean = [radius, e * math.cos(perigee), e * math.sin(perigee), 0.0, 0.0, longitude]
    return np.array(mean), np.array(ephemeris.frame(inclination, node))
