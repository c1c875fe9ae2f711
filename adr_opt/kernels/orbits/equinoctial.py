"""Equinoctial elements in a chosen frame: regular for circles and for every inclination.

Elements are (a, f, g, h, k, λ): semi-major axis [m], eccentricity vector (f, g), tan(i/2) times
the direction of the node (h, k), mean longitude λ [rad], all measured in a frame whose rows are
unit vectors. In a frame near the orbit's own plane h and k are small, so nothing is singular.
(M. Walker, B. Ireland and J. Owens, Celestial Mechanics 36, 1985, for f to k.)
"""

import math

import numpy as np

from ...common.constants import MU_M3_S2
from ..core.compile import kernel


@kernel
def own_frame(state):
    """The frame of a state: outward, ahead and normal as rows, shape (3, 3)."""
    frame = np.empty((3, 3))
    r = math.sqrt(state[0] ** 2 + state[1] ** 2 + state[2] ** 2)
    for axis in range(3):
        second, third = (axis + 1) % 3, (axis + 2) % 3
        frame[0, axis] = state[axis] / r
        frame[2, axis] = state[second] * state[3 + third] - state[third] * state[3 + second]
    momentum = math.sqrt(frame[2, 0] ** 2 + frame[2, 1] ** 2 + frame[2, 2] ** 2)
    for axis in range(3):
        frame[2, axis] /= momentum
    for axis in range(3):
        second, third = (axis + 1) % 3, (axis + 2) % 3
        frame[1, axis] = frame[2, second] * frame[0, third] - frame[2, third] * frame[0, second]
    return frame


@kernel
def elements(state, frame):
    """Equinoctial elements of a state.

    Parameters
    ----------
    state : (6,) float64
        Inertial [m, m/s], on a closed orbit.
    frame : (3, 3) float64

    Returns
    -------
    (6,) float64
        NaN where the orbit is not closed.
    """
    p, v = np.empty(3), np.empty(3)
    for row in range(3):
        p[row] = v[row] = 0.0
        for axis in range(3):
            p[row] += frame[row, axis] * state[axis]
            v[row] += frame[row, axis] * state[3 + axis]
    r = math.sqrt(p[0] ** 2 + p[1] ** 2 + p[2] ** 2)
    speed = v[0] ** 2 + v[1] ** 2 + v[2] ** 2
    axis_m = 1.0 / (2.0 / r - speed / MU_M3_S2)
    m0, m1, m2 = p[1] * v[2] - p[2] * v[1], p[2] * v[0] - p[0] * v[2], p[0] * v[1] - p[1] * v[0]
    size = math.sqrt(m0 * m0 + m1 * m1 + m2 * m2)
    m0, m1, m2 = m0 / size, m1 / size, m2 / size
    h, k = -m1 / (1.0 + m2), m0 / (1.0 + m2)
    scale = 1.0 / (1.0 + h * h + k * k)
    # In-plane axes, the equinoctial ones.
    x0, x1, x2 = (1.0 + h * h - k * k) * scale, 2.0 * h * k * scale, -2.0 * k * scale
    y0, y1, y2 = 2.0 * h * k * scale, (1.0 - h * h + k * k) * scale, 2.0 * h * scale
    towards = p[0] * v[0] + p[1] * v[1] + p[2] * v[2]
    near, far = speed / MU_M3_S2 - 1.0 / r, towards / MU_M3_S2
    e0, e1, e2 = near * p[0] - far * v[0], near * p[1] - far * v[1], near * p[2] - far * v[2]
    f, g = e0 * x0 + e1 * x1 + e2 * x2, e0 * y0 + e1 * y1 + e2 * y2
    x = p[0] * x0 + p[1] * x1 + p[2] * x2
    y = p[0] * y0 + p[1] * y1 + p[2] * y2
    # The eccentric longitude F by its sine and cosine, and from it λ = F + g cos F − f sin F, which
    # is Kepler's equation in these elements.
    root = math.sqrt(1.0 - f * f - g * g)
    beta = 1.0 / (1.0 + root)
    cosine = f + ((1.0 - f * f * beta) * x - f * g * beta * y) / (axis_m * root)
    sine = g + ((1.0 - g * g * beta) * y - f * g * beta * x) / (axis_m * root)
    longitude = math.atan2(sine, cosine) + g * cosine - f * sine
    return np.array([axis_m, f, g, h, k, longitude])


@kernel
def state_of(of, frame):
    """The state with given elements in a frame: the inverse of :func:`elements`, shape (6,)."""
    a, f, g, h, k = of[0], of[1], of[2], of[3], of[4]
    root = math.sqrt(1.0 - f * f - g * g)
    beta = 1.0 / (1.0 + root)
    longitude = of[5]
    eccentric = longitude
    for _ in range(50):
        error = eccentric + g * math.cos(eccentric) - f * math.sin(eccentric) - longitude
        slope = 1.0 - g * math.sin(eccentric) - f * math.cos(eccentric)
        eccentric -= error / slope
        if abs(error) < 1e-15 * max(1.0, abs(longitude)):
            break
    c, s = math.cos(eccentric), math.sin(eccentric)
    x = a * ((1.0 - g * g * beta) * c + f * g * beta * s - f)
    y = a * ((1.0 - f * f * beta) * s + f * g * beta * c - g)
    rate = math.sqrt(MU_M3_S2 / a) / (1.0 - f * c - g * s)
    vx = rate * (f * g * beta * c - (1.0 - g * g * beta) * s)
    vy = rate * ((1.0 - f * f * beta) * c - f * g * beta * s)
    scale = 1.0 / (1.0 + h * h + k * k)
    x0, x1, x2 = (1.0 + h * h - k * k) * scale, 2.0 * h * k * scale, -2.0 * k * scale
    y0, y1, y2 = 2.0 * h * k * scale, (1.0 - h * h + k * k) * scale, 2.0 * h * scale
    state = np.zeros(6)
    p = (x * x0 + y * y0, x * x1 + y * y1, x * x2 + y * y2)
    v = (vx * x0 + vy * y0, vx * x1 + vy * y1, vx * x2 + vy * y2)
    for axis in range(3):
        for row in range(3):
            state[axis] += frame[row, axis] * p[row]
            state[3 + axis] += frame[row, axis] * v[row]
    return state


@kernel
def jacobian(state, frame):
    """Derivative of :func:`elements` by the state, by central differences, shape (6, 6)."""
    matrix, moved = np.empty((6, 6)), state.copy()
    for column in range(6):
        step = 10.0 if column < 3 else 1e-2
        moved[column] = state[column] + step
        above = elements(moved, frame)
        moved[column] = state[column] - step
        below = elements(moved, frame)
        moved[column] = state[column]
        for row in range(6):
            change = above[row] - below[row]
            if row == 5:
                change -= 2.0 * math.pi * math.floor(change / (2.0 * math.pi) + 0.5)
            matrix[row, column] = change / (2.0 * step)
    return matrix
