"""Motion on closed orbits in closed form, up to Kepler's equation."""

from __future__ import annotations

import math

import numpy as np
import numpy.typing as npt

from ...common.constants import MU_M3_S2
from ...kernels.orbits import ephemeris

Array = npt.NDArray[np.float64]

MOST_STEPS = 60
"""Maximum number of safeguarded Newton steps; near-circular orbits take three or four."""

TOLERANCE_RAD = 1e-14
"""Last step of the eccentric anomaly, relative to a revolution: a hundred nanometres of travel."""

MOST_REVOLUTIONS = 1e5
"""Longest coast: beyond it the phase loses too many digits."""


def drift(
    position_m: npt.ArrayLike,
    velocity_m_s: npt.ArrayLike,
    after_s: npt.ArrayLike,
    oblateness_m2: float,
) -> tuple[Array, Array]:
    """States on a near-circular orbit in the mean dynamics (docs/model.md sections 1 and 2).

    Two-body motion at the pace at which the argument of latitude advances, in a plane that turns
    with the node.

    Parameters
    ----------
    position_m, velocity_m_s, after_s
        As :func:`propagate` takes them.
    oblateness_m2 : float
        J2 R²; with 0 it is :func:`propagate`.

    Returns
    -------
    positions_m, velocities_m_s : (n, 3) float64

    Raises
    ------
    ArithmeticError
        As :func:`propagate`.
    """
    times = np.atleast_1d(np.asarray(after_s, dtype=float))
    if not ephemeris.planes_drift(oblateness_m2):
        return propagate(position_m, velocity_m_s, times)
    pace, node_rate = secular(position_m, velocity_m_s, oblateness_m2)
    positions, velocities = propagate(position_m, velocity_m_s, pace * times)
    return turned(positions, node_rate * times), turned(velocities, node_rate * times)


def secular(
    position_m: npt.ArrayLike, velocity_m_s: npt.ArrayLike, oblateness_m2: float
) -> tuple[float, float]:
    """Difference of the mean dynamics from two-body motion on a near-circular orbit.

    Returns
    -------
    pace : float
        How fast the orbit is run through, 1 in two-body motion.
    node_rate : float
        How fast its plane turns about the axis of the Earth [rad/s].

    Raises
    ------
    ArithmeticError
        The orbit is not closed.
    """
    if not ephemeris.planes_drift(oblateness_m2):
        return 1.0, 0.0
    r, v = np.asarray(position_m, dtype=float), np.asarray(velocity_m_s, dtype=float)
    inverse_axis = 2.0 / math.hypot(*r) - float(v @ v) / MU_M3_S2
    if not inverse_axis > 0.0:
        raise ArithmeticError(f"at {math.hypot(*v):.6g} m/s the chaser leaves the Earth")
    momentum = np.cross(r, v)
    inclination = math.acos(momentum[2] / math.hypot(*momentum))
    axis = 1.0 / inverse_axis
    pace = ephemeris.latitude_rate(axis, inclination, oblateness_m2) / ephemeris.mean_motion(axis)
    return float(pace), float(ephemeris.node_rate(axis, inclination, oblateness_m2))


def revolution(position_m: npt.ArrayLike, velocity_m_s: npt.ArrayLike) -> float:
    """Period of a closed Kepler orbit [s]."""
    r, v = np.asarray(position_m, dtype=float), np.asarray(velocity_m_s, dtype=float)
    axis = 1.0 / (2.0 / math.hypot(*r) - float(v @ v) / MU_M3_S2)
    return 2.0 * math.pi * math.sqrt(axis**3 / MU_M3_S2)


def turned(vectors: Array, angles: Array) -> Array:
    """Vectors rotated about the axis of the Earth, each by its angle; shape (n, 3)."""
    c, s = np.cos(angles), np.sin(angles)
    x, y, z = vectors.T
    return np.stack([c * x - s * y, s * x + c * y, z], axis=1)


def propagate(
    position_m: npt.ArrayLike, velocity_m_s: npt.ArrayLike, after_s: npt.ArrayLike
) -> tuple[Array, Array]:
    """States on one Kepler orbit at several times.

    Parameters
    ----------
    position_m, velocity_m_s : (3,) array_like
        State at time zero.
    after_s : (n,) array_like
        Times after (or, negative, before) that state [s].

    Returns
    -------
    positions_m, velocities_m_s : (n, 3) float64

    Raises
    ------
    ArithmeticError
        The orbit is not closed, or a time is beyond :data:`MOST_REVOLUTIONS`.

    Notes
    -----
    Lagrange's f and g in the *difference* x of eccentric anomalies (R. Battin, An Introduction to
    the Mathematics and Methods of Astrodynamics, section 4.3). No perigee is asked for, so circles
    are no special case.
    """
    r, v = np.asarray(position_m, dtype=float), np.asarray(velocity_m_s, dtype=float)
    times = np.atleast_1d(np.asarray(after_s, dtype=float))
    with np.errstate(all="ignore"):
        radius = math.hypot(*r)
        speed = math.hypot(*v)
        inverse_axis = 2.0 / radius - speed * speed / MU_M3_S2
    if not inverse_axis > 0.0:
        raise ArithmeticError(f"at {speed:.6g} m/s the chaser leaves the Earth")
    axis = 1.0 / inverse_axis
    rate = math.sqrt(MU_M3_S2 * inverse_axis) * inverse_axis
    anomaly = rate * times
    if not bool(np.all(np.abs(anomaly) < 2.0 * math.pi * MOST_REVOLUTIONS)):
        raise ArithmeticError(f"{float(np.max(np.abs(times))):.6g} s is too long for one coast")

    c = 1.0 - radius * inverse_axis  # e cos E at time zero
    s = float(r @ v) / math.sqrt(MU_M3_S2 * axis)  # e sin E
    # Whole revolutions change nothing and would only cost digits.
    x = _anomaly_difference(np.remainder(anomaly + math.pi, 2.0 * math.pi) - math.pi, c, s)
    sine, cosine, versine = np.sin(x), np.cos(x), 2.0 * np.sin(0.5 * x) ** 2
    distance = axis * (1.0 - c * cosine + s * sine)
    root = math.sqrt(MU_M3_S2 * axis)
    f = 1.0 - axis / radius * versine
    g = (radius * sine + s * axis * versine) * axis / root
    f_dot = -root / (distance * radius) * sine
    g_dot = 1.0 - axis / distance * versine
    return (f[:, None] * r + g[:, None] * v, f_dot[:, None] * r + g_dot[:, None] * v)


def _anomaly_difference(mean: Array, c: float, s: float) -> Array:
    """Solve x − c sin x + s (1 − cos x) = mean, Kepler's equation in differences.

    The left side grows (its slope is the distance over the axis), so that Newton's step is kept
    between bounds that close in and no eccentricity below one is too large.
    """
    reach = 2.0 * math.hypot(c, s) + 1e-12
    low, high = mean - reach, mean + reach
    x = mean + c * np.sin(mean) - s * (1.0 - np.cos(mean))
    x = np.clip(x, low, high)
    for _ in range(MOST_STEPS):
        excess = x - c * np.sin(x) + s * 2.0 * np.sin(0.5 * x) ** 2 - mean
        low = np.where(excess < 0.0, x, low)
        high = np.where(excess > 0.0, x, high)
        step = x - excess / (1.0 - c * np.cos(x) + s * np.sin(x))
        step = np.where((step >= low) & (step <= high), step, 0.5 * (low + high))
        done = bool(np.all(np.abs(step - x) <= TOLERANCE_RAD * (1.0 + np.abs(x))))
        x = step
        if done:
            return x
    return x
