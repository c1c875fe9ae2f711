"""Short transfers between drifting planes (docs/model.md section 2, under J2).

The co-elliptic sequence of :mod:`.co_elliptic` with the rates of each arc. The turn goes into the
plane that the remaining arcs carry onto the target's plane on arrival. So the line of nodes is that
of planes whose RAANs differ by

    δ = Ω_j(t_d) − Ω_i(t_d) + ε,    ε = Ω̇_j T − Σ over the arcs flown of the shifts of their nodes,

which depends a little on the sequence that is flown, and so do the time of departure and that of
arrival: the chaser is at the line when it leaves, and the target when it is met. Both follow by
fixed point, with a contraction of some thousandths but where planes nearly coincide.

*Events* are counted by half turns: number h is the one at which the chaser would be at the line of
nodes if ε were 0. The sequences of an event leave within seconds of it. Without J2 ε is 0, and all
is as in :mod:`.co_elliptic`.
"""

import math
from typing import NamedTuple

from ...common.constants import SLACK_S, TURN_RAD
from ..core.compile import inlined, kernel
from ..orbits import ephemeris
from . import co_elliptic

MOST_STEPS = 8
"""Maximum number of fixed-point steps; where planes nearly coincide this may not suffice, and the
sequence is omitted."""

CLOSE_S = 1e-6
"""Step below which a fixed point is accepted; the next step would be far smaller [s]."""

STEP_S = 16.0
"""Departures are rounded down to whole steps of this after their event [s]."""

ROUNDING_S = 1e-3
"""Distance before a step at which a departure counts as on it [s]."""

BRACKETS = 8
"""Number of brackets per step in the search for a departure."""

STEP_RAD = 1e-6
"""Difference of RAAN by which the motion of the line of nodes is sampled [rad]."""


class Event(NamedTuple):
    """A departure event.

    Attributes
    ----------
    half_turns : int
    time : float
        When the chaser would leave if ε were 0 [s].
    lag : float
        δ then [rad].
    alpha_i, alpha_j : float
        Arguments of latitude of the line of nodes in the two planes [rad].
    theta : float
        Angle between the planes [rad].
    """

    half_turns: int
    time: float
    lag: float
    alpha_i: float
    alpha_j: float
    theta: float


@inlined
def near(angle, other):
    """An angle reduced by whole turns to be nearest to another."""
    return angle - TURN_RAD * math.floor((angle - other) / TURN_RAD + 0.5)


@kernel
def carried(pair, rule, revolutions, r, time):
    """ε of the sequence with k revolutions at a phasing radius, which takes a time [rad]."""
    rc = r + rule.first_leg_fraction * (pair.radius_j - r)
    a1, a2, a3 = 0.5 * (pair.radius_i + r), 0.5 * (r + rc), 0.5 * (rc + pair.radius_j)
    arcs = 1.0 / (a2 * a2 + pair.widening_j) + 1.0 / (a3 * a3 + pair.widening_j)
    arcs += 2.0 * revolutions / (r * r + pair.widening_j)
    first = pair.shift_i / (a1 * a1 + pair.widening_i)
    return pair.node_rate_j * time - pair.shift_j * arcs - first


@inlined
def line(pair, lag):
    """Arguments of latitude of the line of nodes in both planes, and the angle between them."""
    return ephemeris.relative_node(pair.inclination_i, 0.0, pair.inclination_j, lag)


@kernel
def event_at(pair, half_turns, time, alpha_i, alpha_j):
    """The event at a number of half turns.

    Parameters
    ----------
    pair : Pair
    half_turns : int
    time, alpha_i, alpha_j : float
        About when it is, and about where the line of nodes is in the two planes.

    Returns
    -------
    Event
    """
    lag, theta = 0.0, 0.0
    for _ in range(MOST_STEPS):
        lag = pair.lag + pair.lag_rate * time
        found_i, found_j, theta = line(pair, lag)
        alpha_i, alpha_j = near(found_i, alpha_i), near(found_j, alpha_j)
        before = time
        time = co_elliptic.time_at(
            pair.latitude_i, pair.rate_i, pair.acceleration_i, alpha_i + math.pi * half_turns
        )
        if abs(time - before) < CLOSE_S:
            break
    return Event(half_turns, time, lag, alpha_i, alpha_j, theta)


@inlined
def turning(pair, lag, alpha_i, alpha_j):
    """Change of the arguments of latitude of the line of nodes with δ."""
    moved_i, moved_j, _ = line(pair, lag + STEP_RAD)
    return (near(moved_i, alpha_i) - alpha_i) / STEP_RAD, (
        near(moved_j, alpha_j) - alpha_j
    ) / STEP_RAD


@kernel
def first_event(pair, since):
    """The first event at or after a time, up to the slack [s]."""
    alpha_i, alpha_j, _ = line(pair, pair.lag + pair.lag_rate * since)
    latitude = co_elliptic.latitude_of_i(pair, since)
    half_turns = math.ceil((latitude - alpha_i) / math.pi - 1e-9) - 1
    event = event_at(pair, half_turns, since, alpha_i, alpha_j)
    while event.time < since - SLACK_S:
        half_turns += 1
        event = event_at(pair, half_turns, event.time, event.alpha_i, event.alpha_j)
    return event


@kernel
def later_event(pair, event, steps, after):
    """The event a number of half turns, and roughly a number of seconds, after another."""
    return event_at(
        pair, event.half_turns + steps, event.time + after, event.alpha_i, event.alpha_j
    )


@inlined
def meeting(pair, rule, half_turns, alpha_j, time):
    """Time at which the target allows arrival at the stand-off, nearest to a given time [s]."""
    latitude = alpha_j + math.pi * (half_turns + 1) + rule.standoff / pair.radius_j
    behind = latitude - pair.latitude_j - pair.rate_j * time
    if pair.acceleration_j == 0.0:
        return time + (behind - TURN_RAD * math.floor(behind / TURN_RAD + 0.5)) / pair.rate_j
    behind -= 0.5 * pair.acceleration_j * time * time
    turns = TURN_RAD * math.floor(behind / TURN_RAD + 0.5)
    return co_elliptic.time_at(pair.latitude_j, pair.rate_j, pair.acceleration_j, latitude - turns)


class FixedPoint(NamedTuple):
    """A sequence: departure and stand-off times [s], r_x [m], 4 sin²(θ/2) and ΔV [m/s].

    ΔV is +inf where there is none; ``steps`` is how many it took to find it.
    """

    departure: float
    stand_off: float
    radius: float
    turn: float
    delta_v: float
    steps: int


@kernel
def fixed_point(pair, rule, half_turns, revolutions, departure, stand_off, alpha_i, alpha_j):
    """The sequence of an event with k revolutions near a given arrival, solved exactly.

    Parameters
    ----------
    pair : Pair
    rule : TransferRule
    half_turns, revolutions : int
    departure, stand_off, alpha_i, alpha_j : float
        Where to begin from.

    Returns
    -------
    FixedPoint
    """
    r, theta = pair.reference, 0.0
    steps = MOST_STEPS + 1
    # A contraction by the ratio of node rates to mean motions, some thousandths, over sin θ: the
    # error after a step is less than the step. Where planes nearly coincide it may not converge.
    for number in range(MOST_STEPS):
        time = stand_off - departure
        r = co_elliptic.phasing_radius(pair, rule, revolutions, time)
        lag = pair.lag + pair.lag_rate * departure + carried(pair, rule, revolutions, r, time)
        found_i, found_j, theta = line(pair, lag)
        alpha_i, alpha_j = near(found_i, alpha_i), near(found_j, alpha_j)
        left = co_elliptic.time_at(
            pair.latitude_i, pair.rate_i, pair.acceleration_i, alpha_i + math.pi * half_turns
        )
        met = meeting(pair, rule, half_turns, alpha_j, stand_off)
        step = abs(left - departure) + abs(met - stand_off)
        departure, stand_off = left, met
        if step < CLOSE_S:
            steps = number + 1
            break
    turn = 4.0 * math.sin(0.5 * theta) ** 2
    time = stand_off - departure
    low = pair.shortest + revolutions * pair.shortest_lap
    high = pair.longest + revolutions * pair.longest_lap
    if steps > MOST_STEPS or not low <= time <= high:
        return FixedPoint(departure, stand_off, r, turn, math.inf, steps)
    return FixedPoint(
        departure,
        stand_off,
        r,
        turn,
        co_elliptic.leg_delta_v(pair, rule, revolutions, r, departure, time, turn),
        steps,
    )


@inlined
def _past_line(pair, rule, revolutions, departure, stand_off):
    """Delay of a sequence's departure after the nearest crossing of its line of nodes [s].

    Returns
    -------
    past : float
        [s].
    half_turns : int
        Number of that crossing.
    alpha_j : float
        Argument of latitude of the line in the target's plane [rad].
    """
    time = stand_off - departure
    r = co_elliptic.phasing_radius(pair, rule, revolutions, time)
    lag = pair.lag + pair.lag_rate * departure + carried(pair, rule, revolutions, r, time)
    alpha_i, alpha_j, _ = line(pair, lag)
    turned = co_elliptic.latitude_of_i(pair, departure) - alpha_i
    half_turns = math.floor(turned / math.pi + 0.5)
    return (turned - math.pi * half_turns) / pair.rate_i, half_turns, alpha_j


@kernel
def leaving(pair, rule, revolutions, ready, stand_off):
    """Departure of a sequence with a given arrival: the first crossing of its line once ready.

    By the secant method, or where that does not lead there, by bisection.

    Parameters
    ----------
    pair : Pair
    rule : TransferRule
    revolutions : int
        k.
    ready : float
        The chaser leaves then or within a step of departures [s].
    stand_off : float
        Arrival at the stand-off [s].

    Returns
    -------
    float
        [s]; not a number if there is none.
    """
    width = (STEP_S + 2.0 * ROUNDING_S) / BRACKETS
    for bracket in range(-1, BRACKETS):
        low = ready - ROUNDING_S + bracket * width
        high = low + width
        if bracket < 0:
            # Mostly the line moves at an even rate, and the way back to it is soon gone.
            departure, before, past_before = ready, ready, 0.0
            past, half_turns, alpha_j = _past_line(pair, rule, revolutions, ready, stand_off)
            for step in range(MOST_STEPS):
                grown = past - past_before
                steep = 1.0 if step == 0 or grown == 0.0 else (departure - before) / grown
                before, past_before = departure, past
                departure -= past * steep
                if abs(past) < CLOSE_S:
                    break
                past, half_turns, alpha_j = _past_line(
                    pair, rule, revolutions, departure, stand_off
                )
            if not ready - ROUNDING_S <= departure <= ready + STEP_S + ROUNDING_S:
                continue
        else:
            past_low = _past_line(pair, rule, revolutions, low, stand_off)[0]
            past_high = _past_line(pair, rule, revolutions, high, stand_off)[0]
            # From half a revolution after one crossing to as much before the next is a leap.
            if past_low * past_high > 0.0 or abs(past_high - past_low) * pair.rate_i > 1.0:
                continue
            departure = 0.5 * (low + high)
            while high - low > CLOSE_S * CLOSE_S and low < departure < high:
                past = _past_line(pair, rule, revolutions, departure, stand_off)[0]
                if past * past_low > 0.0:
                    low = departure
                else:
                    high = departure
                departure = 0.5 * (low + high)
            past, half_turns, alpha_j = _past_line(pair, rule, revolutions, departure, stand_off)
        met = meeting(pair, rule, half_turns, alpha_j, stand_off)
        if abs(met - stand_off) < ROUNDING_S and abs(past) < CLOSE_S:
            return departure
    return math.nan
