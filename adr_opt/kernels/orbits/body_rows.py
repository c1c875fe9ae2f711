"""Modified rows of bodies: as chasers leave them, and on another orbit.

A row is made by :func:`.ephemeris.body_row`, and read there and in :mod:`.elements`.
"""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from . import columns

FloatArray = npt.NDArray[np.float64]


def as_left(bodies: FloatArray) -> FloatArray:
    """Rows of bodies at departure, with an extra column for the node rate of the departing chaser.

    That is the body's own: chasers leave from its orbit. :func:`with_orbit` states another one.

    Parameters
    ----------
    bodies : (bodies, columns) float64

    Returns
    -------
    (bodies, columns + 1) float64
    """
    return np.column_stack([bodies, bodies[:, columns.RAAN_RATE]])


def launched(row: FloatArray, target: FloatArray) -> FloatArray:
    """Row of a launch orbit for a departure at any time: a circle in the plane of the target.

    It has the target's node then, which drifts afterwards as its own radius says, and it moves as
    if it had been half a revolution away from the target at t = 0.

    Parameters
    ----------
    row : (columns,) or (columns + 1,) float64
        The circle with any node; the extra column is that of :func:`as_left`.
    target : (columns,) float64

    Returns
    -------
    (columns + 1,) float64
    """
    made: FloatArray = as_left(row[None, : columns.COASTING_RAAN_RATE])[0]
    made[columns.RAAN], made[columns.RAAN_RATE] = target[columns.RAAN], target[columns.RAAN_RATE]
    made[columns.ARGUMENT_OF_LATITUDE] = target[columns.ARGUMENT_OF_LATITUDE] + np.pi
    return made


def with_orbit(
    row: FloatArray,
    *,
    radius_m: float | None = None,
    node: float | None = None,
    latitude: float | None = None,
    eccentricity: float | None = None,
    coasting_node_rate: float | None = None,
) -> FloatArray:
    """A body on another orbit, with its angles advancing at the same rates.

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
