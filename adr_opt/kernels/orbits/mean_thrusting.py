"""Averaged flight with low thrust: predicts :mod:`.thrusting` in a thousandth of its time.

Mean elements near a circle, (a, e_x, e_y, i, Ω, λ), with the eccentricity vector and the mean
argument of latitude λ counted from the node, move by the secular rates of J2 and by the mean of
what thrust does (:mod:`.primer`) over the places at which it is on. A cell between two of
the places that are summed over counts in part, so that the prediction is smooth.
"""

import math

import numpy as np

from ...common.constants import EARTH_RADIUS_M, MU_M3_S2, OBLATENESS_M2
from ..core.compile import inlined, kernel
from .primer import pushed
from .sunlight import sun_direction
from .thrusting import CLEAR_M

PLACES = 90
"""Number of places on a revolution that are summed over."""

CELL_RAD = 2.0 * math.pi / PLACES

STEP_S = 21600.0
"""Longest step with thrust [s]."""


@inlined
def _part(excess, slope):
    """Part of a cell in which a function is positive, by its value and slope in the middle."""
    half = 0.5 * CELL_RAD * abs(slope)
    if excess >= half:
        return 1.0
    return 0.0 if excess <= -half else 0.5 + 0.5 * excess / half


@kernel
def _rates(mean, acceleration, law, least, sun, rates):
    """Rates of mean elements, written to ``rates``; the share of a revolution with thrust."""
    a, ex, ey, inclination, node = mean[0], mean[1], mean[2], mean[3], mean[4]
    n = math.sqrt(MU_M3_S2 / a**3)
    square = 1.0 - ex * ex - ey * ey
    c, s = math.cos(inclination), math.sin(inclination)
    strength = 1.5 * OBLATENESS_M2 / (a * square) ** 2 * n
    perigee = 0.5 * strength * (5.0 * c * c - 1.0)
    anomaly = 0.5 * strength * math.sqrt(square) * (3.0 * c * c - 1.0)
    rates[0] = rates[3] = 0.0
    rates[1], rates[2] = -ey * perigee, ex * perigee
    rates[4], rates[5] = -strength * c, n + perigee + anomaly
    if not acceleration > 0.0:
        return 0.0
    share = da = dx = dy = di = dn = dr = 0.0
    co, so = math.cos(node), math.sin(node)
    along = sun[0] * co + sun[1] * so
    ahead = (sun[1] * co - sun[0] * so) * c + sun[2] * s
    # Gauss's equations to first order in e, summed over equidistant places. A cell in which thrust
    # is switched counts in part, so that rates are smooth functions of the law.
    for place in range(PLACES):
        u = place * (2.0 * math.pi / PLACES)
        cu, su = math.cos(u), math.sin(u)
        p_r, p_t, p_n = pushed(law, u)
        size = math.sqrt(p_r * p_r + p_t * p_t + p_n * p_n)
        slope = p_r * (law[0] * cu + law[1] * su) + 2.0 * p_t * (law[1] * cu - law[0] * su)
        slope += p_n * (law[4] * cu - law[3] * su)
        weight = _part(size - least, slope / size)
        towards = along * cu + ahead * su
        if towards < 0.0:
            r = a * (1.0 - ex * cu - ey * su)
            aside = math.sqrt(max(1.0 - towards * towards, 1e-9))
            slope = r * towards / aside * (along * su - ahead * cu)
            weight *= _part(r * aside - EARTH_RADIUS_M - CLEAR_M, slope)
        if weight <= 0.0:
            continue
        share += weight
        by = weight / size
        r, t, across = by * p_r, by * p_t, by * p_n
        da += t
        dx += 2.0 * t * cu + r * su
        dy += 2.0 * t * su - r * cu
        di += across * cu
        dn += across * su
        dr += r
    pushes = acceleration / (n * a * PLACES)
    rates[0] += 2.0 * a * pushes * da
    rates[1] += pushes * dx
    rates[2] += pushes * dy
    rates[3] += pushes * di
    turned = pushes * dn / s
    rates[4] += turned
    rates[5] -= 2.0 * pushes * dr + c * turned
    return share / PLACES


@kernel
def _coast(mean, duration, sun, rates):
    """Move mean elements without thrust, in place."""
    _rates(mean, 0.0, np.zeros(5), 0.0, sun, rates)
    turned = rates[1] / -mean[2] * duration if mean[2] != 0.0 else 0.0
    c, s = math.cos(turned), math.sin(turned)
    mean[1], mean[2] = c * mean[1] - s * mean[2], s * mean[1] + c * mean[2]
    mean[4] += rates[4] * duration
    mean[5] += rates[5] * duration


@kernel
def fly(start, begin, until, push, arcs):
    """Predict a flight with arcs of thrust.

    Parameters
    ----------
    start : (6,) float64
        a [m], e_x, e_y, i, Ω, λ [rad], without revolutions.
    begin, until : float
        Times of both ends [s].
    push : Push
    arcs : ThrustArcs

    Returns
    -------
    mean : (6,) float64
        At the end, with revolutions.
    ends : (arcs,) float64
        Ends of arcs [s].
    left : float
        Time of thrust that has not been flown by the end [s].
    """
    mean, rates, half = start.copy(), np.empty(6), np.empty(6)
    mass, flow, now, missing = push.mass, push.force / push.exhaust, begin, 0.0
    ends = np.empty(arcs.starts.size)
    sun = sun_direction(push.since_j2000 + now)
    for arc in range(arcs.starts.size):
        if now < arcs.starts[arc]:
            _coast(mean, arcs.starts[arc] - now, sun, rates)
            now = arcs.starts[arc]
        latest = arcs.starts[arc + 1] if arc + 1 < arcs.starts.size else until
        left, law, least = arcs.spans[arc], arcs.laws[arc], arcs.least[arc]
        while left > 1e-6 and now < latest - 1e-6:
            step = min(STEP_S, latest - now)
            sun = sun_direction(push.since_j2000 + now)
            share = _rates(mean, push.force / mass, law, least, sun, rates)
            if share * step > left:
                step = left / share
            # The midpoint rule: rates change with the orbit over days, and a step is hours.
            for axis in range(6):
                half[axis] = mean[axis] + 0.5 * step * rates[axis]
            sun = sun_direction(push.since_j2000 + now + 0.5 * step)
            middle = mass - 0.5 * step * share * flow
            share = _rates(half, push.force / middle, law, least, sun, rates)
            if share * step > left:
                step = left / share
            for axis in range(6):
                mean[axis] += step * rates[axis]
            now += step
            left -= share * step
            mass -= share * step * flow
        ends[arc] = now
        missing += max(left, 0.0)
    if now < until:
        _coast(mean, until - now, sun, rates)
    return mean, ends, missing


@kernel
def share_on(mean, law, least, since_j2000):
    """Share of a revolution with thrust, at mean elements and a time from J2000 [s]."""
    return _rates(mean, 1.0, law, least, sun_direction(since_j2000), np.empty(6))
