"""Direction of the Sun in the frame of the elements, for day and night on the page."""

from __future__ import annotations

import math
from datetime import UTC, datetime
from typing import NamedTuple

from ..common.constants import DAY_S
from ..kernels.orbits.sunlight import (
    ANOMALY_RAD,
    ANOMALY_RATE_RAD_S,
    CENTRE_RAD,
    CENTRE_TWICE_RAD,
    LONGITUDE_RAD,
    LONGITUDE_RATE_RAD_S,
    OBLIQUITY_RAD,
)
from .frame import OF_DATE
from .instance import Instance

TURN_S = 86400.0
"""Sidereal seconds per turn."""

CENTURY_DAYS = 36525.0

TURNS_MORE = 0.00273781191135448
"""Excess rotation of the Earth against the stars per day of UT1, in turns."""

J2000 = datetime(2000, 1, 1, 12, tzinfo=UTC)


def sidereal_angle_rad(time: datetime) -> float:
    """Greenwich mean sidereal time of 1982.

    It counts from the mean equinox of date, as elements of TLEs do. UTC is taken for UT1, from
    which it differs by less than a second of time, 0.004°.

    Parameters
    ----------
    time : datetime
        With a time zone.

    Returns
    -------
    float
        From 0 to 2π [rad].

    Notes
    -----
    S. Aoki and others, The new definition of universal time, Astronomy and Astrophysics 105 (1982),
    359–361.
    """
    since = (time.astimezone(UTC) - J2000).total_seconds()
    centuries = since / DAY_S / CENTURY_DAYS
    seconds = (
        67310.54841
        + since
        + centuries * (8640184.812866 + centuries * (0.093104 - 6.2e-6 * centuries))
    )
    return 2.0 * math.pi * math.fmod(math.fmod(seconds, TURN_S) + TURN_S, TURN_S) / TURN_S


def earth_rotation_angle_rad(time: datetime) -> float:
    """Earth rotation angle in axes independent of the equinox, those of GCRF, from 0 to 2π.

    In EME2000 it is the same to a hundred-thousandth of a degree, and less than the sidereal one by
    what the equinox has moved since 2000, a third of a degree in 2026 (IERS conventions of 2010,
    equation 5.15).
    """
    days = (time.astimezone(UTC) - J2000).total_seconds() / DAY_S
    turns = math.fmod(days, 1.0) + 0.7790572732640 + TURNS_MORE * days
    return 2.0 * math.pi * (turns % 1.0)


def greenwich(instance: Instance) -> tuple[float, float]:
    """Angle of Greenwich at the epoch [rad], and its rate [rad/s].

    Counted from the first axis of the frame that the instance names, and from the equinox of date
    where it names none.
    """
    frame = instance.frame
    if frame is None or frame.name in OF_DATE:
        return sidereal_angle_rad(instance.epoch), sidereal_rate_rad_s()
    return earth_rotation_angle_rad(instance.epoch), 2.0 * math.pi / DAY_S * (1.0 + TURNS_MORE)


def sidereal_rate_rad_s() -> float:
    """Rate of Greenwich against the equinox of date [rad/s]."""
    return 2.0 * math.pi / DAY_S * (1.0 + 8640184.812866 / (CENTURY_DAYS * DAY_S))


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
