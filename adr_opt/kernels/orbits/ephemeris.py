"""Ephemeris of bodies: frames, relative nodes and states at a time.

A body is a row of :data:`ORBIT_COLUMNS`, angles at t = 0. It moves on a circle whose node and
argument of latitude advance at the rates of the row: those of two-body motion, or the secular ones
of J2 (docs/model.md section 1). Where an orbit decays, the argument of latitude is quadratic in
time; radius and node, which change far less, keep to those of the epoch. Elements, rates and states
of a body at a time are asked for here, and no other room knows how a row holds them:
:mod:`.elements` has those of many bodies as arrays, :func:`body_row` makes a row, and
:mod:`.body_rows` changes some.

Every element takes a time, also those that do not change in today's dynamics. So an orbit that
changes with time is a change of this room.
"""

import math

import numpy as np

from ...common.constants import DAY_S, MU_M3_S2
from ..core.compile import inlined, kernel
from .columns import (
    ARGUMENT_OF_LATITUDE,
    COASTING_RAAN_RATE,
    ECCENTRICITY,
    INCLINATION,
    LATITUDE_ACCELERATION,
    LATITUDE_RATE,
    PERIGEE,
    PERIGEE_RATE,
    RAAN,
    RAAN_RATE,
    RADIUS,
)
from .columns import ORBIT_COLUMNS as ORBIT_COLUMNS

EPOCH_S = 0.0
"""Time at which mission-wide elements are evaluated: the epoch of the instance [s]."""

COPLANAR_RAD = 1e-9
"""Angle to equal or opposite within which two planes get an arbitrary line of nodes [rad]."""


@kernel
def mean_motion(radius):
    """Angular rate of a circular orbit [rad/s]."""
    return math.sqrt(MU_M3_S2 / radius) / radius


@kernel
def node_rate(radius, inclination, oblateness):
    """Secular rate of the node of a circular orbit (docs/model.md section 1) [rad/s].

    Parameters
    ----------
    radius, inclination : float
        [m], [rad].
    oblateness : float
        J2 R², 0 for two bodies [m²].
    """
    return -1.5 * oblateness / radius**2 * mean_motion(radius) * math.cos(inclination)


@kernel
def latitude_rate(radius, inclination, oblateness):
    """Secular rate of the argument of latitude of a circular orbit [rad/s].

    See docs/model.md section 1.
    """
    widening = 1.5 * oblateness / radius**2 * (4.0 * math.cos(inclination) ** 2 - 1.0)
    return mean_motion(radius) * (1.0 + widening)


@kernel
def secular_rates(axis, eccentricity, inclination, oblateness):
    """Secular rates of a mean orbit (docs/model.md section 1).

    Parameters
    ----------
    axis, eccentricity, inclination : float
        [m], –, [rad].
    oblateness : float
        J2 R², 0 for two bodies [m²].

    Returns
    -------
    node, perigee, anomaly : float
        Of RAAN, argument of perigee and mean anomaly [rad/s].
    """
    n = mean_motion(axis)
    square = 1.0 - eccentricity * eccentricity
    strength = 1.5 * oblateness / (axis * square) ** 2 * n
    cosine = math.cos(inclination)
    return (
        -strength * cosine,
        0.5 * strength * (5.0 * cosine * cosine - 1.0),
        n + 0.5 * strength * math.sqrt(square) * (3.0 * cosine * cosine - 1.0),
    )


def body_row(
    radius_m: float,
    inclination: float,
    node: float,
    latitude: float,
    *,
    eccentricity: float = 0.0,
    perigee: float = 0.0,
    oblateness_m2: float = 0.0,
    decay_m_per_day: float = 0.0,
) -> tuple[float, ...]:
    """Row of a body on a mean orbit, with its secular rates (docs/model.md section 1).

    Parameters
    ----------
    radius_m, inclination : float
        Of the circle that is planned with [m], [rad].
    node, latitude : float
        RAAN and argument of latitude at t = 0 [rad].
    eccentricity, perigee : float
        Of the true orbit, and its argument of perigee at t = 0 [rad].
    oblateness_m2 : float
        J2 R², 0 for two bodies.
    decay_m_per_day : float
        By what the semi-major axis shrinks.

    Returns
    -------
    (columns,) float
        :data:`ORBIT_COLUMNS`.
    """
    node_rate, perigee_rate, anomaly_rate = secular_rates(
        radius_m, eccentricity, inclination, oblateness_m2
    )
    return (
        radius_m,
        inclination,
        node,
        latitude,
        node_rate,
        perigee_rate + anomaly_rate,
        eccentricity,
        perigee,
        perigee_rate,
        1.5 * anomaly_rate / radius_m * (decay_m_per_day / DAY_S),
    )


@inlined
def planes_drift(oblateness):
    """Whether nodes and perigees drift: under J2, but not in two-body motion.

    Parameters
    ----------
    oblateness : float
        J2 R², 0 for two bodies [m²].
    """
    return oblateness != 0.0


@inlined
def radius_at(orbit, time):
    """Radius of the circle of a body at a time [m]."""
    return orbit[RADIUS]


@inlined
def inclination_at(orbit, time):
    """Inclination of a body at a time [rad]."""
    return orbit[INCLINATION]


@inlined
def node_at(orbit, time):
    """RAAN of a body at a time [rad]."""
    return orbit[RAAN] + orbit[RAAN_RATE] * time


@inlined
def node_rate_at(orbit, time):
    """Rate of the node of a body at a time [rad/s]."""
    return orbit[RAAN_RATE]


@inlined
def coasting_node_rate_at(orbit, time):
    """Node rate of a chaser that left a body at a time and stays on its orbit [rad/s]."""
    if orbit.size > COASTING_RAAN_RATE:
        return orbit[COASTING_RAAN_RATE]
    return node_rate_at(orbit, time)


@inlined
def latitude_at(orbit, time):
    """Argument of latitude of a body at a time [rad]."""
    rate = orbit[LATITUDE_RATE] + 0.5 * orbit[LATITUDE_ACCELERATION] * time
    return orbit[ARGUMENT_OF_LATITUDE] + rate * time


@inlined
def latitude_rate_at(orbit, time):
    """Rate of the argument of latitude of a body at a time [rad/s]."""
    return orbit[LATITUDE_RATE] + orbit[LATITUDE_ACCELERATION] * time


@inlined
def latitude_acceleration_at(orbit, time):
    """Second derivative of the argument of latitude of a body at a time, by its decay [rad/s²]."""
    return orbit[LATITUDE_ACCELERATION]


@inlined
def revolution_at(orbit, time):
    """Nodal period of a body at a time [s]."""
    return 2.0 * math.pi / latitude_rate_at(orbit, time)


@inlined
def eccentricity_at(orbit, time):
    """Eccentricity of the true orbit of a body at a time."""
    return orbit[ECCENTRICITY]


@inlined
def perigee_at(orbit, time):
    """Argument of perigee of the true orbit of a body at a time [rad]."""
    return orbit[PERIGEE] + orbit[PERIGEE_RATE] * time


@inlined
def perigee_rate_at(orbit, time):
    """Rate of the argument of perigee of a body at a time [rad/s]."""
    return orbit[PERIGEE_RATE]


@inlined
def node_tangent(orbit, time):
    """Tangent of a node's motion at a time, as its value at t = 0 and its rate.

    Returns
    -------
    node, rate : float
        The RAAN that the line has at t = 0 [rad], and its slope [rad/s].
    """
    rate = node_rate_at(orbit, time)
    return node_at(orbit, time) - rate * time, rate


@inlined
def latitude_tangent(orbit, time):
    """Tangent of the argument of latitude at a time [rad], [rad/s]."""
    rate = latitude_rate_at(orbit, time)
    return latitude_at(orbit, time) - rate * time, rate


@inlined
def perigee_tangent(orbit, time):
    """Tangent of the argument of perigee at a time [rad], [rad/s]."""
    rate = perigee_rate_at(orbit, time)
    return perigee_at(orbit, time) - rate * time, rate


@kernel
def period(radius):
    """Period of a circular orbit [s]."""
    return 2.0 * math.pi / mean_motion(radius)


@kernel
def frame(inclination, raan):
    """Unit vectors of an orbital plane in the inertial frame.

    Returns
    -------
    ascending, ahead, normal : (3,) float64
        Towards the ascending node, a quarter of a revolution later, and along the angular
        momentum.
    """
    ci, si = math.cos(inclination), math.sin(inclination)
    co, so = math.cos(raan), math.sin(raan)
    ascending = np.array([co, so, 0.0])
    ahead = np.array([-so * ci, co * ci, si])
    normal = np.array([so * si, -co * si, ci])
    return ascending, ahead, normal


@inlined
def turn(vector, angle):
    """Rotate a vector about the axis of the Earth, in place."""
    c, s = math.cos(angle), math.sin(angle)
    x, y = vector[0], vector[1]
    vector[0], vector[1] = c * x - s * y, s * x + c * y


@kernel
def relative_node(inclination_i, raan_i, inclination_j, raan_j):
    """Line of nodes of two planes, N = h_i × h_j.

    Returns
    -------
    alpha_i, alpha_j : float
        Arguments of latitude of N in plane i and in plane j [rad].
    theta : float
        Angle between the planes [rad].

    Notes
    -----
    The components of N in each plane are written out by spherical trigonometry in the
    difference of the RAANs, so that nearly equal and nearly opposite planes lose no digits.

    For planes closer than :data:`COPLANAR_RAD` any line will do. The model takes α = 0 in both
    planes; that is one line only where the RAANs agree, which they need not do on two
    equatorial orbits. Here α_i = 0, and α_j is the argument of latitude of the *same* line in
    plane j: equal to the model's rule to 1e-9 rad wherever the inclination is not zero.
    """
    d = raan_j - raan_i
    cd, sd = math.cos(d), math.sin(d)
    ci, si = math.cos(inclination_i), math.sin(inclination_i)
    cj, sj = math.cos(inclination_j), math.sin(inclination_j)
    # h_j in the frame of plane i: x towards the ascending node, y ahead, z normal.
    hj_x = sj * sd
    # By the difference of the inclinations where the planes may be nearly equal, by their sum
    # where they may be nearly opposite: each form is free of cancellation where it is used.
    if cd >= 0.0:
        sine_difference = math.sin(inclination_i - inclination_j)
        versine = 2.0 * math.sin(0.5 * d) ** 2
        hj_y = sine_difference + ci * sj * versine
        hi_y = -sine_difference + cj * si * versine
    else:
        sine_sum = math.sin(inclination_i + inclination_j)
        versine = 2.0 * math.cos(0.5 * d) ** 2
        hj_y = sine_sum - ci * sj * versine
        hi_y = sine_sum - cj * si * versine
    hj_z = ci * cj + si * sj * cd
    # h_i in the frame of plane j, by exchanging the roles.
    hi_x = -si * sd
    sine = math.hypot(hj_x, hj_y)
    theta = math.atan2(sine, hj_z)
    if theta < COPLANAR_RAD or theta > math.pi - COPLANAR_RAD:
        return 0.0, math.atan2(-sd * cj, cd), theta
    # z × h_j = (-h_y, h_x); and N = h_i × h_j = -(h_j × h_i).
    return math.atan2(hj_x, -hj_y), math.atan2(-hi_x, hi_y), theta


@kernel
def state_at(orbit, time):
    """Inertial position and velocity of a body at a time.

    The velocity is that of the circle, as if its plane stood still.

    Parameters
    ----------
    orbit : (columns,) float64
        One row of :data:`ORBIT_COLUMNS`.
    time : float
        Time since the epoch [s].

    Returns
    -------
    position, velocity : (3,) float64
        [m], [m/s].
    """
    radius = radius_at(orbit, time)
    n = mean_motion(radius)
    u = latitude_at(orbit, time)
    ascending, ahead, _ = frame(inclination_at(orbit, time), node_at(orbit, time))
    position, velocity = np.empty(3), np.empty(3)
    for axis in range(3):
        outward = math.cos(u) * ascending[axis] + math.sin(u) * ahead[axis]
        along = math.cos(u) * ahead[axis] - math.sin(u) * ascending[axis]
        position[axis], velocity[axis] = radius * outward, radius * n * along
    return position, velocity
