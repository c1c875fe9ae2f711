"""Low-thrust legs between two times: the best of their windows, and lower bounds for all masses.

Of legs whose arcs are split by :mod:`.low_thrust_split` (docs/model.md section 11).
"""

import math
from typing import NamedTuple

import numpy as np

from ...common.constants import TURN_RAD
from ..core.compile import inlined, kernel
from ..core.lists import wider
from . import drift_pair
from .drift_free import LEVEL, Rest, first_guess, least_turns
from .drift_grid import first_to_last
from .drift_pair import ALIKE, Task
from .low_thrust_arcs import Thrust, chord, weighted
from .low_thrust_split import BUSY, NEVER, OFF, OFF_M_S, LowThrustSplit, free_split, split
from .low_thrust_windows import WINDOWS_RAD, Steering, easing, places, steering

LONG_S = 150.0 * 86400.0
"""Duration above which legs are also tried with one more and one less turn of the node [s]."""

SLACK_M_S = 0.3
"""Largest excess of the estimate with impulses over the ΔV with thrust [m/s]."""

OFF_BUSY = 0.1
"""Further margin of a lower bound below a split, as a share, per share of the time with thrust:
heavier chasers may have cheaper legs then."""

LEAST_SHARE = 0.2
"""Least share of a revolution with thrust in a window, except in deep shadow."""

WIDER = 1.1
"""Factor on the limit of lower bounds of legs that may thrust for long. Estimates that are compared
with it leave out that such a leg may need less, or makes another number of laps."""

LIGHTER = 1.01
"""Factor on the acceleration of the lightest chaser in lower bounds."""


@inlined
def task_turned(pair, task, turns):
    """The task with a number of whole turns added to the node."""
    more = turns * TURN_RAD
    return Task(task.span, task.lag + more, task.ahead + pair.cosine * more, *ALIKE)


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

    An estimate from below: :func:`.low_thrust_split.free_split` may be less only where thrust is on
    for long.
    """
    pair = weighted(drift, turn)
    climb, tilt = first_guess(pair, task)
    known = task.lag + pair.node_rate_i * task.span - pair.node_rate_j * pair.approach
    left_over = Rest(known, 0.0, 0.0, task.span - pair.approach)
    least = least_turns(pair, task.span, 0.0, bowl, left_over, climb, tilt).least
    return chord(least, drift.linear.speed)


@inlined
def _lower(split, span):
    """A split whose ΔV is a lower bound even if a neighbouring split is cheaper."""
    if split.delta_v == math.inf:
        return NEVER
    share = min((split.times.first + split.times.second) / span, 1.0)
    less = split.delta_v - (OFF + OFF_BUSY * share) * split.delta_v - OFF_M_S
    return LowThrustSplit(less, split.first, split.climb, split.tilt, split.node, split.times)


@inlined
def _eased_split(pair, task, thrust, steers):
    """A split whose ΔV is a lower bound in the norm of its windows.

    That is no less than without eccentricities, and than the root of the sum of squares by its
    easing, which counts in the times as well.
    """
    way, _ = free_split(
        pair, task, Thrust(thrust.acceleration / easing(steers), thrust.exhaust), steers
    )
    if steers.power == 2.0:
        return way
    circles = Steering(steers.turn, steers.first_share, steers.second_share, LEVEL, 2.0)
    other, _ = free_split(pair, task, thrust, circles)
    eased = easing(steers) * way.delta_v
    if other.delta_v >= eased:
        return other
    first = easing(steers) * way.first
    return LowThrustSplit(eased, first, way.climb, way.tilt, way.node, way.times)


@inlined
def _is_too_dear(impulses, thrust, span, below, relaxed):
    """Whether a leg costs at least a limit by its estimate with impulses.

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
    nearer = drift_pair.task_of(drift, departure, arrival, ALIKE)
    best = LowThrustLeg(NEVER, 0.0, 1.0)
    # Estimates with impulses are lower bounds up to this slack, so that what they refuse is refused
    # by the leg itself. A window that is found lowers the limit of those after it.
    below = below + SLACK_M_S
    for turns in (0.0, -1.0, 1.0):
        if turns != 0.0 and nearer.span <= LONG_S:
            continue
        task = task_turned(drift, nearer, turns)
        impulses = with_impulses(drift, task, 1.0, LEVEL)
        if _is_too_dear(impulses, thrust, task.span, below, relaxed):
            continue
        at = places(pair, task, departure, arrival)
        for window in WINDOWS_RAD:
            steers = steering(at, window)
            impulses = easing(steers) * with_impulses(drift, task, steers.turn, steers.bowl)
            if _is_too_dear(impulses, thrust, task.span, below, relaxed):
                continue
            pair_of = weighted(drift, steers.turn)
            if relaxed:
                way = _lower(_eased_split(pair_of, task, thrust, steers), task.span)
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
    nearer = drift_pair.task_of(drift, departure, arrival, ALIKE)
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


NONE_KNOWN = np.empty(0, np.int32), np.empty(0, np.int32), np.empty(0)
"""Default where there are no legs of heavier chasers."""


@kernel
def of_pair(pair, thrust, times, duration, resolution, relaxed, known):
    """Undominated low-thrust legs of a pair.

    Parameters
    ----------
    pair : LowThrustPair
    thrust : Thrust
        Of the chaser with the largest mass, or the least for lower bounds.
    times : Times
        Its interval is not looked at.
    duration : float
        The last arrival [s].
    resolution : float
        A leg that saves no more than this is dominated [m/s].
    relaxed : bool
        Whether to take lower bounds for all masses in place of costs with the largest.
    known : tuple of (legs,) int32, (legs,) int32, (legs,) float64
        Departures and arrivals in steps, and ΔV [m/s], of legs that are there already, in order of
        departure: those of heavier chasers. They are not found again, and dominate.

    Returns
    -------
    LongTransfers
    """
    step, most = times.step, times.most
    points = math.floor(duration / step) + 1
    furthest = min(math.floor(times.longest / step), points - 1)
    # The least cost of all that leave later and arrive by then.
    stair = np.full(points, math.inf)
    room = 256
    departures, arrivals = np.empty(room, np.int32), np.empty(room, np.int32)
    costs = np.empty(room)
    count = 0
    leaves, lands, paid = known
    before = leaves.size
    # From the last departure to the first: a leg is dominated just where one that is known arrives
    # by then for no more, and `cheapest` is the least of them up to each arrival.
    for begin in range(points - 2, -1, -1):
        while before > 0 and leaves[before - 1] >= begin:
            before -= 1
            stair[lands[before]] = min(stair[lands[before]], paid[before])
        if begin * step > times.leave_by:
            continue
        cheapest = most + resolution
        for t in range(begin + 1, min(begin + furthest, points - 1) + 1):
            cheapest = min(cheapest, stair[t])
            below = cheapest - resolution
            departure, arrival = begin * step, t * step
            if relaxed:
                cost = bound_below(pair, thrust, departure, arrival, below)
            else:
                cost = leg_below(pair, thrust, departure, arrival, below, False).split.delta_v
            if cost >= below:
                continue
            if count == departures.size:
                departures, arrivals = wider(departures, count), wider(arrivals, count)
                costs = wider(costs, count)
            departures[count], arrivals[count], costs[count] = begin, t, cost
            cheapest = stair[t] = cost
            count += 1
    return first_to_last(departures, arrivals, costs, count)
