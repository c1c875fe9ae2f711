"""Rows of bodies, made: what kernels take, and :mod:`.ephemeris` and :mod:`.elements` read."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from . import columns
from .ephemeris import secular_rates

FloatArray = npt.NDArray[np.float64]


def body_row(
    radius_m: float,
    inclination: float,
    node: float,
    latitude: float,
    *,
    eccentricity: float = 0.0,
    perigee: float = 0.0,
    oblateness_m2: float = 0.0,
) -> tuple[float, ...]:
    """A body on a mean orbit, with its secular rates (docs/model.md section 1).

    Parameters
    ----------
    radius_m, inclination : float
        Of the circle that is planned with [m], [rad].
    node, latitude : float
        RAAN and argument of latitude at t = 0 [rad].
    eccentricity, perigee : float
        Of the true orbit, and its argument of perigee at t = 0 [rad].
    oblateness_m2 : float
        J2 R², 0 for two bodies.

    Returns
    -------
    (columns,) float
        :data:`.columns.ORBIT_COLUMNS`.
    """
    node_rate, perigee_rate, anomaly_rate = secular_rates(
        radius_m, eccentricity, inclination, oblateness_m2
    )
    return (
        radius_m, inclination, node, latitude, node_rate, perigee_rate + anomaly_rate,
        eccentricity, perigee, perigee_rate,
    )  # fmt: skip


def as_left(bodies: FloatArray) -> FloatArray:
    """Bodies as they are left: with the rate of the node of a chaser after that in a column more.

    That is the body's own: chasers leave from its orbit. :func:`with_orbit` states another one.

    Parameters
    ----------
    bodies : (bodies, columns) float64

    Returns
    -------
    (bodies, columns + 1) float64
    """
    return np.column_stack([bodies, bodies[:, columns.RAAN_RATE]])


def with_orbit(
    row: FloatArray,
    *,
    radius_m: float | None = None,
    node: float | None = None,
    latitude: float | None = None,
    eccentricity: float | None = None,
    coasting_node_rate: float | None = None,
) -> FloatArray:
    """A body on another orbit, whose angles advance at the same rates.

    Parameters
    ----------
    row : (columns,) float64
        Not changed.
    radius_m, node, latitude, eccentricity : float, optional
        Instead of the body's: angles at t = 0 [m], [rad], [rad].
    coasting_node_rate : float, optional
        Rate of the node of a chaser that has left it, for a row of :func:`as_left` [rad/s].
    """
    changed = row.copy()
    for column, value in (
        (columns.RADIUS, radius_m),
        (columns.RAAN, node),
        (columns.ARGUMENT_OF_LATITUDE, latitude),
        (columns.ECCENTRICITY, eccentricity),
        (columns.COASTING_RAAN_RATE, coasting_node_rate),
    ):
        if value is not None:
            changed[column] = value
    return changed
