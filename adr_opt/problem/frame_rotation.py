"""Rotations between inertial frames about the Earth.

Axes of TEME are those of the celestial frame of the IERS, turned by precession and nutation of 2006
and 2000A and then by the difference between the angle of the Earth's rotation and the mean sidereal
time of 1982, which SGP4 goes by (D. Vallado et al., Revisiting Spacetrack Report 3, AIAA 2006-6753,
appendix C). Both angles follow UT1 and nearly cancel, so that UTC serves for it, no data of the
Earth's rotation matter, and nothing is asked of the network. EME2000 differs from GCRF by the
constant frame bias, 0.8 m in low orbit.
"""

from __future__ import annotations

from collections.abc import Sequence
from datetime import UTC, datetime
from typing import Any

import numpy as np
import numpy.typing as npt

from ..common.constants import DAY_S
from ..common.errors import MissingExtra
from .frame import Frame

Array = npt.NDArray[np.float64]

J2000 = datetime(2000, 1, 1, 12, tzinfo=UTC)
"""Calendar time of Julian date 2451545."""


def rotation(start: Frame, end: Frame) -> Array | None:
    """Rotation matrix between two frames; None if their axes are equal.

    Raises
    ------
    MissingExtra
        astropy is not installed.
    """
    if start == end or {start.name, end.name} <= {"GCRF", "ICRF"}:
        return None
    matrix: Array = from_gcrf(end) @ from_gcrf(start).T
    return matrix


def from_gcrf(frame: Frame) -> Array:
    """Rotation matrix from GCRF to a frame, shape (3, 3).

    Raises
    ------
    MissingExtra
        astropy is not installed.
    """
    if frame.axes_epoch is not None:
        matrix: Array = teme_axes([frame.axes_epoch])[0]
        return matrix
    if frame.name == "EME2000":
        erfa = _erfa()
        bias, _, _ = erfa.bp06(erfa.DJ00, 0.0)
        return np.asarray(bias)
    return np.eye(3)


def teme_axes(times: Sequence[datetime]) -> Array:
    """Axes of TEME at times as rows, in GCRF, shape (times, 3, 3).

    Raises
    ------
    MissingExtra
        astropy is not installed.
    """
    erfa = _erfa()
    utc = np.array([(time - J2000).total_seconds() / DAY_S for time in times])
    # Terrestrial time is a minute ahead of UTC, to within some seconds of precession: nothing.
    celestial = erfa.c2i06a(erfa.DJ00, utc + 65.0 / DAY_S)
    angle = erfa.era00(erfa.DJ00, utc) - erfa.gmst82(erfa.DJ00, utc)
    c, s = np.cos(angle), np.sin(angle)
    turned: Array = celestial.copy()
    turned[:, 0] = c[:, None] * celestial[:, 0] + s[:, None] * celestial[:, 1]
    turned[:, 1] = c[:, None] * celestial[:, 1] - s[:, None] * celestial[:, 0]
    return turned


def _erfa() -> Any:
    try:
        import erfa
    except ImportError:
        raise MissingExtra("turning states into another frame", "astropy", "astro") from None
    return erfa
