"""The debris, as rows of the ephemeris of :mod:`adr_opt.kernels.orbits.ephemeris`."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from adr_opt.common.constants import DAY_S, EARTH_RADIUS_M, OBLATENESS_M2
from adr_opt.common.errors import InputError
from adr_opt.kernels.orbits import ephemeris

from ..reading import FloatArray, filled_lines, numbers_of

FILE = "debris_data.txt"


def read_debris(path: Path) -> FloatArray:
    """The debris of a file, in their order.

    A line holds the number of a debris, its epoch (MJD2000), semi-major axis [m], eccentricity,
    inclination, RAAN, argument of perigee and mean anomaly [rad].

    Returns
    -------
    (debris, columns) float64
        Rows of :data:`adr_opt.kernels.orbits.ephemeris.ORBIT_COLUMNS`, angles at MJD2000 0.
    """
    rows = []
    for number, line in filled_lines(path):
        where = f"{path}: line {number}"
        values = numbers_of(line, 8, where)
        if values[0] != len(rows):
            raise InputError(f"{where}: debris {values[0]:g} where {len(rows)} should be")
        if values[2] < EARTH_RADIUS_M or not 0.0 <= values[3] < 1.0:
            raise InputError(
                f"{where}: no orbit about the Earth has a semi-major axis of {values[2]:g} m and "
                f"an eccentricity of {values[3]:g}; give the file as it is"
            )
        rows.append(_row(np.array(values)))
    if not rows:
        raise InputError(f"{path}: no debris in it; give the file as it is")
    return np.array(rows)


def _row(record: FloatArray) -> FloatArray:
    """A debris as a row of ORBIT_COLUMNS."""
    _, epoch, axis, eccentricity, inclination, raan, perigee, anomaly = record
    node, turning, advancing = ephemeris.secular_rates(
        axis, eccentricity, inclination, OBLATENESS_M2
    )
    gone = epoch * DAY_S
    return np.array(
        ephemeris.body_row(
            axis,
            inclination,
            raan - node * gone,
            perigee + anomaly - (turning + advancing) * gone,
            eccentricity=eccentricity,
            perigee=perigee - turning * gone,
            oblateness_m2=OBLATENESS_M2,
        )
    )
