"""Drift legs in closed form: exact rates, whole laps, and the least sum of both burns.

Hours become days to months. The chaser leaves for a drift orbit whose node moves faster or slower,
waits there, and closes what is left on arrival. With y and z what the first burn changes of the
size and of the inclination, v_y and v_z all there is to change, and X what is then left of the node
on arrival, all in m/s, a leg costs (sizes are differences of circular speeds, V_i − V(r), which a
Hohmann transfer costs to second order in the change of radius)

    ΔV = min over (y, z) of hypot( X(y, z), N₁ + N₂ ),
    N₁ = hypot(y, z, E),    N₂ = hypot(v_y − y, v_z − z, E),

E being what the eccentricity vectors ask for at either end. The node is split between both burns in
proportion to N₁ and N₂, which makes the sum of the two burns least. X counts the rates of the node
*on* the drift orbit and on the half ellipses beside it, Ω̇(a, i), instead of changes in proportion.

The chaser has to meet the target, too, so the drift orbit makes a whole number of laps more or less
than the target. In longitudes λ = u + Ω cos ī, with half ellipses of t_1, t_2 and t_3 (out, back to
the co-elliptic orbit, and to the stand-off), T_c = T − t_1 − t_2 − t_3 − approach of them all,

    λ_i(t_s) + Σ (π + Ω̇ cos ī t_h) + λ̇(r) T_c = λ_j(t_f − approach) − lead − 2πk,

which leaves radii r_k a comb apart. The leg takes the cheaper of the two teeth about the optimum of
free phase. Teeth are half a lap away at most, which is 90 m/s for a leg of a day and 1 m/s for one
of three months.
"""

import math
from typing import NamedTuple

import numpy as np

from . import drift_linear, orbits
from .compile import inlined, kernel
from .constants import MU_M3_S2
from .drift_linear import LinearPair

MARGIN_M, MARGIN_SHARE = 60e3, 0.3
"""See :func:`margin`."""

TURN = 2.0 * math.pi

SMOOTH_M_S = 0.05
"""The search for the optimum of free phase rounds the tips of N₁ and N₂ off by it [m/s]."""

MOST_STEPS = 40
"""Steps of a Newton iteration."""

CLOSE_M, SHORT_S = 100.0, 86400.0
CLOSE_M_S, NEAR_M_S, NEAR_SPAN_S = 1e-3, 0.1, 30.0 * 86400.0
TIP_ROOM_M_S = 1.0
"""Steps after which a radius, an inclination, and the optimum of free phase are found; what is left
to go is of the fourth order in the first, and of the second in the others. The last is finer for
longer legs, whose teeth are; and about a tip of N₁ or N₂ there is so much room that steps stay
short without a reason."""

TIP_M_S = 1e-6
"""N₁ and N₂ are not less where they are divided by [m/s]."""


class DriftPair(NamedTuple):
    """What a drift leg i → j needs and what does not depend on its times.

    Attributes
    ----------
    linear : LinearPair
        The same to first order, which holds radii, speed and what is to change.
    speed_i, climb, least_climb, most_climb : float
        Circular speed at the origin; v_y, and between which y keeps the drift orbit within the
        altitude limits [m/s].
    inclination_i, inclination_j : float
        [rad].
    cosine, cosine_i, sine_i, cosine_j : float
        cos ī, cos i_i, sin i_i and cos i_j.
    node_rate_i, node_rate_j : float
        Of the chaser that has left and stays, and of the target [rad/s].
    latitude, latitude_rate_i, latitude_rate_j : float
        u_j − u_i at t = 0 [rad], and the rates of both [rad/s].
    lead : float
        How far the stand-off is behind the target [rad].
    approach : float
        Time from the stand-off to the target [s].
    fraction : float
        f: share of r_j − r that is closed on the way to the co-elliptic orbit.
    oblateness : float
        J2 R² [m²].
    """

    linear: LinearPair
    speed_i: float
    climb: float
    least_climb: float
    most_climb: float
    inclination_i: float
    inclination_j: float
    cosine: float
    cosine_i: float
    sine_i: float
    cosine_j: float
    node_rate_i: float
    node_rate_j: float
    latitude: float
    latitude_rate_i: float
    latitude_rate_j: float
    lead: float
    approach: float
    fraction: float
    oblateness: float


class Task(NamedTuple):
    """A drift leg between two times, as it is to be split.

    Attributes
    ----------
    span : float
        T [s].
    lag : float
        What is left of the node on arrival if nothing is done before, by the turn taken [rad].
    ahead : float
        λ_j(t_f − approach) − lead − λ_i(t_s) [rad].
    shape : float
        E [m/s].
    """

    span: float
    lag: float
    ahead: float
    shape: float


class Split(NamedTuple):
    """How a drift leg is split: ΔV, and what the first burn changes of size, inclination and node.

    All in m/s; infinite ΔV if no tooth lies between the altitude limits.
    """

    delta_v: float
    climb: float
    tilt: float
    along: float


class Coast(NamedTuple):
    """The arcs of a drift leg whose drift orbit has a radius.

    Attributes
    ----------
    drift : float
        Time on the drift orbit [s].
    node_out, node_drift, node_back, node_end : float
        How far the node of an equatorial orbit moves on each arc, which cos i is a factor of [rad].
    phase, phase_slope : float
        Longitude gained until the stand-off [rad], and its derivative by the radius [rad/m].
    """

    drift: float
    node_out: float
    node_drift: float
    node_back: float
    node_end: float
    phase: float
    phase_slope: float


@kernel
def prepare(orbit_i, orbit_j, rule):
    """Everything about drift legs i → j that does not depend on their times.

    Parameters
    ----------
    orbit_i, orbit_j : (columns,) float64
        Rows of :data:`adr_opt.kernels.orbits.ORBIT_COLUMNS`, the first one of a body as it is left.
    rule : TransferRule

    Returns
    -------
    DriftPair
    """
    linear = drift_linear.prepare(
        orbit_i, orbit_j, rule.min_radius, rule.max_radius, rule.oblateness
    )
    inclination_i, inclination_j = orbit_i[orbits.INCLINATION], orbit_j[orbits.INCLINATION]
    cosine = math.cos(0.5 * (inclination_i + inclination_j))
    speed_i = math.sqrt(MU_M3_S2 / orbit_i[orbits.RADIUS])
    return DriftPair(
        linear,
        speed_i,
        speed_i - math.sqrt(MU_M3_S2 / orbit_j[orbits.RADIUS]),
        speed_i - math.sqrt(MU_M3_S2 / rule.min_radius),
        speed_i - math.sqrt(MU_M3_S2 / rule.max_radius),
        inclination_i,
        inclination_j,
        cosine,
        math.cos(inclination_i),
        math.sin(inclination_i),
        math.cos(inclination_j),
        orbits.coasting_node_rate(orbit_i),
        orbit_j[orbits.RAAN_RATE],
        orbit_j[orbits.ARGUMENT_OF_LATITUDE] - orbit_i[orbits.ARGUMENT_OF_LATITUDE],
        orbit_i[orbits.LATITUDE_RATE],
        orbit_j[orbits.LATITUDE_RATE],
        rule.standoff / orbit_j[orbits.RADIUS],
        rule.approach_revolutions * orbits.revolution(orbit_j),
        rule.first_leg_fraction,
        rule.oblateness,
    )


@inlined
def task_of(pair, departure, arrival, shape):
    """The leg between two times whose eccentricity vectors ask for E [m/s].

    The node is turned the nearer way, as it is if half of size and inclination is changed at either
    end.
    """
    linear, span = pair.linear, arrival - departure
    lag = linear.lag + linear.lag_rate * arrival + linear.lag_by_departure * departure
    worth = linear.speed * linear.sine
    if worth > 0.0:
        half = linear.by_radius * linear.climb + linear.by_inclination * linear.tilt
        left = lag + 0.5 * span * half / worth
        lag -= TURN * math.ceil((left - math.pi) / TURN)
    met = arrival - pair.approach
    ahead = pair.latitude + pair.latitude_rate_j * met - pair.latitude_rate_i * departure
    ahead += pair.cosine * (lag + pair.node_rate_i * span - pair.node_rate_j * pair.approach)
    return Task(span, lag, ahead - pair.lead, shape)


@kernel
def task(pair, departure, arrival):
    """The leg between two times [s]."""
    return task_of(pair, departure, arrival, drift_linear.shape_left(pair.linear, arrival))


@inlined
def first_guess(pair, task):
    """The optimum of free phase to first order: b_y and b_z [m/s]."""
    linear = pair.linear
    node = linear.speed * linear.sine * task.lag
    climb = drift_linear.climb_of(linear, task.span, node)
    _, tilt = drift_linear.split_at(linear, task.span, node, climb)
    return climb, tilt


@inlined
def radius_of(pair, climb):
    """Radius of the drift orbit that y leads to [m]."""
    speed = pair.speed_i - climb
    return MU_M3_S2 / (speed * speed)


@inlined
def climb_to(pair, radius):
    """The y that leads to a radius [m/s]."""
    return pair.speed_i - math.sqrt(MU_M3_S2 / radius)


@inlined
def _rates(pair, axis):
    """Mean motion with a semi-major axis [rad/s], and 1.5 J2 (R/a)²."""
    inverse = 1.0 / axis
    return math.sqrt(MU_M3_S2 * inverse) * inverse, 1.5 * pair.oblateness * inverse * inverse


@inlined
def _half(pair, axis):
    """Time of half a turn with a semi-major axis [s], and the node's way times −1 / cos i [rad]."""
    motion, pull = _rates(pair, axis)
    time = math.pi / (motion * (1.0 + pull * (4.0 * pair.cosine * pair.cosine - 1.0)))
    return time, pull * motion * time


@inlined
def coast(pair, span, radius):
    """The arcs of a leg whose drift orbit has a radius, with the inclination ī in the phase."""
    rj, fraction = pair.linear.radius_j, pair.fraction
    co_elliptic = radius + fraction * (rj - radius)
    axis_out, axis_back = 0.5 * (pair.linear.radius_i + radius), 0.5 * (radius + co_elliptic)
    axis_end = 0.5 * (co_elliptic + rj)
    out, node_out = _half(pair, axis_out)
    back, node_back = _half(pair, axis_back)
    end, node_end = _half(pair, axis_end)
    drifting = span - pair.approach - out - back - end
    motion, pull = _rates(pair, radius)
    square = pair.cosine * pair.cosine
    pulled = pull * (3.0 * square - 1.0)
    rate = motion * (1.0 + pulled)
    # An arc that takes longer leaves less time to drift.
    slope = (1.0 - 0.5 * fraction) * back / axis_back + 0.5 * (1.0 - fraction) * end / axis_end
    slope = rate * (slope + 0.5 * out / axis_out)
    slope += motion * (1.0 + pulled * (7.0 / 3.0)) * drifting / radius
    phase = 3.0 * math.pi - square * (node_out + node_back + node_end) + rate * drifting
    return Coast(
        drifting, -node_out, -pull * motion * drifting, -node_back, -node_end, phase, -1.5 * slope
    )


@inlined
def _tilt_at(pair, task, arcs, radius, tilt):
    """The best z with a given drift orbit, near one that is given, and the split that it makes.

    Minimises (X² + (N₁ + N₂)²) / 2, which is convex but for the curvature of a cosine: Newton
    steps. Between points where the slope is known to change its sign the interval is halved instead
    where a step leaves it, or is not half of the step before: about a tip, where the slope jumps,
    steps may go to and fro for ever.
    """
    linear = pair.linear
    per_speed = 1.0 / linear.speed
    worth = linear.speed * linear.sine
    climb = climb_to(pair, radius)
    rest, shape = pair.climb - climb, task.shape
    flat_1, flat_2 = climb * climb + shape * shape, rest * rest + shape * shape
    # The node left, as a polynomial of what the inclination changes: cosines of i_i + δ on the
    # drift orbit, halfway to it before, and halfway from it to i_j after it.
    c, s = pair.cosine_i, pair.sine_i
    p0 = (arcs.node_drift + arcs.node_out) * c + arcs.node_back * pair.cosine
    p0 += arcs.node_end * pair.cosine_j + pair.node_rate_j * pair.approach
    p0 -= task.lag + pair.node_rate_i * task.span
    p1 = -arcs.node_drift * s - 0.5 * (arcs.node_out * s + arcs.node_back * linear.sine)
    p2 = -0.5 * arcs.node_drift * c - 0.125 * (arcs.node_out * c + arcs.node_back * pair.cosine)
    p3 = arcs.node_drift * s / 6.0 + (arcs.node_out * s + arcs.node_back * linear.sine) / 48.0
    p4, p5 = arcs.node_drift * c / 24.0, -arcs.node_drift * s / 120.0
    low, high, before = -math.inf, math.inf, math.inf
    node = first = second = 0.0
    for _ in range(MOST_STEPS):
        more = tilt * per_speed
        node = -worth * (p0 + more * (p1 + more * (p2 + more * (p3 + more * (p4 + more * p5)))))
        slope = p1 + more * (2.0 * p2 + more * (3.0 * p3 + more * (4.0 * p4 + more * 5.0 * p5)))
        slope *= -worth * per_speed
        left = linear.tilt - tilt
        first, second = math.sqrt(flat_1 + tilt * tilt), math.sqrt(flat_2 + left * left)
        turn = first + second
        # At the tips of N₁ and N₂ the slope of one is that of the side that is come from.
        inverse_1, inverse_2 = 1.0 / max(first, TIP_M_S), 1.0 / max(second, TIP_M_S)
        inner = tilt * inverse_1 - left * inverse_2
        gradient = node * slope + turn * inner
        hessian = flat_1 * inverse_1 * inverse_1 * inverse_1
        hessian += flat_2 * inverse_2 * inverse_2 * inverse_2
        hessian = slope * slope + inner * inner + turn * hessian
        hessian -= 2.0 * node * worth * per_speed * per_speed * (p2 + 3.0 * more * p3)
        if gradient > 0.0:
            high = tilt
        else:
            low = tilt
        step = (
            -gradient / hessian if hessian > 0.0 else -math.copysign(0.1 * linear.speed, gradient)
        )
        step = min(max(step, -0.1 * linear.speed), 0.1 * linear.speed)
        to_and_fro = abs(step) > 0.5 * before and high - low < math.inf
        if to_and_fro or not low < tilt + step < high:
            step = 0.5 * (low + high) - tilt
        if not abs(step) >= CLOSE_M_S:
            break
        before = abs(step)
        tilt += step
    along = node * first / turn if turn > 0.0 else 0.0
    return Split(math.sqrt(node * node + turn * turn), climb, tilt, along)


@kernel
def free_phase(pair, task, climb, tilt):
    """The optimum if the target is met with any phase, about: b_y and b_z [m/s].

    Parameters
    ----------
    pair : DriftPair
    task : Task
    climb, tilt : float
        To begin with [m/s].

    Returns
    -------
    climb, tilt, least : float
        And a value that ΔV is not below but for what follows from :data:`SMOOTH_M_S` [m/s].
    """
    linear = pair.linear
    worth, per_speed = linear.speed * linear.sine, 1.0 / linear.speed
    round_off = task.shape * task.shape + SMOOTH_M_S * SMOOTH_M_S
    cosine, sine = pair.cosine_i, pair.sine_i
    half, _ = _half(pair, 0.5 * (linear.radius_i + linear.radius_j))
    drifting = task.span - pair.approach - half * (1.0 + pair.fraction)
    # The arcs beside the drift orbit are halfway to it.
    known = task.lag + pair.node_rate_i * (task.span - 0.5 * half)
    known -= pair.node_rate_j * (half * (0.5 + pair.fraction) + pair.approach)
    climb = min(max(climb, pair.least_climb), pair.most_climb)
    before, step_y, step_z = math.inf, 0.0, 0.0
    near = NEAR_M_S * min(1.0, NEAR_SPAN_S / task.span)
    least = 0.0
    for _ in range(MOST_STEPS):
        motion, pull = _rates(pair, radius_of(pair, climb))
        pull *= -motion * drifting
        more = tilt * per_speed
        square = more * more
        even = 1.0 - square * (0.5 - square * (1.0 / 24.0))
        odd = more * (1.0 - square * (1.0 / 6.0 - square * (1.0 / 120.0)))
        c, s = cosine * even - sine * odd, sine * even + cosine * odd
        node = worth * (known - pull * c)
        rest, left = pair.climb - climb, linear.tilt - tilt
        first = math.sqrt(climb * climb + tilt * tilt + round_off)
        second = math.sqrt(rest * rest + left * left + round_off)
        turn = first + second
        value = 0.5 * (node * node + turn * turn)
        if value > before * (1.0 + 1e-12):
            # Too far: half of the way back.
            step_y, step_z = 0.5 * step_y, 0.5 * step_z
            if abs(step_y) + abs(step_z) < near:
                break
            climb, tilt = climb - step_y, tilt - step_z
            continue
        before = value
        # Rates of nodes are as the seventh power of the speed.
        per_drift_speed = 1.0 / (pair.speed_i - climb)
        by_radius = 7.0 * per_drift_speed
        node_y, node_z = worth * pull * c * by_radius, worth * pull * s * per_speed
        inverse_1, inverse_2 = 1.0 / first, 1.0 / second
        turn_y = climb * inverse_1 - rest * inverse_2
        turn_z = tilt * inverse_1 - left * inverse_2
        cube_1 = inverse_1 * inverse_1 * inverse_1
        cube_2 = inverse_2 * inverse_2 * inverse_2
        gradient_y = node * node_y + turn * turn_y
        gradient_z = node * node_z + turn * turn_z
        yy = node_y * node_y + turn_y * turn_y
        yz = node_y * node_z + turn_y * turn_z
        zz = node_z * node_z + turn_z * turn_z
        yy += turn * ((tilt * tilt + round_off) * cube_1 + (left * left + round_off) * cube_2)
        yz -= turn * (climb * tilt * cube_1 + rest * left * cube_2)
        zz += turn * ((climb * climb + round_off) * cube_1 + (rest * rest + round_off) * cube_2)
        # What bends the node, where that leaves the form convex.
        bent_y = yy - 6.0 * node * node_y * per_drift_speed
        bent_z = zz + node * worth * pull * c * per_speed * per_speed
        bent_yz = yz - node * node_z * by_radius
        if bent_y > 0.1 * yy and bent_y * bent_z - bent_yz * bent_yz > 0.1 * (yy * zz - yz * yz):
            yy, zz, yz = bent_y, bent_z, bent_yz
        at_limit = (climb <= pair.least_climb and gradient_y > 0.0) or (
            climb >= pair.most_climb and gradient_y < 0.0
        )
        if at_limit:
            step_y, step_z = 0.0, -gradient_z / zz
        else:
            determinant = yy * zz - yz * yz
            step_y = (yz * gradient_z - zz * gradient_y) / determinant
            step_z = (yz * gradient_y - yy * gradient_z) / determinant
            new = min(max(climb + step_y, pair.least_climb), pair.most_climb)
            if new != climb + step_y:
                step_y = new - climb
                step_z = -(gradient_z + yz * step_y) / zz
        climb_was, tilt_was = climb, tilt
        gain = -(gradient_y * step_y + gradient_z * step_z)
        least = math.sqrt(2.0 * max(value - gain, 0.0))
        climb, tilt = climb + step_y, tilt + step_z
        if abs(step_y) + abs(step_z) < near:
            if first < second:
                pull_y = gradient_y - turn * climb_was * inverse_1
                pull_z = gradient_z - turn * tilt_was * inverse_1
            else:
                pull_y = gradient_y + turn * rest * inverse_2
                pull_z = gradient_z + turn * left * inverse_2
            size = math.hypot(pull_y, pull_z)
            if min(first, second) > TIP_ROOM_M_S or size <= turn or at_limit:
                break
            # A tip that everything else leads away from is no minimum, but steps on it are short.
            climb -= 2.0 * TIP_ROOM_M_S * pull_y / size
            tilt -= 2.0 * TIP_ROOM_M_S * pull_z / size
            climb = min(max(climb, pair.least_climb), pair.most_climb)
            before = math.inf
    return climb, tilt, least


@inlined
def tooth(pair, task, radius, arcs, laps):
    """The drift orbit that makes a number of laps, near one whose arcs are given.

    Parameters
    ----------
    laps : float
        A whole number: turns that the chaser gains beyond ``task.ahead``.

    Returns
    -------
    radius : float
        [m]; NaN if it is not found.
    arcs : Coast
    """
    wanted = task.ahead + TURN * laps
    for _ in range(MOST_STEPS):
        share = (wanted - arcs.phase) / (arcs.phase_slope * radius)
        # The phase falls about with the radius to the power of −1.5: the inverse of that series.
        share *= 1.0 + share * (1.25 + share * (5.0 / 3.0))
        step = min(max(share, -0.2), 0.2) * radius
        radius += step
        arcs = coast(pair, task.span, radius)
        # What is left is of the fourth order in the step, and of the first in how far that series
        # is off, which the arcs beside the drift make it.
        if abs(step) < CLOSE_M * max(1.0, task.span / SHORT_S):
            return radius, arcs
    return math.nan, arcs


@kernel
def split(pair, task, climb, tilt):
    """The cheaper of the two teeth about an optimum of free phase.

    Parameters
    ----------
    pair : DriftPair
    task : Task
    climb, tilt : float
        The optimum, as :func:`free_phase` finds it [m/s].

    Returns
    -------
    Split
    """
    best = Split(math.inf, climb, tilt, 0.0)
    radius = radius_of(pair, climb)
    arcs = coast(pair, task.span, radius)
    if arcs.drift <= 0.0:
        return best
    low = float(math.floor((arcs.phase - task.ahead) / TURN))
    least, most = radius_of(pair, pair.least_climb), radius_of(pair, pair.most_climb)
    for laps in (low, low + 1.0):
        found, there = tooth(pair, task, radius, arcs, laps)
        if not (least <= found <= most) or there.drift <= 0.0:
            continue
        way = _tilt_at(pair, task, there, found, tilt)
        if way.delta_v < best.delta_v:
            best = way
    return best


@kernel
def split_of(pair, task):
    """How a drift leg is split, found from its first guess on."""
    climb, tilt = first_guess(pair, task)
    climb, tilt, _ = free_phase(pair, task, climb, tilt)
    return split(pair, task, climb, tilt)


@kernel
def best_split(pair, departure, arrival):
    """How the drift leg between two times is split."""
    return split_of(pair, task(pair, departure, arrival))


@kernel
def delta_v(pair, departure, arrival):
    """ΔV of the drift leg between two times, infinite if the target cannot be met [m/s]."""
    return best_split(pair, departure, arrival).delta_v


@kernel
def shape_share(pair, departure, arrival):
    """ΔV that eccentricity adds: what the leg costs beyond the same leg between circles [m/s]."""
    leg = task(pair, departure, arrival)
    circles = task_of(pair, departure, arrival, 0.0)
    return max(split_of(pair, leg).delta_v - split_of(pair, circles).delta_v, 0.0)


@kernel
def splits(pair, departures, arrivals):
    """How the drift legs between some departures and some arrivals are split.

    Parameters
    ----------
    pair : DriftPair
    departures : (d,) float64
    arrivals : (a,) float64
        [s].

    Returns
    -------
    (d, a, 4) float64
        The fields of :class:`Split` [m/s].
    """
    found = np.empty((departures.size, arrivals.size, 4))
    for d in range(departures.size):
        for a in range(arrivals.size):
            each = best_split(pair, departures[d], arrivals[a])
            found[d, a, 0], found[d, a, 1] = each.delta_v, each.climb
            found[d, a, 2], found[d, a, 3] = each.tilt, each.along
    return found


@inlined
def margin(change):
    """How far the radius of a drift orbit that differs by so much may be off what is planned [m].

    The flight may take another tooth, and leave or arrive at another crossing.
    """
    return MARGIN_M + MARGIN_SHARE * abs(change)
