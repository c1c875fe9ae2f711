"""Low-thrust legs in closed form: exact rates, whole laps, and converged times of thrust.

The form of :mod:`.drift` in which changes of the plane count κ times. With (y, z) what the first
arc changes of size and inclination, and X what is then left of the node,

    ΔV = min over (y, z) of hypot( κ X(y, z),  hypot(y, κ z) + hypot(v_y − y, κ (v_z − z)) ),

and the node is split between both arcs in proportion to the two inner norms. The arcs take times

    t_k = (m_k v_e / F) (1 − exp(−ΔV_k / v_e)) / share,

which X depends on: half of them is drifted on the orbits at either end. The times are the
least that fulfil this, found by beginning with none: the longer the arcs, the less is drifted, and
mostly the more is left to do. What eccentricities ask for is added as a square
(:mod:`.low_thrust_windows`).

After Kéchichian, J. Guidance, Control, and Dynamics 20(5), 1997, 988–994, and Edelbaum; the split
in two arcs derived anew.
"""

import math
from typing import NamedTuple

from ...common.constants import TURN_RAD
from ..core.compile import inlined
from .drift import tilt_at
from .drift_arcs import node_at
from .drift_free import Rest, first_guess, least_turns
from .low_thrust_arcs import ArcTimes, arc_times, beside_ramps, chord, longitude_gained, node_series
from .low_thrust_windows import easing, shaped

MOST_ROUNDS = 60
"""Maximum number of rounds in which times of thrust converge."""

CREEPING = 12
"""Number of rounds after which it suffices that the sum of both times has converged."""

CLOSE, CLOSE_M_S = 1e-7, 1e-6
"""Largest last change of the times, as a share of the leg, and of the speed on the drift orbit
[m/s]."""

SAVED_M_S = 1e-9
"""Least saving for which a step of the inclination is taken [m/s]; times amplify its errors."""


BUSY, MOST_LAPS, MOST_EASED_LAPS = 0.15, 6, 60
"""Share of a leg with thrust above which laps beyond the two nearest the free-phase optimum are
tried, and their maximum numbers, here and where eccentricities change with the size."""


OFF, OFF_M_S = 2e-3, 0.01
"""Largest excess of a split over the cheapest one, as a share and in [m/s]: a split is the best for
given times of thrust, and another one with shorter times may be cheaper."""


TIP_M_S = 1e-9
"""Lower limit of the norms of both arcs as a divisor [m/s]."""


class LowThrustSplit(NamedTuple):
    """Split of a low-thrust leg.

    Attributes
    ----------
    delta_v, first : float
        ΔV of both arcs, and of the first one; infinite where there is no such leg [m/s].
    climb, tilt : float
        Change of size, and κ times that of inclination, by the first arc [m/s].
    node : float
        κ times what both arcs turn of the node; 0 where the phase is free [m/s].
    times : ArcTimes
    """

    delta_v: float
    first: float
    climb: float
    tilt: float
    node: float
    times: ArcTimes


NEVER = LowThrustSplit(math.inf, math.inf, 0.0, 0.0, 0.0, ArcTimes(math.inf, math.inf))
"""Split of an impossible leg."""


class Iteration(NamedTuple):
    """Times of thrust on their way to the least root of τ = g(τ).

    Attributes
    ----------
    times : ArcTimes
        τ of both arcs.
    here, before, was : float
        Their sum, that of the round before, and the sum of its g [s].
    """

    times: ArcTimes
    here: float
    before: float
    was: float


@inlined
def starting(times):
    """The iteration that begins at some times."""
    both = times.first + times.second
    return Iteration(times, both, both, 0.0)


@inlined
def followed(now, found, room):
    """The next round, by the secant of both last ones: g is convex, so it stays below the root.

    Parameters
    ----------
    now : Iteration
    found : ArcTimes
        g of its times.
    room : float
        Time that there is [s].
    """
    needed, ahead = found.first + found.second, found.first + found.second
    if now.here > now.before and now.was > now.before:
        slope = (needed - now.was) / (now.here - now.before)
        if 0.0 < slope < 0.9:
            ahead = now.here + (needed - now.here) / (1.0 - slope)
    ahead = min(ahead, room)
    scale = ahead / needed
    return Iteration(ArcTimes(found.first * scale, found.second * scale), ahead, now.here, needed)


@inlined
def laid_out(pair, thrust, steering, form, climb, tilt):
    """ΔV of both arcs, the first one's part of it [m/s], and their times.

    Parameters
    ----------
    form, climb, tilt : float
        What is least, y and κ z [m/s].
    """
    total = chord(form, pair.linear.speed / steering.turn)
    first = first_share(pair, climb, tilt) * total
    shares = steering.first_share, steering.second_share
    return total, first, arc_times(thrust, shares, first, total - first)


@inlined
def has_settled(now, found, span):
    """Whether the times of thrust have converged."""
    off = abs(found.first - now.times.first) + abs(found.second - now.times.second)
    return off < CLOSE * span


@inlined
def has_settled_together(now, found, span):
    """Whether the sum of the times of thrust has converged."""
    return abs(found.first + found.second - now.here) < CLOSE * span


@inlined
def first_share(pair, climb, tilt):
    """The first arc's part of the ΔV, for y and κ z [m/s]."""
    rest, left = pair.climb - climb, pair.linear.tilt - tilt
    one, other = math.sqrt(climb * climb + tilt * tilt), math.sqrt(rest * rest + left * left)
    return one / (one + other) if one + other > TIP_M_S else 0.5


@inlined
def free_split(pair, task, thrust, steering):
    """Optimum with a free phase of the target, and converged times of thrust.

    Where many splits cost the same, the arcs' parts of the times creep for long, towards more time
    or less; the ΔV does not, and there may be a leg where the last split has not enough time.

    Parameters
    ----------
    pair : DriftPair
        As :func:`.low_thrust_arcs.weighted` makes it.
    task : Task
        Without E.
    thrust : Thrust
    steering : Steering

    Returns
    -------
    split : LowThrustSplit
        Of infinite ΔV if the thrust of all the time is too little for it.
    follow : float
        How much b_z changes with b_y.
    """
    climb, tilt = first_guess(pair, task)
    room = task.span - pair.approach
    shares = steering.first_share, steering.second_share
    most = room * max(shares[0], shares[1])
    now = starting(ArcTimes(0.0, 0.0))
    last, follow = NEVER, 0.0
    # Times of thrust begin at none and mostly rise, so that they come to the least of their roots;
    # once they take more than all of the time, no root is left.
    for number in range(MOST_ROUNDS):
        known = task.lag + pair.node_rate_i * (task.span - 0.5 * now.times.first)
        known -= pair.node_rate_j * (0.5 * now.times.second + pair.approach)
        more, by_climb, by_tilt = beside_ramps(pair, now.times, climb, tilt)
        known += by_climb * climb + by_tilt * tilt - more
        left_over = Rest(known, -by_climb, -by_tilt, room - 0.5 * now.here)
        free = least_turns(pair, task.span, 0.0, steering.bowl, left_over, climb, tilt)
        climb, tilt, follow = free.climb, free.tilt, free.follow
        delta_v, first, found = laid_out(pair, thrust, steering, free.least, climb, tilt)
        if found.first * shares[0] + found.second * shares[1] > most:
            return NEVER, 0.0
        last = LowThrustSplit(delta_v, first, climb, tilt, 0.0, found)
        creeps = number >= CREEPING and has_settled_together(now, found, task.span)
        if creeps or has_settled(now, found, task.span):
            break
        now = followed(now, found, room)
    return last, follow


@inlined
def tooth_split(pair, task, thrust, steering, free, follow, laps):
    """The leg that meets the target after a number of laps, near the optimum of free phase.

    Parameters
    ----------
    pair, task, thrust, steering
        As :func:`free_split` takes them.
    free : LowThrustSplit
    follow : float
    laps : float
        A whole number: turns that the chaser gains beyond ``task.ahead``.

    Returns
    -------
    LowThrustSplit
    """
    room = task.span - pair.approach
    wanted = task.ahead + TURN_RAD * laps
    speed, climb, tilt = pair.speed_i - free.climb, free.climb, free.tilt
    now = starting(free.times)
    for _ in range(MOST_ROUNDS):
        # The longitude rises with the speed of the drift orbit: Newton steps find the only root.
        for _ in range(MOST_ROUNDS):
            gained, slope = longitude_gained(pair, room - now.here, now.times, speed)
            step = (wanted - gained) / slope
            step = min(max(step, -0.1 * speed), 0.1 * speed)
            speed += step
            if abs(step) < CLOSE_M_S:
                break
        tilt += follow * (pair.speed_i - speed - climb)
        climb, follow = pair.speed_i - speed, 0.0
        if not (pair.least_climb <= climb <= pair.most_climb):
            break
        series = node_series(pair, task, room - now.here, now.times, speed)
        rest = pair.climb - climb
        way, _, _, _ = tilt_at(pair, (climb * climb, rest * rest), series, climb, tilt, SAVED_M_S)
        tilt = way.tilt
        form = shaped(pair, steering, way.delta_v, climb)
        delta_v, first, found = laid_out(pair, thrust, steering, form, climb, tilt)
        if found.first + found.second > room:
            break
        if has_settled(now, found, task.span):
            node = pair.linear.speed * pair.linear.sine
            node *= -node_at(series, tilt / pair.linear.speed)
            return LowThrustSplit(delta_v, first, climb, tilt, node, found)
        now = followed(now, found, room)
    return NEVER


@inlined
def split(pair, task, thrust, steering, below):
    """The cheapest tooth near the free-phase optimum: the two beside it, then further ones.

    Parameters
    ----------
    pair, task, thrust, steering
        As :func:`free_split` takes them.
    below : float
        No leg that costs as much is wanted [m/s].

    Returns
    -------
    LowThrustSplit
    """
    free, follow = free_split(pair, task, thrust, steering)
    least = easing(steering) * (free.delta_v - OFF * free.delta_v) - OFF_M_S
    if free.delta_v == math.inf or least >= below:
        return NEVER
    is_busy = free.times.first + free.times.second > BUSY * task.span
    coasting = task.span - pair.approach - free.times.first - free.times.second
    gained, _ = longitude_gained(pair, coasting, free.times, pair.speed_i - free.climb)
    laps = (gained - task.ahead) / TURN_RAD
    nearer = float(math.floor(laps + 0.5))
    number = nearer + 1.0 if laps > nearer else nearer - 1.0
    best = tooth_split(pair, task, thrust, steering, free, follow, number)
    way = tooth_split(pair, task, thrust, steering, free, follow, nearer)
    step = number - nearer
    if way.delta_v < best.delta_v:
        best, number, step = way, nearer, -step
    # The optimum of free phase is one for its times of thrust; fewer may be needed farther on.
    # By a norm of a higher power it is only near its own.
    most = MOST_EASED_LAPS if steering.power != 2.0 else MOST_LAPS if is_busy else 0
    for _ in range(most):
        number += step
        way = tooth_split(pair, task, thrust, steering, free, follow, number)
        if way.delta_v >= best.delta_v:
            break
        best = way
    return best
