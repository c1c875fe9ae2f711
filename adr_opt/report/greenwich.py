"""Where the Earth is under the orbits: the angle of Greenwich in the frame of the elements."""

from __future__ import annotations

import math
from datetime import UTC, datetime

from ..kernels.constants import DAY_S

TURN_S = 86400.0
"""Seconds of sidereal time in a turn."""

CENTURY_DAYS = 36525.0

J2000 = datetime(2000, 1, 1, 12, tzinfo=UTC)


def sidereal_angle_rad(time: datetime) -> float:
    """Greenwich mean sidereal time, of 1982.

    It counts from the mean equinox of date, as elements of TLEs do. An instance does not say which
    inertial frame is its own: in that of J2000 the angle is less by what the equinox has moved
    since, a third of a degree in 2026. UTC is taken for UT1, from which it differs by less than a
    second of time, 0.004°.

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


def sidereal_rate_rad_s() -> float:
    """How fast Greenwich turns in the frame of the elements [rad/s]."""
    return 2.0 * math.pi / DAY_S * (1.0 + 8640184.812866 / (CENTURY_DAYS * DAY_S))
