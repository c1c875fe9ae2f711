"""The arcs of a low-thrust leg: thrust, drift, thrust.

A chaser with continuous thrust needs many revolutions for a change of orbit. Averaged over a
revolution a change of size costs what a Hohmann transfer costs to second order, |V_0 − V_1|, and
one of the plane by θ costs κ V θ, with a thrust whose yaw is constant and changes its sign twice a
revolution (Edelbaum, ARS Journal 31(8), 1961, 1079–1089). Where thrust is on only within ±η about
the two best arguments of latitude,

    κ = η / sin η    at a share 2 η / π of the time:

cheaper and slower. Along an arc of constant yaw the speed of the orbit changes uniformly, so means
of its powers, which rates are, are polynomials of the speeds at both ends.
"""

import math
from typing import NamedTuple

from ...common.constants import MU_M3_S2
from ..core.compile import inlined
from .drift_arcs import NodeSeries
from .drift_linear import LinearPair
from .drift_pair import DriftPair

EARLY, OUTER, INNER = 0.5 - math.sqrt(0.15), 5.0 / 18.0, 8.0 / 18.0
"""First point, and weights, of Gauss's rule with three points on (0, 1)."""


FLAT = 0.02
"""Angle below which a series stands for its sine [rad]: to 1e-9 of it."""


class Thrust(NamedTuple):
    """Thrust of a chaser at the beginning of a leg.

    Attributes
    ----------
    acceleration : float
        At departure, times the share of time that the duty cycle allows [m/s²].
    exhaust : float
        g₀ Isp [m/s].
    """

    acceleration: float
    exhaust: float


class ArcTimes(NamedTuple):
    """Durations of both arcs of thrust [s]."""

    first: float
    second: float


@inlined
def weighted(pair, turn):
    """A pair in which changes of plane, and all derived from them, are weighted by κ.

    The form of :mod:`.drift` then holds of it as it stands: node and inclination enter that only
    with the mean speed as their factor.
    """
    of = pair.linear
    # κ enters with every speed of the plane: the mean speed, the tilt and what moves the node by
    # the radius. The rate by inclination is a ratio of two such, and stays.
    linear = LinearPair(
        turn * of.speed,
        of.sine,
        of.lag,
        of.lag_rate,
        of.lag_by_departure,
        of.climb,
        turn * of.tilt,
        turn * of.by_radius,
        of.by_inclination,
        of.radius_i,
        of.radius_j,
        of.least_climb,
        of.most_climb,
        of.eccentricity_i,
        of.eccentricity_j,
        of.perigee_lag,
        of.perigee_lag_rate,
    )
    return DriftPair(linear, *pair[1:])


@inlined
def chord(delta_v, speed):
    """ΔV of a large change from the sum of many small ones, both arcs taken as equal [m/s].

    Edelbaum's formula, sqrt(V_0² − 2 V_0 V_1 cos(κ θ) + V_1²), has the chord of the angle κ θ in
    place of its arc: of either arc here 2 V sin(ΔV / 4 V). Two equal ones cost most.

    Parameters
    ----------
    delta_v, speed : float
        [m/s].
    """
    angle = min(0.25 * delta_v / speed, 0.5 * math.pi)
    if angle < FLAT:
        return delta_v * (1.0 - angle * angle * (1.0 / 6.0))
    return 4.0 * speed * math.sin(angle)


@inlined
def arc_times(thrust, shares, first, second):
    """Durations of arcs of given ΔV [m/s], with thrust on for shares of the time."""
    exhaust = thrust.exhaust
    flow = exhaust / thrust.acceleration
    rest = math.exp(-first / exhaust)
    return ArcTimes(
        flow * (1.0 - rest) / shares[0],
        flow * rest * (1.0 - math.exp(-second / exhaust)) / shares[1],
    )


@inlined
def _mean_cube(one, other):
    """Mean of the third power of a speed that changes uniformly."""
    return 0.25 * (one + other) * (one * one + other * other)


@inlined
def _mean_seventh(one, other):
    """Mean of the seventh power of a speed that changes uniformly."""
    a, b = one * one, other * other
    return 0.125 * (one + other) * (a + b) * (a * a + b * b)


@inlined
def longitude_gained(pair, coasting, times, speed):
    """Longitude gained on a leg, and its derivative by the speed of the drift orbit.

    Parameters
    ----------
    pair : DriftPair
    coasting : float
        Time on the drift orbit [s].
    times : ArcTimes
    speed : float
        Circular speed on the drift orbit [m/s].

    Returns
    -------
    gained, slope : float
        [rad], [rad s/m].
    """
    start, end = pair.speed_i, pair.speed_i - pair.climb
    per_mu = 1.0 / MU_M3_S2
    pulled = 1.5 * pair.oblateness * (3.0 * pair.cosine * pair.cosine - 1.0) * per_mu * per_mu
    square = speed * speed
    cube, fourth = square * speed, square * square
    gained = coasting * cube * (1.0 + pulled * fourth)
    gained += times.first * (_mean_cube(start, speed) + pulled * _mean_seventh(start, speed))
    gained += times.second * (_mean_cube(speed, end) + pulled * _mean_seventh(speed, end))
    # Of the arcs, to first order in how far the speeds are apart.
    slope = (coasting + 0.5 * (times.first + times.second)) * square * (3.0 + 7.0 * pulled * fourth)
    return gained * per_mu, slope * per_mu


@inlined
def node_series(pair, task, coasting, times, speed):
    """Node difference left by a low-thrust leg, by the first arc's change of inclination.

    On a ramp speed and inclination change together: Gauss's rule with three points.

    Parameters
    ----------
    pair : DriftPair
    task : Task
    coasting : float
        Time on the drift orbit [s].
    times : ArcTimes
    speed : float
        Circular speed there [m/s].
    """
    start, end = pair.speed_i, pair.speed_i - pair.climb
    pull = -1.5 * pair.oblateness / (MU_M3_S2 * MU_M3_S2 * MU_M3_S2)
    whole = pair.inclination_j - pair.inclination_i
    d = pull * coasting * speed**7
    c, s = pair.cosine_i, pair.sine_i
    c0, s1, c2, s3, c4, s5 = d * c, d * s, d * c, d * s, d * c, d * s
    for at, weight in ((EARLY, OUTER), (0.5, INNER), (1.0 - EARLY, OUTER)):
        rate = weight * pull * times.first * (start + at * (speed - start)) ** 7
        # From the drift orbit's inclination on, which is i_i and the change, to i_j.
        back = weight * pull * times.second * (speed + at * (end - speed)) ** 7
        more = at * whole
        square = more * more
        even = 1.0 - square * (0.5 - square * (1.0 / 24.0))
        odd = more * (1.0 - square * (1.0 / 6.0 - square * (1.0 / 120.0)))
        cosine, sine = back * (c * even - s * odd), back * (s * even + c * odd)
        cosine_1, sine_1 = rate * c, rate * s
        left = 1.0 - at
        c0 += cosine_1 + cosine
        s1 += at * sine_1 + left * sine
        c2 += at * at * cosine_1 + left * left * cosine
        s3 += at**3 * sine_1 + left**3 * sine
        c4 += at**4 * cosine_1 + left**4 * cosine
        s5 += at**5 * sine_1 + left**5 * sine
    c0 += pair.node_rate_j * pair.approach - task.lag - pair.node_rate_i * task.span
    return NodeSeries(c0, -s1, -0.5 * c2, s3 / 6.0, c4 / 24.0, -s5 / 120.0)


@inlined
def _mean_slope(one, other):
    """Derivative of :func:`_mean_seventh` by the first speed."""
    total, power = 0.0, 1.0
    for number in range(7):
        total = total * one + (7.0 - number) * power
        power *= other
    return 0.125 * total


@inlined
def beside_ramps(pair, times, climb, tilt):
    """Extra node drift on both arcs beyond that at the mean of the rates at their ends.

    Parameters
    ----------
    pair : DriftPair
    times : ArcTimes
    climb, tilt : float
        y and z, as the pair counts them [m/s].

    Returns
    -------
    more, by_climb, by_tilt : float
        [rad], and its derivatives by y and z [rad s/m].
    """
    start, end, per_speed = pair.speed_i, pair.speed_i - pair.climb, 1.0 / pair.linear.speed
    speed = start - climb
    pull = -1.5 * pair.oblateness / (MU_M3_S2 * MU_M3_S2 * MU_M3_S2)
    start_7, end_7, sixth = start**7, end**7, speed**6
    drifting_7 = sixth * speed
    tilted, left = tilt * per_speed, (pair.linear.tilt - tilt) * per_speed
    c, s = pair.cosine_i, pair.sine_i
    cosine = c * (1.0 - 0.5 * tilted * tilted) - s * tilted
    sine = s + c * tilted
    curved, twelfth = pair.cosine, 1.0 / 12.0
    # Out: means less the trapezoid, of the product of both.
    # Of two linear functions the mean product is less than the trapezoid by a sixth of the product
    # of their rises, and the mean of a cosine is more by a twelfth of its curvature.
    mean, slope = _mean_seventh(speed, start), _mean_slope(speed, start)
    level, lower = 0.5 * (c + cosine), cosine - c
    off = mean - 0.5 * (start_7 + drifting_7)
    out = off * level + mean * curved * tilted * tilted * twelfth
    out -= (drifting_7 - start_7) * lower * 2.0 * twelfth
    out_v = (slope - 3.5 * sixth) * level - 14.0 * twelfth * sixth * lower
    out_z = (2.0 * twelfth * (drifting_7 - start_7) - 0.5 * off) * sine
    out_z += 2.0 * twelfth * mean * curved * tilted
    # Back.
    mean, slope = _mean_seventh(speed, end), _mean_slope(speed, end)
    level, lower = 0.5 * (cosine + pair.cosine_j), pair.cosine_j - cosine
    off = mean - 0.5 * (end_7 + drifting_7)
    back = off * level + mean * curved * left * left * twelfth
    back -= (end_7 - drifting_7) * lower * 2.0 * twelfth
    back_v = (slope - 3.5 * sixth) * level + 14.0 * twelfth * sixth * lower
    back_z = -(2.0 * twelfth * (end_7 - drifting_7) + 0.5 * off) * sine
    back_z -= 2.0 * twelfth * mean * curved * left
    return (
        pull * (times.first * out + times.second * back),
        -pull * (times.first * out_v + times.second * back_v),
        pull * (times.first * out_z + times.second * back_z) * per_speed,
    )
