"""Osculating states and their numerical flight in the field of J2, as GMAT would have them.

First order in J2, for mean circles (D. Brouwer, Astronomical Journal 64, 1959; R. Lyddane, same
journal 68, 1963), and nothing of the project but constants.
"""

from __future__ import annotations

import math

import numpy as np
from scipy.integrate import solve_ivp

from adr_opt.common.constants import EARTH_RADIUS_M, J2, MU_M3_S2

Array = np.ndarray


def from_mean_circle(axis_m: float, inclination: float, node: float, latitude: float) -> Array:
    """Osculating position [m] and velocity [m/s] on a mean circle, angles in rad."""
    g, tilt = J2 * (EARTH_RADIUS_M / axis_m) ** 2, math.sin(inclination) ** 2
    twice = 2.0 * latitude
    axis = axis_m * (1.0 + 1.5 * g * tilt * math.cos(twice))
    third = 7.0 / 12.0 * tilt
    h = 1.5 * g * ((1 - 1.25 * tilt) * math.cos(latitude) + third * math.cos(3 * latitude))
    k = 1.5 * g * ((1 - 1.75 * tilt) * math.sin(latitude) + third * math.sin(3 * latitude))
    i = inclination + 0.375 * g * math.sin(2 * inclination) * math.cos(twice)
    o = node + 0.75 * g * math.cos(inclination) * math.sin(twice)
    mean = latitude - 0.75 * g * (1 - 2.5 * tilt) * math.sin(twice)
    longitude = mean  # Kepler's equation for the eccentric longitude
    for _ in range(20):
        longitude = mean + h * math.sin(longitude) - k * math.cos(longitude)
    perigee, e = math.atan2(k, h), math.hypot(h, k)
    half = math.tan(0.5 * (longitude - perigee))
    u = perigee + 2.0 * math.atan(math.sqrt((1 + e) / (1 - e)) * half)
    parameter = axis * (1 - e * e)
    radius = parameter / (1 + e * math.cos(u - perigee))
    speed = math.sqrt(MU_M3_S2 / parameter)
    towards = np.array([math.cos(o), math.sin(o), 0.0])
    ahead = np.array([-math.sin(o) * math.cos(i), math.cos(o) * math.cos(i), math.sin(i)])
    return np.concatenate(
        [
            radius * (math.cos(u) * towards + math.sin(u) * ahead),
            speed * ((math.cos(u) + h) * ahead - (math.sin(u) + k) * towards),
        ]
    )


def coast(position: Array, velocity: Array, times_s: list[float]) -> tuple[Array, Array]:
    """State after the one time that is given, by numerical integration, shapes (1, 3)."""
    way = solve_ivp(
        _pull, (0.0, times_s[0]), [*position, *velocity], method="DOP853", rtol=1e-11, atol=1e-4
    )
    return way.y[:3, -1][None], way.y[3:, -1][None]


def _pull(_: float, state: Array) -> list[float]:
    x, y, z, *velocity = state.tolist()
    square = x * x + y * y + z * z
    point = -MU_M3_S2 / (square * math.sqrt(square))
    flat = 1.5 * J2 * EARTH_RADIUS_M**2 / square
    side = point * (1.0 + flat * (1.0 - 5.0 * z * z / square))
    return [*velocity, side * x, side * y, side * z + 2.0 * point * flat * z]
