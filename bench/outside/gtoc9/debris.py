"""The debris, as rows of the ephemeris of :mod:`adr_opt.kernels.orbits.ephemeris`."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from adr_opt.common.constants import DAY_S, OBLATENESS_M2
from adr_opt.kernels.orbits import ephemeris

from ..reading import FloatArray, filled_lines, numbers_of, published

FILE = "debris_data.txt"


@published
def read_debris(path: Path) -> FloatArray:
    """The debris of a file, in their order.

    A line holds the number of a debris, its epoch (MJD2000), semi-major axis [m], eccentricity,
    inclination, RAAN, argument of perigee and mean anomaly [rad].

    Returns
    -------
    (debris, columns) float64
        Rows of :data:`adr_opt.kernels.orbits.ephemeris.ORBIT_COLUMNS`, angles at MJD2000 0.
    """
    records = np.array([numbers_of(line, 8) for line in filled_lines(path)])
    if (records[:, 0] != np.arange(len(records))).any():
        raise ValueError("debris are not in their order")
    return np.array([_row(record) for record in records])


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
