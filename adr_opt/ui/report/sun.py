"""Direction of the Sun in the frame of the elements, for day and night on the page."""

from __future__ import annotations

import math
from typing import NamedTuple

from ...common.constants import DAY_S
from ...kernels.orbits.sunlight import (
    ANOMALY_RAD,
    ANOMALY_RATE_RAD_S,
    CENTRE_RAD,
    CENTRE_TWICE_RAD,
    LONGITUDE_RAD,
    LONGITUDE_RATE_RAD_S,
    OBLIQUITY_RAD,
)
from ...problem.frame import OF_DATE
from ...problem.instance import Instance
from .greenwich import CENTURY_DAYS, J2000

PRECESSION_RAD_S = math.radians(5029.0966 / 3600.0) / (CENTURY_DAYS * DAY_S)
"""Motion of the equinox along the ecliptic: J. H. Lieske and others, Expressions for the precession
quantities, Astronomy and Astrophysics 58 (1977), 1–16."""


class Sun(NamedTuple):
    """The Sun along the ecliptic, from the epoch on.

    Its longitude is the mean one, advanced by the equation of the centre.

    Attributes
    ----------
    longitude_rad, longitude_rate_rad_s : float
        Mean longitude at the epoch, and its rate.
    anomaly_rad, anomaly_rate_rad_s : float
        Mean anomaly at the epoch, and its rate.
    centre_rad, centre_twice_rad : float
        Amplitudes of the equation of the centre.
    obliquity_rad : float
        Of the ecliptic to the equator.
    """

    longitude_rad: float
    longitude_rate_rad_s: float
    anomaly_rad: float
    anomaly_rate_rad_s: float
    centre_rad: float
    centre_twice_rad: float
    obliquity_rad: float


def sun(instance: Instance) -> Sun:
    """The low-precision Sun of the kernels, counted from the epoch and in the instance's frame.

    The formulas are those of the Astronomical Almanac, page C5, good to 0.01° until 2050. They
    count from the equinox of date; in a frame with the equinox of J2000 longitudes are less by what
    the equinox has moved since.
    """
    since_s = (instance.epoch - J2000).total_seconds()
    frame = instance.frame
    moved = 0.0 if frame is None or frame.name in OF_DATE else PRECESSION_RAD_S
    rate = LONGITUDE_RATE_RAD_S - moved
    turn = 2.0 * math.pi
    return Sun(
        (LONGITUDE_RAD + rate * since_s) % turn,
        rate,
        (ANOMALY_RAD + ANOMALY_RATE_RAD_S * since_s) % turn,
        ANOMALY_RATE_RAD_S,
        CENTRE_RAD,
        CENTRE_TWICE_RAD,
        OBLIQUITY_RAD,
    )
