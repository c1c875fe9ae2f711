"""Free motion in mean elements: Kepler's, with the secular rates of J2 (docs/model.md section 1.3).

A state is a place and a velocity, taken for those of a mean orbit. Until the next burn the mean
anomaly advances at its rate, and the plane's own line of apsides and its node turn at theirs. No
angle of perigee or node is asked for, so that circles and equatorial orbits are no special case: a
motion is a Kepler arc, a turn about the normal of the plane and one about the axis of the Earth.
"""

import math

import numpy as np

from ...common.constants import MU_M3_S2
from ..core.compile import kernel
from .coast import chain

MOST_STEPS = 50
"""Maximum number of Newton steps for Kepler's equation; near-circular orbits need three or four."""

CLOSE_RAD = 1e-15

STEP_M, STEP_M_S = 10.0, 1e-2
"""Perturbations of states for derivatives over one revolution."""

LOWEST_M = 1e6
"""Least semi-latus rectum; below it an orbit is nearly a vertical fall, and is rejected [m]."""


@kernel
def rates(state, oblateness, slopes):
    """Secular rates of the mean orbit of a state.

    Parameters
    ----------
    state : (6,) float64
        [m, m/s].
    oblateness : float
        J2 R², 0 for two bodies [m²].
    slopes : (3, 6) or (0, 0) float64
        Written to: derivatives of the three by the state.

    Returns
    -------
    anomaly, apsis, node : float
        Of the mean anomaly, of the apsides within the plane and of the node [rad/s]; NaN where the
        orbit is not closed or passes the centre of the Earth.
    """
    x, y, z = state[0], state[1], state[2]
    u, v, w = state[3], state[4], state[5]
    radius = math.sqrt(x * x + y * y + z * z)
    inverse = 2.0 / radius - (u * u + v * v + w * w) / MU_M3_S2
    hx, hy, hz = y * w - z * v, z * u - x * w, x * v - y * u
    h = math.sqrt(hx * hx + hy * hy + hz * hz)
    parameter = h * h / MU_M3_S2
    if not (inverse > 0.0 and parameter > LOWEST_M):
        return math.nan, math.nan, math.nan
    n = math.sqrt(MU_M3_S2 * inverse) * inverse
    cosine = hz / h
    square = cosine * cosine
    root = math.sqrt(min(parameter * inverse, 1.0))
    # Kozai's first-order rates (docs/model.md section 1.3), in p, 1/a and cos i alone.
    pull = 1.5 * oblateness / (parameter * parameter) * n
    anomaly = n + 0.5 * pull * root * (3.0 * square - 1.0)
    apsis = 0.5 * pull * (5.0 * square - 1.0)
    node = -pull * cosine
    if slopes.shape[0] == 0:
        return anomaly, apsis, node
    # By 1/a, by h and by h_z: n goes with the power 3/2 of the first, pull with −4 of the second.
    by_inverse = (
        (1.5 * n + pull * root * (3.0 * square - 1.0)) / inverse,
        1.5 * apsis / inverse,
        1.5 * node / inverse,
    )
    by_h = (
        0.5 * pull * root * (3.0 - 15.0 * square) / h,
        0.5 * pull * (4.0 - 30.0 * square) / h,
        5.0 * pull * cosine / h,
    )
    by_hz = (3.0 * pull * root * cosine / h, 5.0 * pull * cosine / h, -pull / h)
    nx, ny, nz = hx / h, hy / h, hz / h
    cube = radius * radius * radius
    of_inverse = (
        -2.0 * x / cube,
        -2.0 * y / cube,
        -2.0 * z / cube,
        -2.0 * u / MU_M3_S2,
        -2.0 * v / MU_M3_S2,
        -2.0 * w / MU_M3_S2,
    )
    of_h = (
        v * nz - w * ny,
        w * nx - u * nz,
        u * ny - v * nx,
        ny * z - nz * y,
        nz * x - nx * z,
        nx * y - ny * x,
    )
    of_hz = (v, -u, 0.0, -y, x, 0.0)
    for rate in range(3):
        for axis in range(6):
            slopes[rate, axis] = (
                by_inverse[rate] * of_inverse[axis]
                + by_h[rate] * of_h[axis]
                + by_hz[rate] * of_hz[axis]
            )
    return anomaly, apsis, node


@kernel
def advance(state, anomaly, apsis, node):
    """Advance a state along its orbit and rotate that orbit, in place.

    Parameters
    ----------
    state : (6,) float64
        On a closed orbit [m, m/s].
    anomaly, apsis, node : float
        By which the mean anomaly advances, the orbit turns about the normal of its plane, and then
        about the axis of the Earth [rad].
    """
    x, y, z = state[0], state[1], state[2]
    u, v, w = state[3], state[4], state[5]
    radius = math.sqrt(x * x + y * y + z * z)
    inverse = 2.0 / radius - (u * u + v * v + w * w) / MU_M3_S2
    hx, hy, hz = y * w - z * v, z * u - x * w, x * v - y * u
    h = math.sqrt(hx * hx + hy * hy + hz * hz)
    a = 1.0 / inverse
    # Lagrange's f and g in the difference of eccentric anomalies, less whole revolutions.
    c = 1.0 - radius * inverse  # e cos E
    s = (x * u + y * v + z * w) / math.sqrt(MU_M3_S2 * a)  # e sin E
    left = anomaly - 2.0 * math.pi * math.floor(anomaly / (2.0 * math.pi) + 0.5)
    e = left + c * math.sin(left) - s * (1.0 - math.cos(left))
    # The excess rises with e, its slope being r/a > 0, and the other terms are no more than
    # `reach`: the root lies between the ends, and a Newton step that leaves them is halved instead.
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
    sine, cosine, versine = math.sin(e), math.cos(e), 2.0 * math.sin(0.5 * e) ** 2
    distance = a * (1.0 - c * cosine + s * sine)
    root = math.sqrt(MU_M3_S2 * a)
    f = 1.0 - a / radius * versine
    g = (radius * sine + s * a * versine) * a / root
    f_dot = -root / (distance * radius) * sine
    g_dot = 1.0 - a / distance * versine

    ca, sa = math.cos(apsis), math.sin(apsis)
    cn, sn = math.cos(node), math.sin(node)
    nx, ny, nz = hx / h, hy / h, hz / h
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


@kernel
def coast(state, duration, oblateness):
    """Propagate a state in free motion, in place.

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
    anomaly, apsis, node = rates(state, oblateness, np.empty((0, 0)))
    if not anomaly > 0.0:
        for axis in range(6):
            state[axis] = math.nan
        return 0.0
    if duration == 0.0:
        return 0.0
    x, y, z = state[0], state[1], state[2]
    u, v, w = state[3], state[4], state[5]
    hx, hy, hz = y * w - z * v, z * u - x * w, x * v - y * u
    cosine = hz / math.sqrt(hx * hx + hy * hy + hz * hz)
    advance(state, anomaly * duration, apsis * duration, node * duration)
    return (anomaly + apsis + node * cosine) * duration


@kernel
def derivative(state, duration, oblateness):
    """Derivative of the propagated state by the initial state, shape (6, 6).

    What grows with time goes by way of the three angles, whose slopes are exact: differences would
    lose, after months, what cancels between places and velocities. What is left of it is that of an
    advance by given angles, for which differences do.
    """
    matrix, slopes = np.empty((6, 6)), np.empty((3, 6))
    anomaly, apsis, node = rates(state, oblateness, slopes)
    if not anomaly > 0.0:
        for i in range(6):
            for j in range(6):
                matrix[i, j] = math.nan
        return matrix
    moved, above, end = np.empty(6), np.empty(6), np.empty(6)
    # With all three angles held: a difference over one revolution, whatever the duration.
    for column in range(6):
        step = STEP_M if column < 3 else STEP_M_S
        for axis in range(6):
            moved[axis] = state[axis]
        moved[column] = state[column] + step
        advance(moved, anomaly * duration, apsis * duration, node * duration)
        for axis in range(6):
            above[axis] = moved[axis]
            moved[axis] = state[axis]
        moved[column] = state[column] - step
        advance(moved, anomaly * duration, apsis * duration, node * duration)
        for axis in range(6):
            matrix[axis, column] = (above[axis] - moved[axis]) / (2.0 * step)
    for axis in range(6):
        end[axis] = state[axis]
    advance(end, anomaly * duration, apsis * duration, node * duration)
    x, y, z = end[0], end[1], end[2]
    u, v, w = end[3], end[4], end[5]
    radius = math.sqrt(x * x + y * y + z * z)
    inverse = 2.0 / radius - (u * u + v * v + w * w) / MU_M3_S2
    n = math.sqrt(MU_M3_S2 * inverse) * inverse
    hx, hy, hz = y * w - z * v, z * u - x * w, x * v - y * u
    h = math.sqrt(hx * hx + hy * hy + hz * hz)
    nx, ny, nz = hx / h, hy / h, hz / h
    fall = -MU_M3_S2 / (radius * radius * radius * n)
    by_anomaly = (u / n, v / n, w / n, fall * x, fall * y, fall * z)
    by_apsis = (
        ny * z - nz * y,
        nz * x - nx * z,
        nx * y - ny * x,
        ny * w - nz * v,
        nz * u - nx * w,
        nx * v - ny * u,
    )
    by_node = (-y, x, 0.0, -v, u, 0.0)
    for i in range(6):
        for j in range(6):
            along = by_anomaly[i] * slopes[0, j]
            turned = by_apsis[i] * slopes[1, j] + by_node[i] * slopes[2, j]
            matrix[i, j] += duration * (along + turned)
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
    chain(arcs)
    return states, arcs, angle
