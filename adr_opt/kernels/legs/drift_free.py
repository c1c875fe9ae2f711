"""Optimal drift leg with a free phase of the target, by Newton steps in y and z.

Its price is by free burns, from the difference of the eccentricity vectors. At either end burns
ahead that change the speed by y change the eccentricity vector by as much as V̄ |Δe| / 2 = y at no
cost, in whichever direction (docs/model.md section 3.6). So with
n₁ + n₂ = max(|y| + |v_y − y|, V̄ |Δe| / 2) in the plane of the orbit, drifts are split where

    M = hypot( X, hypot(n₁, z) + hypot(n₂, v_z − z) )

is least. The component of Δe across the line on which the plane is turned takes burns along the
radius, which ride on the turn or outgrow it, as in :mod:`.free_burns`: the price is M with that.
"""

import math
from typing import NamedTuple

from ...common.constants import MU_M3_S2
from ..core.compile import inlined
from . import drift_linear
from .free_burns import ROOT_3

CLOSER_M_S = 1e-10
"""As CLOSE_M_S of :mod:`.drift`, where the price is not what is least at the split [m/s]."""


@inlined
def in_plane(pair, shape, climb):
    """Squares of the in-plane ΔV at either end, for a y [m²/s²].

    Parameters
    ----------
    pair : DriftPair
    shape, climb : float
        E and y [m/s].
    """
    rest = pair.climb - climb
    if not pair.free:
        return climb * climb + shape * shape, rest * rest + shape * shape
    one, other = abs(climb), abs(rest)
    more = max(shape - 0.5 * (one + other), 0.0)
    return (one + more) * (one + more), (other + more) * (other + more)


@inlined
def directed(pair, task, climb, node, turn):
    """Price of a split by its M [m/s].

    Parameters
    ----------
    pair : DriftPair
    task : Task
    climb, node, turn : float
        y, X and N₁ + N₂ [m/s].
    """
    tilt, square = pair.linear.tilt, node * node + turn * turn
    line = node * node + tilt * tilt
    if line == 0.0 or task.shape == 0.0:
        return math.sqrt(square)
    # V̄ / 2 times the part of Δe across the line on which plane and node are turned.
    side = abs(tilt * task.shape_y - node * task.shape_x) / math.sqrt(line)
    planar = max(abs(climb) + abs(pair.climb - climb), 2.0 * task.shape)
    theta = max(square - planar * planar, 0.0)
    apart = side + 0.5 * ROOT_3 * math.sqrt(theta)
    ridden = 4.0 * side * side + theta if 12.0 * side * side < theta else apart * apart
    return math.sqrt(square + side / planar * (ridden - side * side - theta))


MOST_STEPS = 40
"""Maximum number of Newton steps."""

SMOOTH_M_S = 0.02
"""Smoothing of the tips of N₁ and N₂ in the search [m/s]."""

NEAR_M_S, NEAR_SPAN_S = 0.03, 30.0 * 86400.0
"""Largest error of the optimum after the last step: about the square of that step over N₁ or N₂.
Longer legs than the span have closer teeth, and less error in proportion."""

TIP_ROOM_M_S = 3.0
"""Distance to a tip of N₁ or N₂ within which a step's square does not estimate its error [m/s]."""

CLOSE_M_S, TINY_M_S = 0.002, 1e-9
"""Last step that is accepted anywhere, and last step that counts as zero [m/s]."""

MATCHING, MOST_TILTS = 6, 12
"""Numbers of steps to the optimum by free burns, and most Newton steps in each."""

SAMPLES, BENT_S = 8, 8.0 * 86400.0
"""Number of b_y beside each other that are tried, and from which T on: then changes of inclination
move the node so far that M has several valleys."""

GAIN_M_S = 5e-3
"""Largest gain of the last step: where the function is flat, a long step may gain much [m/s]."""


class Free(NamedTuple):
    """Optimal drift leg with a free phase of the target.

    Attributes
    ----------
    climb, tilt : float
        b_y and b_z [m/s].
    least : float
        ΔV is not below it but for what follows from :data:`SMOOTH_M_S` [m/s].
    follow : float
        How much b_z changes with b_y.
    room : float
        The lesser of N₁ and N₂, 0 at an altitude limit: form and slopes bend within it [m/s].
    """

    climb: float
    tilt: float
    least: float
    follow: float
    room: float


class Bowl(NamedTuple):
    """A parabola in b_y that is added to the square of the ΔV.

    Attributes
    ----------
    steepness : float
    bottom : float
        b_y of its lowest point [m/s].
    least : float
        Value at the lowest point [m²/s²].
    """

    steepness: float
    bottom: float
    least: float


LEVEL = Bowl(0.0, 0.0, 0.0)
"""No parabola."""


@inlined
def with_bowl(form, bowl, climb):
    """ΔV with the parabola added, from the ΔV without it and b_y [m/s]."""
    away = climb - bowl.bottom
    return math.sqrt(form * form + bowl.steepness * away * away + bowl.least)


class Rest(NamedTuple):
    """Node difference left on arrival: on the drift orbit, and on the arcs beside it.

    Attributes
    ----------
    known : float
        If it does not move on the drift orbit [rad].
    by_climb, by_tilt : float
        How much more for each m/s of b_y and b_z [rad s/m].
    drifting : float
        Time on the drift orbit, with the shares of the arcs beside it [s].
    """

    known: float
    by_climb: float
    by_tilt: float
    drifting: float


@inlined
def first_guess(pair, task):
    """First-order optimum with a free phase: b_y and b_z [m/s]."""
    linear = pair.linear
    node = linear.speed * linear.sine * task.lag
    climb = drift_linear.climb_of(linear, task.span, node)
    _, tilt = drift_linear.split_at(linear, task.span, node, climb)
    return climb, tilt


@inlined
def rest_of(pair, task):
    """Node difference left by a leg, as a function of its drift orbit.

    Parameters
    ----------
    pair : DriftPair
    task : Task

    Returns
    -------
    Rest
    """
    half = pair.half
    drifting = task.span - pair.approach - half * (1.0 + pair.fraction)
    # The arcs beside the drift orbit are halfway to it.
    known = task.lag + pair.node_rate_i * (task.span - 0.5 * half)
    known -= pair.node_rate_j * (half * (0.5 + pair.fraction) + pair.approach)
    return Rest(known, 0.0, 0.0, drifting)


@inlined
def free_phase(pair, task, rest_of_node, climb, tilt):
    """Approximate optimum of a drift leg with a free phase of the target.

    By free burns the one between circles, which costs no more and which :func:`matched` goes on
    from.

    Parameters
    ----------
    pair : DriftPair
    task : Task
    rest_of_node : Rest
    climb, tilt : float
        To begin with [m/s].

    Returns
    -------
    Free
    """
    shape = 0.0 if pair.free else task.shape
    return least_turns(pair, task.span, shape, LEVEL, rest_of_node, climb, tilt)


@inlined
def node_of(pair, rest_of_node, climb, tilt):
    """X of b_y and b_z [m/s], and its derivatives by both."""
    linear, speed = pair.linear, pair.speed_i - climb
    worth, axis = linear.speed * linear.sine, speed * speed * (1.0 / MU_M3_S2)
    pull = -1.5 * pair.oblateness * axis * axis * axis * speed * rest_of_node.drifting
    inclination = pair.inclination_i + tilt / linear.speed
    gone, slope = pull * math.cos(inclination), pull * math.sin(inclination)
    node = worth * (rest_of_node.known - gone)
    return node, worth * 7.0 * gone / speed, worth * slope / linear.speed


@inlined
def tilted(pair, shape, rest_of_node, climb, tilt):
    """Optimum b_z of M for a b_y, X there, and M [m/s]."""
    first, second = in_plane(pair, shape, climb)
    first, second = first + SMOOTH_M_S * SMOOTH_M_S, second + SMOOTH_M_S * SMOOTH_M_S
    node = value = 0.0
    for _ in range(MOST_TILTS):
        node, _, slope = node_of(pair, rest_of_node, climb, tilt)
        left = pair.linear.tilt - tilt
        one, other = math.sqrt(first + tilt * tilt), math.sqrt(second + left * left)
        turn, inner = one + other, tilt / one - left / other
        value = math.sqrt(node * node + turn * turn)
        bent = first / (one * one * one) + second / (other * other * other)
        step = node * slope + turn * inner
        step /= slope * slope + inner * inner + turn * bent
        tilt -= step
        if abs(step) < CLOSE_M_S:
            break
    return tilt, node, value


@inlined
def matched(pair, task, rest_of_node, circles):
    """Optimum of M, from the one between circles; equal without free burns.

    They are the same where that changes speeds by as much as eccentricities ask for. Else all b_y
    that do cost the same in the plane, and the node alone chooses: none of it is left, or b_y is
    the last of them.

    Parameters
    ----------
    pair : DriftPair
    task : Task
    rest_of_node : Rest
    circles : Free
    """
    climb, tilt, shape = circles.climb, circles.tilt, task.shape
    if not pair.free or abs(climb) + abs(pair.climb - climb) >= 2.0 * shape:
        return circles
    before, slope, _ = node_of(pair, rest_of_node, climb, tilt)
    there = 0.5 * pair.climb - math.copysign(shape, before * slope)
    there = min(max(there, pair.least_climb), pair.most_climb)
    tilt, node, least = tilted(pair, shape, rest_of_node, there, tilt)
    for _ in range(MATCHING if node * before < 0.0 else 0):
        # Between both the node vanishes: false position, the end that stays counting half.
        between = there - node * (there - climb) / (node - before)
        tilt, new, least = tilted(pair, shape, rest_of_node, between, tilt)
        if new * node < 0.0:
            climb, before = there, node
        else:
            before *= 0.5
        there, node = between, new
    if task.span > BENT_S:
        there, tilt, least = searched(pair, shape, rest_of_node, there, tilt, least)
    return Free(there, tilt, least, 0.0, 0.0)


@inlined
def searched(pair, shape, rest_of_node, climb, tilt, least):
    """A lower M among all b_y that cost nothing in the plane: samples, then shrinking steps."""
    low = max(0.5 * pair.climb - shape, pair.least_climb)
    high = min(0.5 * pair.climb + shape, pair.most_climb)
    step = (high - low) / SAMPLES
    for number in range(SAMPLES + 1):
        place = low + number * step
        turned, _, value = tilted(pair, shape, rest_of_node, place, tilt)
        if value < least:
            climb, tilt, least = place, turned, value
    for _ in range(MATCHING):
        step *= 0.5
        below, above = max(climb - step, low), min(climb + step, high)
        one, _, value = tilted(pair, shape, rest_of_node, below, tilt)
        other, _, more = tilted(pair, shape, rest_of_node, above, tilt)
        if value < least and value <= more:
            climb, tilt, least = below, one, value
        elif more < least:
            climb, tilt, least = above, other, more
    return climb, tilt, least


@inlined
def least_turns(pair, span, shape, bowl, rest_of_node, climb, tilt):
    """Optimum b_y and b_z for a given time on the drift orbit.

    Parameters
    ----------
    pair : DriftPair
    span, shape : float
        T [s] and E [m/s].
    bowl : Bowl
    rest_of_node : Rest
    climb, tilt : float
        To begin with [m/s].

    Returns
    -------
    Free
    """
    linear = pair.linear
    known, by_climb, by_tilt, drifting = rest_of_node
    worth, per_speed = linear.speed * linear.sine, 1.0 / linear.speed
    round_off = shape * shape + SMOOTH_M_S * SMOOTH_M_S
    cosine, sine = pair.cosine_i, pair.sine_i
    climb = min(max(climb, pair.least_climb), pair.most_climb)
    before, step_y, step_z = math.inf, 0.0, 0.0
    near = NEAR_M_S * min(1.0, NEAR_SPAN_S / span)
    close = min(near, CLOSE_M_S)
    least = follow = room = 0.0
    climb_was, tilt_was, is_first = climb, tilt, False
    first_left = second_left = True
    for _ in range(MOST_STEPS):
        # 1 / r and the mean motion are as the square and the cube of the speed.
        speed = pair.speed_i - climb
        inverse = speed * speed * (1.0 / MU_M3_S2)
        pull = -1.5 * pair.oblateness * inverse * inverse * inverse * speed * drifting
        more = tilt * per_speed
        square = more * more
        even = 1.0 - square * (0.5 - square * (1.0 / 24.0))
        odd = more * (1.0 - square * (1.0 / 6.0 - square * (1.0 / 120.0)))
        c, s = cosine * even - sine * odd, sine * even + cosine * odd
        node = worth * (known + by_climb * climb + by_tilt * tilt - pull * c)
        rest, left = pair.climb - climb, linear.tilt - tilt
        first = math.sqrt(climb * climb + tilt * tilt + round_off)
        second = math.sqrt(rest * rest + left * left + round_off)
        turn = first + second
        away = climb - bowl.bottom
        pulled = bowl.steepness * away
        value = 0.5 * (node * node + turn * turn + pulled * away + bowl.least)
        if value > before * (1.0 + 1e-12):
            # Too far: to the nearer tip, which the optimum may be at, or half of the way back.
            if (is_first and first_left) or (not is_first and second_left):
                if is_first:
                    climb, tilt, first_left = 0.0, 0.0, False
                else:
                    climb, tilt, second_left = pair.climb, linear.tilt, False
                climb = min(max(climb, pair.least_climb), pair.most_climb)
                continue
            step_y, step_z = 0.5 * step_y, 0.5 * step_z
            if abs(step_y) + abs(step_z) < TINY_M_S:
                climb, tilt = climb_was, tilt_was
                break
            climb, tilt = climb_was + step_y, tilt_was + step_z
            continue
        climb_was, tilt_was = climb, tilt
        before, is_first = value, first < second
        # Rates of nodes are as the seventh power of the speed.
        per_drift_speed = 1.0 / speed
        by_radius = 7.0 * per_drift_speed
        node_y = worth * (pull * c * by_radius + by_climb)
        node_z = worth * (pull * s * per_speed + by_tilt)
        inverse_1, inverse_2 = 1.0 / first, 1.0 / second
        turn_y = climb * inverse_1 - rest * inverse_2
        turn_z = tilt * inverse_1 - left * inverse_2
        cube_1 = inverse_1 * inverse_1 * inverse_1
        cube_2 = inverse_2 * inverse_2 * inverse_2
        gradient_y = node * node_y + turn * turn_y + pulled
        gradient_z = node * node_z + turn * turn_z
        yy = node_y * node_y + turn_y * turn_y + bowl.steepness
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
        per_determinant = 1.0 / (yy * zz - yz * yz)
        step_y = (yz * gradient_z - zz * gradient_y) * per_determinant
        step_z = (yz * gradient_y - yy * gradient_z) * per_determinant
        new = min(max(climb + step_y, pair.least_climb), pair.most_climb)
        at_limit = new != climb + step_y
        if at_limit:
            step_y = new - climb
            step_z = -(gradient_z + yz * step_y) / zz
        gain = -(gradient_y * step_y + gradient_z * step_z)
        least = math.sqrt(2.0 * max(value - gain, 0.0))
        climb, tilt = climb + step_y, tilt + step_z
        follow, room = -yz / zz, 0.0 if at_limit else min(first, second)
        # A Newton step leaves an error of its own square over the distance to a tip, where the
        # function bends most: a step for which that is little enough is the last one.
        size = abs(step_y) + abs(step_z)
        is_sure = gain < GAIN_M_S * (abs(node) + turn)
        if size < close or (is_sure and size * size < near * (room - TIP_ROOM_M_S)):
            break
    return Free(climb, tilt, least, follow, room)
