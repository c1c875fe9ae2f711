"""Free motion in mean elements: Kepler's, with the secular rates of J2 (docs/drift.md).

A state is a place and a velocity, taken for those of a mean orbit. Until the next burn the mean
anomaly advances at its rate, and the plane's own line of apsides and its node turn at theirs. No
angle of perigee or node is asked for, so that circles and equatorial orbits are no special case: a
motion is a Kepler arc, a turn about the normal of the plane and one about the axis of the Earth.
"""

import math

import numpy as np

from .compile import kernel
from .constants import MU_M3_S2

MOST_STEPS = 50
"""Of Newton's iteration for Kepler's equation; nearly circular orbits take three or four."""

CLOSE_RAD = 1e-15

STEP_M, STEP_M_S = 10.0, 1e-2
"""By which states are moved for derivatives."""

LOWEST_M = 1e6
"""Least semi-latus rectum: who falls nearly straight down is lost."""


@kernel
def coast(state, duration, oblateness):
    """Let a state move freely, in place.

    Parameters
    ----------
    state : (6,) float64
        Position and velocity of a mean orbit [m, m/s]; NaN afterwards where it is not closed or
        passes the centre of the Earth.
    duration : float
        Of either sign [s].
    oblateness : float
        J2 R², 0 for two bodies [m²].

    Returns
    -------
    float
        The angle by which the mean longitude advances [rad].
    """
    x, y, z = state[0], state[1], state[2]
    u, v, w = state[3], state[4], state[5]
    radius = math.sqrt(x * x + y * y + z * z)
    inverse = 2.0 / radius - (u * u + v * v + w * w) / MU_M3_S2
    hx, hy, hz = y * w - z * v, z * u - x * w, x * v - y * u
    momentum = math.sqrt(hx * hx + hy * hy + hz * hz)
    parameter = momentum * momentum / MU_M3_S2
    square = parameter * inverse  # 1 − e²
    if not (inverse > 0.0 and parameter > LOWEST_M):
        for axis in range(6):
            state[axis] = math.nan
        return 0.0
    if duration == 0.0:
        return 0.0
    a = 1.0 / inverse
    n = math.sqrt(MU_M3_S2 * inverse) * inverse
    cosine = hz / momentum
    strength = 1.5 * oblateness / (parameter * parameter) * n
    node = -strength * cosine * duration
    apsis = 0.5 * strength * (5.0 * cosine * cosine - 1.0) * duration
    mean = n + 0.5 * strength * math.sqrt(max(square, 0.0)) * (3.0 * cosine * cosine - 1.0)
    mean *= duration

    # Lagrange's f and g in the difference of eccentric anomalies, less whole revolutions.
    c = 1.0 - radius * inverse  # e cos E
    s = (x * u + y * v + z * w) / math.sqrt(MU_M3_S2 * a)  # e sin E
    left = mean - 2.0 * math.pi * math.floor(mean / (2.0 * math.pi) + 0.5)
    e = left + c * math.sin(left) - s * (1.0 - math.cos(left))
    reach = 2.0 * math.sqrt(c * c + s * s) + 1e-12
    low, high = left - reach, left + reach
    for _ in range(MOST_STEPS):
        excess = e - c * math.sin(e) + s * 2.0 * math.sin(0.5 * e) ** 2 - left
        if excess < 0.0:
            low = e
        else:
            high = e
        step = e - excess / (1.0 - c * math.cos(e) + s * math.sin(e))
        if not low <= step <= high:
            step = 0.5 * (low + high)
        change = abs(step - e)
        e = step
        if change <= CLOSE_RAD * (1.0 + abs(e)):
            break
    sine, cosine_e, versine = math.sin(e), math.cos(e), 2.0 * math.sin(0.5 * e) ** 2
    distance = a * (1.0 - c * cosine_e + s * sine)
    root = math.sqrt(MU_M3_S2 * a)
    f = 1.0 - a / radius * versine
    g = (radius * sine + s * a * versine) * a / root
    f_dot = -root / (distance * radius) * sine
    g_dot = 1.0 - a / distance * versine

    # Turned within the plane with the apsides, about the axis with the node.
    ca, sa = math.cos(apsis), math.sin(apsis)
    cn, sn = math.cos(node), math.sin(node)
    nx, ny, nz = hx / momentum, hy / momentum, hz / momentum
    for part in range(2):
        if part == 0:
            px, py, pz = f * x + g * u, f * y + g * v, f * z + g * w
        else:
            px, py, pz = f_dot * x + g_dot * u, f_dot * y + g_dot * v, f_dot * z + g_dot * w
        qx = ca * px + sa * (ny * pz - nz * py)
        qy = ca * py + sa * (nz * px - nx * pz)
        qz = ca * pz + sa * (nx * py - ny * px)
        state[3 * part] = cn * qx - sn * qy
        state[3 * part + 1] = sn * qx + cn * qy
        state[3 * part + 2] = qz
    return mean + apsis + node * cosine


@kernel
def derivative(state, duration, oblateness):
    """Derivative of the state after some time by the state, by central differences, (6, 6)."""
    matrix, moved = np.empty((6, 6)), np.empty(6)
    above = np.empty(6)
    for column in range(6):
        step = STEP_M if column < 3 else STEP_M_S
        for axis in range(6):
            moved[axis] = state[axis]
        moved[column] = state[column] + step
        coast(moved, duration, oblateness)
        for axis in range(6):
            above[axis] = moved[axis]
            moved[axis] = state[axis]
        moved[column] = state[column] - step
        coast(moved, duration, oblateness)
        for axis in range(6):
            matrix[axis, column] = (above[axis] - moved[axis]) / (2.0 * step)
    return matrix


@kernel
def fly(start, times, impulses, end, oblateness):
    """Fly from burn to burn.

    Parameters
    ----------
    start : (6,) float64
        State at the first time, before the burn [m, m/s].
    times : (burns,) float64
        In order [s].
    impulses : (burns, 3) float64
        [m/s].
    end : float
        Not before the last burn [s].
    oblateness : float

    Returns
    -------
    states, matrices, angle
        As of :func:`.coast.fly`, with matrices.
    """
    count = times.size
    states, arcs = np.empty((count + 1, 6)), np.empty((count, 6, 6))
    now, angle = np.empty(6), 0.0
    for axis in range(6):
        now[axis] = start[axis]
    for b in range(count):
        for axis in range(6):
            states[b, axis] = now[axis]
        for axis in range(3):
            now[3 + axis] += impulses[b, axis]
        span = (times[b + 1] if b + 1 < count else end) - times[b]
        slope = derivative(now, span, oblateness)
        for i in range(6):
            for j in range(6):
                arcs[b, i, j] = slope[i, j]
        angle += coast(now, span, oblateness)
    for axis in range(6):
        states[count, axis] = now[axis]
    product = np.empty((6, 6))
    for b in range(count - 2, -1, -1):
        for i in range(6):
            for j in range(6):
                total = 0.0
                for k in range(6):
                    total += arcs[b + 1, i, k] * arcs[b, k, j]
                product[i, j] = total
        for i in range(6):
            for j in range(6):
                arcs[b, i, j] = product[i, j]
    return states, arcs, angle
