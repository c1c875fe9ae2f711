"""A leg on true, eccentric orbits: its miss, and the cost of correcting it."""

from __future__ import annotations

import math

import numpy as np

from ...plan.plan import Leg
from .result import EccentricFlight
from .two_body import State, TwoBody, distance

PARTS = 16
"""Number of times along the last arc at which a correction is tried."""


def fly_eccentric(
    two_body: TwoBody, origin: State, destination: State, leg: Leg, standoff_m: float
) -> EccentricFlight:
    """Fly a leg on the true orbits of its bodies, and solve for a last arc that reaches the goal.

    Parameters
    ----------
    two_body : TwoBody
    origin, destination : (position, velocity)
        States of the bodies at the epoch, on their true orbits.
    leg : Leg
        Its burns are flown as they are.
    standoff_m : float
        L, along the destination's orbit [m].
    """
    approach = next(i for i, burn in enumerate(leg.burns) if burn.phase == "approach")
    before = leg.burns[:approach]
    # The last arc is the terminal one; a plan may have been tampered with, so it is looked for.
    first = next((i for i, burn in enumerate(before) if burn.phase == "terminal"), approach)
    last_arc_delta_v = sum(math.hypot(*burn.delta_v_m_s) for burn in before[first:])
    arrival = leg.burns[approach].time_s

    miss = speed = whole = least = when = None
    try:
        now = leg.burns[0].time_s
        chaser = two_body.coast(origin, now)
        begin = None
        for number, burn in enumerate(before):
            position, velocity = two_body.coast(chaser, burn.time_s - now)
            now = burn.time_s
            if number == first:
                begin = now, (position, velocity)
            chaser = position, velocity + np.array(burn.delta_v_m_s)
        chaser = two_body.coast(chaser, arrival - now)
        goal = _behind(two_body, destination, arrival, standoff_m)
        miss, speed = distance(chaser[0], goal[0]), distance(chaser[1], goal[1])
        if begin is not None:
            burned = np.array(before[first].delta_v_m_s)
            costs = _corrections(two_body, *begin, burned, goal, arrival)
            whole = costs.get(begin[0])
            if costs:
                when = min(costs, key=costs.__getitem__)
                least = costs[when] - last_arc_delta_v
    except ArithmeticError:
        pass  # what is known by then is told, the rest is None
    return EccentricFlight(
        true_miss_m=miss,
        true_relative_speed_m_s=speed,
        last_arc_delta_v_m_s=last_arc_delta_v,
        lambert_delta_v_m_s=whole,
        correction_delta_v_m_s=least,
        correction_time_s=when,
        eccentricity_delta_v_m_s=leg.eccentricity_delta_v_m_s,
    )


def _corrections(
    two_body: TwoBody, begin: float, state: State, planned: np.ndarray, goal: State, arrival: float
) -> dict[float, float]:
    """ΔV of the last arc by the time at which a Lambert arc begins: time [s] → [m/s].

    At the beginning it replaces the planned burn, later it follows upon it.
    """
    normal = np.cross(*goal)
    costs = {}
    for part in range(PARTS):
        time = begin + (arrival - begin) * part / PARTS
        try:
            position, velocity, spent = *state, 0.0
            if part > 0:
                spent = math.hypot(*planned)
                position, velocity = two_body.coast((position, velocity + planned), time - begin)
            leaving, arriving = two_body.lambert(position, goal[0], arrival - time, normal)
        except ArithmeticError:
            continue
        costs[time] = spent + distance(leaving, velocity) + distance(goal[1], arriving)
    return costs


def _behind(two_body: TwoBody, body: State, time: float, length: float) -> State:
    """The point that follows a body on its orbit, delayed by the time to travel L."""
    speed = math.hypot(*two_body.coast(body, time)[1])
    return two_body.coast(body, time - length / speed)
