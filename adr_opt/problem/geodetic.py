"""Places on the Earth, on the ellipsoid of WGS 84."""

from __future__ import annotations

import math

import numpy as np
import numpy.typing as npt

Array = npt.NDArray[np.float64]

EQUATOR_M, FLATTENING = 6_378_137.0, 1.0 / 298.257223563
"""The ellipsoid of WGS 84."""

SQUARED = FLATTENING * (2.0 - FLATTENING)
"""Square of the ellipsoid's eccentricity."""

ROUNDS = 3
"""Iterations of :func:`above`; each gains three digits."""


def upward(latitude_deg: npt.ArrayLike, longitude_deg: npt.ArrayLike) -> Array:
    """Direction of the zenith in axes that turn with the Earth, shape (..., 3)."""
    latitude, longitude = np.radians(latitude_deg), np.radians(longitude_deg)
    across = np.cos(latitude)
    parts = across * np.cos(longitude), across * np.sin(longitude), np.sin(latitude)
    return np.stack(parts, axis=-1)


def place(latitude_deg: float, longitude_deg: float, altitude_m: float) -> Array:
    """Position in axes that turn with the Earth, shape (3,) [m]."""
    up = upward(latitude_deg, longitude_deg)
    across = EQUATOR_M / math.sqrt(1.0 - SQUARED * up[2] ** 2)
    stretched = np.array([across, across, across * (1.0 - SQUARED)])
    found: Array = up * (stretched + altitude_m)
    return found


def above(position: Array) -> tuple[float, float]:
    """Geodetic latitude [deg] and height [m] of a position, (3,) [m]."""
    across = math.hypot(position[0], position[1])
    latitude, height = math.atan2(position[2], across * (1.0 - SQUARED)), 0.0
    for _ in range(ROUNDS):  # the normal of the ellipsoid is not the line to the centre
        sine = math.sin(latitude)
        root = math.sqrt(1.0 - SQUARED * sine * sine)
        height = across * math.cos(latitude) + position[2] * sine - EQUATOR_M * root
        normal = EQUATOR_M / root
        latitude = math.atan2(position[2], across * (1.0 - SQUARED * normal / (normal + height)))
    return math.degrees(latitude), height
