"""Low-thrust legs in closed form: exact rates, whole laps, and converged times of thrust.

The form of :mod:`.drift` in which changes of the plane count κ times. With (y, z) what the first
arc changes of size and inclination, and X what is then left of the node,

    ΔV = min over (y, z) of hypot( κ X(y, z),  hypot(y, κ z) + hypot(v_y − y, κ (v_z − z)) ),

and the node is split between both arcs in proportion to the two inner norms. The arcs take times

    t_k = (m_k v_e / F) (1 − exp(−ΔV_k / v_e)) / share,

which X depends on: half of them is drifted on the orbits at either end. The times are those of the
least root, which is come to from no time at all: the longer the arcs, the less is drifted, and the
more is left to do. What eccentricities ask for is added as a square (:mod:`.low_thrust_shapes`).

After Kéchichian, J. Guidance, Control, and Dynamics 20(5), 1997, 988–994, and Edelbaum; the split
in two arcs derived anew.
"""

import math
from typing import NamedTuple

from ...common.constants import TURN_RAD
from ..core.compile import inlined, kernel
from . import drift_pair
from .drift_arcs import node_at
from .drift_free import LEVEL, Rest, first_guess, least_turns, with_bowl
from .drift_laps import tilt_at
from .drift_pair import Task
from .low_thrust_arcs import (
    ArcTimes,
    Thrust,
    arc_times,
    beside_ramps,
    chord,
    longitude_gained,
    node_series,
    weighted,
)
from .low_thrust_windows import WINDOWS_RAD, places, steering

MOST_ROUNDS = 60
"""Maximum number of rounds in which times of thrust converge."""

CREEPING = 12
"""Number of rounds after which it suffices that the sum of both times has converged."""

CLOSE, CLOSE_M_S = 1e-7, 1e-6
"""Largest last change of the times, as a share of the leg, and of the speed on the drift orbit
[m/s]."""

SAVED_M_S = 1e-9
"""Least saving for which a step of the inclination is taken [m/s]; times amplify its errors."""

LONG_S = 150.0 * 86400.0
"""Legs that are longer are also tried with a turn of the node more and less [s]."""

BUSY, MOST_LAPS = 0.15, 6
"""Share of a leg with thrust from which on laps farther than both next to the optimum of free phase
are tried, and the maximum number of them."""

SLACK_M_S = 0.3
"""Largest excess of the estimate with impulses over the ΔV with thrust [m/s]."""

OFF, OFF_BUSY, OFF_M_S = 2e-3, 0.1, 0.01
"""How far a lower bound is below a split, as a share, by the share of the time with thrust, and
[m/s]: a split is the best for given times of thrust, and another one with less of them, or of a
heavier chaser, may be cheaper."""

LEAST_SHARE = 0.2
"""Share of a revolution with thrust that windows have at least, but for deep shadows."""

WIDER = 1.1
"""Factor on the limit of lower bounds of such legs. Estimates that are compared with it leave out
that a leg may need less where it thrusts for long, or makes another number of laps."""

LIGHTER = 1.01
"""Factor on the acceleration of the lightest chaser in lower bounds."""

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
"""Split of a leg that there is not."""


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
    """Whether times of thrust stay as they are."""
    off = abs(found.first - now.times.first) + abs(found.second - now.times.second)
    return off < CLOSE * span


@inlined
def has_settled_together(now, found, span):
    """Whether their sum stays as it is."""
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
        way = tilt_at(pair, 0.0, series, climb, tilt, SAVED_M_S)
        tilt = way.tilt
        form = with_bowl(way.delta_v, steering.bowl, climb)
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
    """The cheapest tooth near the optimum of free phase: of both beside it, and on from there.

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
    if free.delta_v == math.inf or free.delta_v - OFF * free.delta_v - OFF_M_S >= below:
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
    for _ in range(MOST_LAPS if is_busy else 0):
        number += step
        way = tooth_split(pair, task, thrust, steering, free, follow, number)
        if way.delta_v >= best.delta_v:
            break
        best = way
    return best


@inlined
def task_turned(pair, task, turns):
    """The same task with the node turned some more whole turns."""
    more = turns * TURN_RAD
    return Task(task.span, task.lag + more, task.ahead + pair.cosine * more, 0.0)


class LowThrustLeg(NamedTuple):
    """A low-thrust leg.

    Attributes
    ----------
    split : LowThrustSplit
    window : float
        η [rad].
    turn : float
        κ.
    """

    split: LowThrustSplit
    window: float
    turn: float


@inlined
def with_impulses(drift, task, turn, bowl):
    """ΔV with a free phase and no time for thrust, changes of the plane counting κ times [m/s].

    Never above that of :func:`free_split` but for rounding of :mod:`.drift_free`.
    """
    pair = weighted(drift, turn)
    climb, tilt = first_guess(pair, task)
    known = task.lag + pair.node_rate_i * task.span - pair.node_rate_j * pair.approach
    left_over = Rest(known, 0.0, 0.0, task.span - pair.approach)
    least = least_turns(pair, task.span, 0.0, bowl, left_over, climb, tilt).least
    return chord(least, drift.linear.speed)


@inlined
def _lower(split, span):
    """A split whose ΔV is a lower bound, also where a split beside it would be cheaper."""
    if split.delta_v == math.inf:
        return NEVER
    share = min((split.times.first + split.times.second) / span, 1.0)
    less = split.delta_v - (OFF + OFF_BUSY * share) * split.delta_v - OFF_M_S
    return LowThrustSplit(less, split.first, split.climb, split.tilt, split.node, split.times)


@inlined
def is_too_dear(impulses, thrust, span, below, relaxed):
    """Whether an estimate with impulses says that a leg costs as much as a limit.

    Parameters
    ----------
    impulses : float
        As :func:`with_impulses` has it [m/s].
    thrust : Thrust
    span : float
        [s].
    below : float
        [m/s].
    relaxed : bool
    """
    may_be_busy = relaxed and impulses > BUSY * LEAST_SHARE * thrust.acceleration * span
    return impulses >= (WIDER * below if may_be_busy else below)


@kernel
def leg_below(pair, thrust, departure, arrival, below, relaxed):
    """The low-thrust leg between two times: the cheapest of all windows and ways of the node.

    Parameters
    ----------
    pair : LowThrustPair
    thrust : Thrust
    departure, arrival : float
        [s].
    below : float
        No leg that costs as much is wanted [m/s].
    relaxed : bool
        Whether a lower bound of all heavier chasers' legs is wanted: the phase is free.

    Returns
    -------
    LowThrustLeg
        Of infinite ΔV if there is none.
    """
    drift = pair.drift
    nearer = drift_pair.task_of(drift, departure, arrival, 0.0)
    best = LowThrustLeg(NEVER, 0.0, 1.0)
    below = below + SLACK_M_S
    for turns in (0.0, -1.0, 1.0):
        if turns != 0.0 and nearer.span <= LONG_S:
            continue
        task = task_turned(drift, nearer, turns)
        impulses = with_impulses(drift, task, 1.0, LEVEL)
        if is_too_dear(impulses, thrust, task.span, below, relaxed):
            continue
        at = places(pair, task, departure, arrival)
        for window in WINDOWS_RAD:
            steers = steering(at, window)
            impulses = with_impulses(drift, task, steers.turn, steers.bowl)
            if is_too_dear(impulses, thrust, task.span, below, relaxed):
                continue
            pair_of = weighted(drift, steers.turn)
            if relaxed:
                way, _ = free_split(pair_of, task, thrust, steers)
                way = _lower(way, task.span)
            else:
                way = split(pair_of, task, thrust, steers, below)
            if way.delta_v < best.split.delta_v:
                best = LowThrustLeg(way, window, steers.turn)
                below = min(below, way.delta_v + SLACK_M_S)
    return best


@kernel
def bound_below(pair, lightest, departure, arrival, below):
    """Lower bound of the ΔV of the legs of a chaser of any mass between two times [m/s].

    docs/model.md section 11.4 says how far it is known to hold.

    Parameters
    ----------
    pair : LowThrustPair
    lightest : Thrust
        Of the chaser with the least mass.
    departure, arrival : float
        [s].
    below : float
        No bound that is as large is wanted [m/s].
    """
    pushed = Thrust(LIGHTER * lightest.acceleration, lightest.exhaust)
    least = leg_below(pair, pushed, departure, arrival, below, True).split.delta_v
    if least < math.inf:
        return least
    # Where all of the time is hardly enough, times may converge for one and not for the other.
    return leg_below(pair, lightest, departure, arrival, below, True).split.delta_v


@kernel
def leg_stated(pair, thrust, departure, arrival, stated):
    """The low-thrust leg between two times whose ΔV is nearest to a stated one.

    Where limits are known, as in lists of connections, a leg in other windows may be passed over
    that is a little cheaper than the one in the list.

    Parameters
    ----------
    pair, thrust, departure, arrival
        As :func:`leg_below` takes them.
    stated : float
        [m/s].
    """
    drift = pair.drift
    nearer = drift_pair.task_of(drift, departure, arrival, 0.0)
    best, least = LowThrustLeg(NEVER, 0.0, 1.0), math.inf
    for turns in (0.0, -1.0, 1.0):
        if turns != 0.0 and nearer.span <= LONG_S:
            continue
        task = task_turned(drift, nearer, turns)
        at = places(pair, task, departure, arrival)
        for window in WINDOWS_RAD:
            steers = steering(at, window)
            drift_of = weighted(drift, steers.turn)
            way = split(drift_of, task, thrust, steers, math.inf)
            off = abs(way.delta_v - stated)
            if off < least:
                best, least = LowThrustLeg(way, window, steers.turn), off
    return best


@kernel
def leg_between(pair, thrust, departure, arrival):
    """The low-thrust leg between two times, of infinite ΔV if there is none."""
    return leg_below(pair, thrust, departure, arrival, math.inf, False)


@kernel
def delta_v(pair, thrust, departure, arrival):
    """ΔV of the low-thrust leg between two times, infinite if there is none [m/s]."""
    return leg_between(pair, thrust, departure, arrival).split.delta_v
