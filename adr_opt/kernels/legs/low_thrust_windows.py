"""Windows of thrust of a low-thrust leg, and the Earth's shadow in them.

Of a thrust that is on on a part of the revolution, with the share σ of it and the mean c of
|cos(u − u*)| over that part times σ, a change of the plane about u* costs κ = σ / c. Windows are ±η
about u* and its opposite; thrust is off in the shadow, too.

κ and σ are those of one moment of each arc, a sixteenth of the leg from its end, and of the u* of
the closed solution of first order (:mod:`.drift_linear`): so they depend on nothing that the thrust
decides. κ of a leg is the mean of its arcs, by what that solution turns on each.

Thrust along the orbit in windows of which a part lies in the shadow makes the orbit eccentric. An
arc that changes the speed by y adds 2 y c / V to the eccentricity vector, c being the mean of
(cos u, sin u) over the places at which thrust is on. What is left of the vector w that both arcs
have to make up for, in m/s, takes thrust in other directions besides. With the mean of the square
of the primer vector in place of that of its length (:mod:`..orbits.primer`), its cost and that of
the rest add up as

    ΔV² = f² + w · S⁻¹ w,    S = mean of 5/2 + 3/2 Q(u) − 4 c c',    Q(u) = (cos 2u,  sin 2u;
                                                                             sin 2u, −cos 2u),

f being the ΔV without it, and S over all places in sunlight. With w linear in y, the second term is
a parabola (docs/model.md section 11.7).
"""

import math
from typing import NamedTuple

from ...common.constants import TURN_RAD
from ..core.compile import inlined, kernel
from ..orbits import ephemeris, sunlight
from . import drift_linear, drift_pair
from .drift_free import Bowl, first_guess, with_bowl
from .drift_pair import DriftPair

STEEP = 1e-9
"""Least steepness of a parabola: below it the arcs cancel, or there is no shadow."""


class Metric(NamedTuple):
    """A symmetric matrix of two rows."""

    xx: float
    xy: float
    yy: float


class Shapes(NamedTuple):
    """Eccentricities of a leg, in the frame of the node, as they are turned until its arrival.

    Attributes
    ----------
    left_x, left_y : float
        What the eccentricity vector has to change by on arrival if there is no thrust [m/s].
    first, second : (float, float)
        Cosine and sine of the place of thrust of each arc, as turned.
    room : Metric
        S.
    """

    left_x: float
    left_y: float
    first: tuple[float, float]
    second: tuple[float, float]
    room: Metric


@inlined
def room(shadow, turn, share):
    """S of sunlit places on an orbit whose perigee turns by an angle, multiplied by a share."""
    middle = 2.0 * (shadow.middle + turn)
    lit = 1.0 / (math.pi - shadow.half)
    c = math.sin(shadow.half) * lit
    beyond = 0.75 * math.sin(2.0 * shadow.half) * lit + 2.0 * c * c
    level, aside = share * (2.5 - 2.0 * c * c), share * beyond
    along, across = aside * math.cos(middle), aside * math.sin(middle)
    return Metric(level - along, -across, level + along)


@inlined
def bowl(shapes, one, other, climb):
    """The parabola in the first arc's change of speed.

    Parameters
    ----------
    shapes : Shapes
    one, other : Lit
        Windows of both arcs.
    climb : float
        Change of speed by both arcs [m/s].
    """
    c, s = shapes.first
    x1, y1 = one.toward * c - one.aside * s, one.toward * s + one.aside * c
    c, s = shapes.second
    x2, y2 = other.toward * c - other.aside * s, other.toward * s + other.aside * c
    x, y = 2.0 * (x2 - x1), 2.0 * (y2 - y1)
    x0, y0 = shapes.left_x - 2.0 * x2 * climb, shapes.left_y - 2.0 * y2 * climb
    xx, xy, yy = shapes.room
    per = 1.0 / (xx * yy - xy * xy)
    steepness = per * (yy * x * x - 2.0 * xy * x * y + xx * y * y)
    slope = per * (yy * x * x0 - xy * (x * y0 + x0 * y) + xx * y * y0)
    whole = per * (yy * x0 * x0 - 2.0 * xy * x0 * y0 + xx * y0 * y0)
    if steepness < STEEP:
        return Bowl(0.0, 0.0, whole)
    bottom = -slope / steepness
    return Bowl(steepness, bottom, max(whole + slope * bottom, 0.0))


WINDOWS_RAD = (math.pi / 6.0, math.pi / 3.0, math.pi / 2.0)
"""Half-widths η of the windows of thrust."""

WITHIN = 1.0 / 16.0
"""Part of a leg from either end at which shadows are looked at."""

SIMPSON = 16
"""Number of intervals of a mean over a window."""

DARKLESS = sunlight.Shadow(0.0, 0.0)
"""No shadow."""


class LowThrustPair(NamedTuple):
    """Data of a low-thrust leg i → j that do not depend on its times.

    Attributes
    ----------
    drift : DriftPair
    node_i, node_j : float
        At t = 0, of the chaser that has left and stays, and of the target [rad].
    node_by_departure : float
        How much that of the chaser is more for every second that the departure is later [rad/s].
    since_j2000 : float
        The epoch, from J2000 [s]; NaN where thrust is on in the shadow.
    perigee_i, perigee_rate_i : float
        Of the chaser that has left and stays, at t = 0 [rad], and its rate [rad/s].
    """

    drift: DriftPair
    node_i: float
    node_j: float
    node_by_departure: float
    since_j2000: float
    perigee_i: float
    perigee_rate_i: float


@kernel
def prepare(orbit_i, orbit_j, rule, since_j2000, time):
    """Compute the data of low-thrust legs i → j that do not depend on their times.

    Parameters
    ----------
    orbit_i, orbit_j, rule, time
        As :func:`.drift_pair.prepare` takes them.
    since_j2000 : float
        As in :class:`LowThrustPair` [s].
    """
    node_i, rate_i = ephemeris.node_tangent(orbit_i, time)
    node_j, _ = ephemeris.node_tangent(orbit_j, time)
    perigee_i, perigee_rate_i = ephemeris.perigee_tangent(orbit_i, time)
    return LowThrustPair(
        drift_pair.within(
            orbit_i, orbit_j, rule, (rule.min_radius, rule.max_radius), rule.free, time
        ),
        node_i,
        node_j,
        rate_i - ephemeris.coasting_node_rate_at(orbit_i, time),
        since_j2000,
        perigee_i,
        perigee_rate_i,
    )


class Lit(NamedTuple):
    """Means over the thrusting part of a revolution.

    Attributes
    ----------
    turn, share : float
        κ and σ.
    toward, aside : float
        Of the cosine and the sine of u − u*.
    """

    turn: float
    share: float
    toward: float
    aside: float


@inlined
def lit(window, middle, shadow):
    """Means over windows ±η about a place and its opposite, without the shadow.

    Parameters
    ----------
    window : float
        η [rad].
    middle : float
        u* [rad].
    shadow : Shadow
    """
    share, mean, toward, aside = 4.0 * window, 4.0 * math.sin(window), 0.0, 0.0
    if shadow.half > 0.0:
        away = (shadow.middle - middle) % TURN_RAD
        side = 1.0
        for turns in range(3):
            low = max(away - shadow.half - turns * math.pi, -window)
            high = min(away + shadow.half - turns * math.pi, window)
            if high > low:
                less = math.sin(high) - math.sin(low)
                share -= high - low
                mean -= less
                toward -= side * less
                aside += side * (math.cos(high) - math.cos(low))
            side = -side
    per_share = 1.0 / share
    return Lit(share / mean, share / TURN_RAD, toward * per_share, aside * per_share)


class Steering(NamedTuple):
    """Places of thrust on both arcs of a leg.

    Attributes
    ----------
    turn : float
        κ: ΔV of a change of plane over speed and angle.
    first_share, second_share : float
        Share of a revolution in which thrust is on.
    bowl : Bowl
        What eccentricities ask for.
    power : float
        p of the norm in which that is added to changes of size.
    """

    turn: float
    first_share: float
    second_share: float
    bowl: Bowl
    power: float


class Places(NamedTuple):
    """Where thrust is worth most on both arcs of a leg, and the shadows there.

    Attributes
    ----------
    first, second : float
        u* [rad].
    share : float
        The first arc's part of all changes of plane.
    first_shadow, second_shadow : Shadow
    climb : float
        What both change of the speed [m/s].
    shapes : Shapes
    free : bool
        Whether eccentricities change with the size.
    """

    first: float
    second: float
    share: float
    first_shadow: sunlight.Shadow
    second_shadow: sunlight.Shadow
    climb: float
    shapes: Shapes
    free: bool


@inlined
def places(pair, task, departure, arrival):
    """Places of thrust of the leg between two times, to first order.

    Parameters
    ----------
    pair : LowThrustPair
    task : Task
    departure, arrival : float
        [s].
    """
    drift, linear = pair.drift, pair.drift.linear
    climb, tilt = first_guess(drift, task)
    node = linear.speed * linear.sine * task.lag
    along, _ = drift_linear.split_at(linear, task.span, node, climb)
    rest = node - along
    rest += task.span * (linear.by_radius * climb + linear.by_inclination * tilt)
    left = linear.tilt - tilt
    one, other = math.sqrt(along * along + tilt * tilt), math.sqrt(rest * rest + left * left)
    share = one / (one + other) if one + other > 0.0 else 0.5
    first, second = math.atan2(along, tilt), math.atan2(rest, left)
    early, late = departure + WITHIN * task.span, arrival - WITHIN * task.span
    shadow_i, shadow_j = DARKLESS, DARKLESS
    if not math.isnan(pair.since_j2000):
        node_i = pair.node_i + pair.node_by_departure * departure + drift.node_rate_i * early
        node_j = pair.node_j + drift.node_rate_j * late
        shadow_i = sunlight.shadow(
            linear.radius_i, drift.inclination_i, node_i, pair.since_j2000 + early
        )
        shadow_j = sunlight.shadow(
            linear.radius_j, drift.inclination_j, node_j, pair.since_j2000 + late
        )
    return Places(
        first,
        second,
        share,
        shadow_i,
        shadow_j,
        drift.climb,
        _shapes(pair, (first, second, share), (shadow_i, shadow_j), task.span, arrival),
        drift.free,
    )


@inlined
def _shapes(pair, thrust, dark, span, arrival):
    """Eccentricities of the leg that arrives at some time.

    Parameters
    ----------
    pair : LowThrustPair
    thrust : (float, float, float)
        Places of both arcs [rad], and the first one's part.
    dark : (Shadow, Shadow)
    span, arrival : float
        [s].
    """
    first, second, share = thrust
    linear = pair.drift.linear
    perigee_i = pair.perigee_i + pair.perigee_rate_i * arrival
    perigee_j = perigee_i + linear.perigee_lag + linear.perigee_lag_rate * arrival
    # The chaser's perigee turns at the mean of both rates on the way.
    rate_j = pair.perigee_rate_i + linear.perigee_lag_rate
    lag = 0.5 * linear.perigee_lag_rate
    x = y = 0.0
    if linear.eccentricity_i > 0.0 or linear.eccentricity_j > 0.0:
        drifted = perigee_i + lag * span
        x = linear.eccentricity_j * math.cos(perigee_j)
        x -= linear.eccentricity_i * math.cos(drifted)
        y = linear.eccentricity_j * math.sin(perigee_j)
        y -= linear.eccentricity_i * math.sin(drifted)
    turn_i = (1.0 - WITHIN) * span * (pair.perigee_rate_i + lag)
    turn_j = WITHIN * span * rate_j
    one = room(dark[0], turn_i, share)
    other = room(dark[1], turn_j, 1.0 - share)
    return Shapes(
        linear.speed * x,
        linear.speed * y,
        (math.cos(first + turn_i), math.sin(first + turn_i)),
        (math.cos(second + turn_j), math.sin(second + turn_j)),
        Metric(one.xx + other.xx, one.xy + other.xy, one.yy + other.yy),
    )


@inlined
def steering(at, window):
    """Thrust about places, in windows ±η [rad]."""
    one = lit(window, at.first, at.first_shadow)
    other = lit(window, at.second, at.second_shadow)
    asked, power = bowl(at.shapes, one, other, at.climb), 2.0
    if at.free:
        eased, power = 2.5 / mean_primer(window) ** 2, math.pi / window
        asked = Bowl(eased * asked.steepness, asked.bottom, eased * asked.least)
    return Steering(
        at.share * one.turn + (1.0 - at.share) * other.turn, one.share, other.share, asked, power
    )


@inlined
def mean_primer(window):
    """Mean length of the primer of a change of eccentricity, 2 at most, in windows about its place.

    By Simpson's rule: right to seven digits.
    """
    total, sign = 2.0 + math.sqrt(1.0 + 3.0 * math.cos(window) ** 2), 4.0
    for number in range(1, SIMPSON):
        total += sign * math.sqrt(1.0 + 3.0 * math.cos(window * number / SIMPSON) ** 2)
        sign = 6.0 - sign
    return total / (3.0 * SIMPSON)


@inlined
def easing(steering):
    """Least ratio of a norm of the windows' power to the root of the sum of squares."""
    return 2.0 ** (1.0 / steering.power - 0.5)


@inlined
def shaped(pair, steering, form, climb):
    """ΔV including eccentricities, from the ΔV without them and y [m/s] (model, 11.8)."""
    if steering.power == 2.0:
        return with_bowl(form, steering.bowl, climb)
    size, away = abs(climb) + abs(pair.climb - climb), climb - steering.bowl.bottom
    asked = math.sqrt(steering.bowl.steepness * away * away + steering.bowl.least)
    most = max(size, asked)
    if most == 0.0:
        return form
    both = (size / most) ** steering.power + (asked / most) ** steering.power
    both = most * both ** (1.0 / steering.power)
    return math.sqrt(max(form * form - size * size, 0.0) + both * both)
