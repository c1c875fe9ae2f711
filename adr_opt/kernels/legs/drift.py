"""Drift legs in closed form: exact rates, whole laps, and the least sum of the two burns.

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

Legs by free burns have the price of :mod:`.drift_free` instead.
"""

import math
from typing import NamedTuple

import numpy as np

from ...common.constants import TURN_RAD
from ..core.compile import inlined, kernel
from . import drift_pair
from .drift_arcs import NodeSeries, coast, moved
from .drift_free import (
    CLOSER_M_S,
    NEAR_M_S,
    directed,
    first_guess,
    free_phase,
    in_plane,
    matched,
    rest_of,
)
from .drift_pair import climb_to, radius_of

MOST_STEPS = 40
"""Maximum number of Newton steps."""

CLOSE_M, SHORT_S = 100.0, 86400.0
"""Largest last step of a radius in a leg of one day, in proportion for longer ones: the error is of
fourth order in it."""

CLOSE_M_S = 5e-5
"""Least saving for which a step of the inclination is taken [m/s]."""

TIP_M_S = 1e-6
"""Lower limit of N₁ and N₂ as divisors [m/s]."""

NEARER, FAR = 0.25, 8.0
"""A tooth is accepted without examining the next if the optimum is within this share of the way to
it and N₁ and N₂ are this many times as large as that way: costs are then nearly a parabola."""

STEADY = 3e-4
"""Largest step to a tooth, as a share of the radius, for which arcs are not computed again."""

SURE_M_S = 3.0
"""Largest error of the optimum of free phase by free burns [m/s]."""


class Split(NamedTuple):
    """Split of a drift leg: ΔV, and the first burn's change of size, inclination and node.

    All in m/s; infinite ΔV if no tooth lies between the altitude limits.
    """

    delta_v: float
    climb: float
    tilt: float
    along: float


@inlined
def tooth(pair, task, radius, arcs, laps):
    """The drift orbit that makes a number of laps, near one with known arcs.

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
    wanted = task.ahead + TURN_RAD * laps
    for _ in range(MOST_STEPS):
        share = (wanted - arcs.phase) / (arcs.phase_slope * radius)
        # The phase falls about with the radius to the power of −1.5: the inverse of that series.
        share *= 1.0 + share * (1.25 + share * (5.0 / 3.0))
        step = min(max(share, -0.2), 0.2) * radius
        # What is left is of the fourth order in the step, and of the first in how far that series
        # is off, which the arcs beside the drift make it.
        if abs(step) < CLOSE_M * max(1.0, task.span / SHORT_S):
            return radius + step, moved(arcs, radius, step)
        radius += step
        arcs = coast(pair, task.span, radius)
    return math.nan, arcs


@inlined
def node_series(pair, task, arcs):
    """Node difference left to close by a drift leg with given arcs.

    With cosines of i_i + δ on the drift orbit, halfway to it before, and halfway on after it.
    """
    linear, c, s = pair.linear, pair.cosine_i, pair.sine_i
    p0 = (arcs.node_drift + arcs.node_out) * c + arcs.node_back * pair.cosine
    p0 += arcs.node_end * pair.cosine_j + pair.node_rate_j * pair.approach
    p0 -= task.lag + pair.node_rate_i * task.span
    p1 = -arcs.node_drift * s - 0.5 * (arcs.node_out * s + arcs.node_back * linear.sine)
    p2 = -0.5 * arcs.node_drift * c - 0.125 * (arcs.node_out * c + arcs.node_back * pair.cosine)
    p3 = arcs.node_drift * s / 6.0 + (arcs.node_out * s + arcs.node_back * linear.sine) / 48.0
    return NodeSeries(p0, p1, p2, p3, arcs.node_drift * c / 24.0, -arcs.node_drift * s / 120.0)


@inlined
def tilt_at(pair, flat, series, climb, tilt, close):
    """The best z for a given drift orbit, near a given z: the split, X, N₁ + N₂ and the next z.

    Minimises (X² + (N₁ + N₂)²) / 2, which is convex but for the curvature of a cosine: Newton
    steps. Between points where the slope is known to change its sign the interval is halved instead
    where a step leaves it, or is not half of the step before: about a tip, where the slope jumps,
    steps may go to and fro for ever.

    Parameters
    ----------
    pair : DriftPair
    flat : (float, float)
        Squares of N₁ and N₂ without a change of inclination [m²/s²].
    series : NodeSeries
    climb, tilt : float
        [m/s].
    close : float
        A step that saves less is not taken [m/s].
    """
    linear = pair.linear
    per_speed = 1.0 / linear.speed
    worth = linear.speed * linear.sine
    flat_1, flat_2 = flat
    p0, p1, p2, p3, p4, p5 = series
    low, high, before = -math.inf, math.inf, math.inf
    node = first = second = step = 0.0
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
        # Only a step that saves more than the tolerance is taken.
        if not gradient * gradient > 2.0 * close * abs(hessian) * (abs(node) + turn):
            break
        before = abs(step)
        tilt += step
    along = node * first / turn if turn > 0.0 else 0.0
    way = Split(math.sqrt(node * node + turn * turn), climb, tilt, along)
    return way, node, turn, tilt + step


@inlined
def split(pair, task, free):
    """The cheaper of the two teeth around a free-phase optimum.

    Parameters
    ----------
    pair : DriftPair
    task : Task
    free : Free

    Returns
    -------
    Split
    """
    if pair.free:
        return free_split(pair, task, free)
    best = Split(math.inf, free.climb, free.tilt, 0.0)
    radius = radius_of(pair, free.climb)
    arcs = coast(pair, task.span, radius)
    if arcs.drift <= 0.0:
        return best
    laps = (arcs.phase - task.ahead) / TURN_RAD
    least, most = radius_of(pair, pair.least_climb), radius_of(pair, pair.most_climb)
    nearer = float(math.floor(laps + 0.5))
    other = nearer + 1.0 if laps > nearer else nearer - 1.0
    for number in (nearer, other):
        found, there = tooth(pair, task, radius, arcs, number)
        if not (least <= found <= most) or there.drift <= 0.0:
            continue
        climb = climb_to(pair, found)
        away = climb - free.climb
        tilt = free.tilt + free.follow * away if FAR * abs(away) < free.room else free.tilt
        series = node_series(pair, task, there)
        flat = in_plane(pair, task.shape, climb)
        way, _, _, _ = tilt_at(pair, flat, series, climb, tilt, CLOSE_M_S)
        if way.delta_v < best.delta_v:
            best = way
        if abs(laps - nearer) < NEARER and FAR * (1.0 - NEARER) / NEARER * abs(away) < free.room:
            break
    return best


@inlined
def free_split(pair, task, free):
    """The tooth of least M, with the price of free burns (:mod:`.drift_free`).

    M is convex but for the curvature of rates: of the teeth about the optimum of free phase the
    better one is best of all, and where one is as near as the error of that optimum, others are
    gone through as long as M falls.
    """
    best = Split(math.inf, free.climb, free.tilt, 0.0)
    radius = radius_of(pair, free.climb)
    arcs = coast(pair, task.span, radius)
    if arcs.drift <= 0.0:
        return best
    laps = (arcs.phase - task.ahead) / TURN_RAD
    least, most = radius_of(pair, pair.least_climb), radius_of(pair, pair.most_climb)
    nearer = chosen = float(math.floor(laps + 0.5))
    side = 1.0 if laps > nearer else -1.0
    number, turned, is_sure = nearer, False, False
    reached, along, closer = radius, arcs, free.tilt
    # Where eccentricities cost nothing beside changes of size, M is that between circles, elsewhere
    # no less: the optimum is theirs.
    doubt = SURE_M_S if free.room == 0.0 else NEAR_M_S
    while True:
        found, there = tooth(pair, task, radius, arcs, number)
        is_better, away = False, math.inf
        if least <= found <= most and there.drift > 0.0:
            climb = climb_to(pair, found)
            away = abs(climb - free.climb)
            tilt = best.tilt
            if FAR * away < free.room:
                tilt = free.tilt + free.follow * (climb - free.climb)
            flat = in_plane(pair, task.shape, climb)
            series = node_series(pair, task, there)
            way, _, _, after = tilt_at(pair, flat, series, climb, tilt, CLOSE_M_S)
            is_better = way.delta_v < best.delta_v
            if is_better:
                best, chosen, closer = way, number, after
                reached, along = found, there
        if number == nearer:
            room = FAR * (1.0 - NEARER) / NEARER * away
            if is_better and abs(laps - nearer) < NEARER and room < free.room:
                break
            if abs(best.climb) + abs(pair.climb - best.climb) < 2.0 * task.shape:
                doubt = SURE_M_S
            is_sure = away > doubt
        elif not is_better or away > doubt:
            # What lies beyond costs more: on with the other side, once.
            if turned or is_sure or chosen != nearer:
                break
            turned, side, number = True, -side, nearer
        number += side
    if best.delta_v == math.inf:
        return best
    # The price is not what is least there: it takes a more exact optimum.
    if abs(reached - radius) > STEADY * radius:
        reached, along = tooth(pair, task, reached, coast(pair, task.span, reached), chosen)
    climb = climb_to(pair, reached)
    flat = in_plane(pair, task.shape, climb)
    series = node_series(pair, task, along)
    way, node, turn, _ = tilt_at(pair, flat, series, climb, closer, CLOSER_M_S)
    return Split(directed(pair, task, climb, node, turn), climb, way.tilt, way.along)


@kernel
def split_of(pair, task):
    """Split of a drift leg, solved from its first guess."""
    climb, tilt = first_guess(pair, task)
    rest_of_node = rest_of(pair, task)
    circles = free_phase(pair, task, rest_of_node, climb, tilt)
    return split(pair, task, matched(pair, task, rest_of_node, circles))


@kernel
def best_split(pair, departure, arrival):
    """Best split of the drift leg between two times."""
    return split_of(pair, drift_pair.task(pair, departure, arrival))


@kernel
def delta_v(pair, departure, arrival):
    """ΔV of the drift leg between two times, infinite if the target cannot be met [m/s]."""
    return best_split(pair, departure, arrival).delta_v


@kernel
def shape_share(pair, departure, arrival):
    """ΔV due to eccentricity: the excess over the same leg between circles [m/s]."""
    leg = drift_pair.task(pair, departure, arrival)
    circles = drift_pair.task_of(pair, departure, arrival, drift_pair.ALIKE)
    return max(split_of(pair, leg).delta_v - split_of(pair, circles).delta_v, 0.0)


@kernel
def splits(pair, departures, arrivals):
    """Splits of the drift legs between given departures and arrivals.

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
