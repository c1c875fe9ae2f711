"""Departure events of short transfers between drifting planes, and times of all transfers."""

import math
from typing import NamedTuple

import numpy as np

from ..core.compile import inlined, kernel
from . import precession


class Times(NamedTuple):
    """Departure times of transfers and limits on their duration.

    Attributes
    ----------
    interval : float
        Between departure events of a pair, at least [s].
    step, longest : float
        Of the grid of long transfers, and the longest of them, 0 for none [s].
    most : float
        Largest useful ΔV of a transfer [m/s].
    leave_by : float
        No transfer leaves later [s].
    """

    interval: float
    step: float
    longest: float
    most: float
    leave_by: float = math.inf


@kernel
def events_of(pair, since, duration, spacing):
    """Departure events from a time until the end of a mission, at least a spacing apart [s].

    Returns
    -------
    half_turns : (events,) int64
    numbers : (events, 5) float64
        The other fields of :class:`.precession.Event`.
    """
    steps = max(1, math.ceil(spacing * pair.rate_i / math.pi - 1e-9))
    length = max(duration - since, 0.0)
    fastest = pair.rate_i + max(pair.acceleration_i, 0.0) * max(duration, 0.0)
    most = int(length * fastest / math.pi / steps) + 3
    half_turns, numbers = np.empty(most, np.int64), np.empty((most, 5))
    event = precession.first_event(pair, since)
    count, after = 0, steps * math.pi / pair.rate_i
    while event.time <= duration and count < most:
        half_turns[count] = event.half_turns
        numbers[count, 0], numbers[count, 1] = event.time, event.lag
        numbers[count, 2], numbers[count, 3] = event.alpha_i, event.alpha_j
        numbers[count, 4] = event.theta
        count += 1
        later = precession.later_event(pair, event, steps, after)
        event, after = later, later.time - event.time
    return half_turns[:count], numbers[:count]


@inlined
def listed_at(event, departure):
    """Latest ready time of a chaser whose departure is listed near an event [s]."""
    steps = math.floor((departure - event + precession.ROUNDING_S) / precession.STEP_S)
    return min(departure, event + steps * precession.STEP_S)


@inlined
def least_speed(pair, rule):
    """Lower bound on speed at the turn, which costs at least that times the sine [m/s]."""
    slowest = (
        (1.0 - 1e-9)
        * pair.speed_i
        * math.sqrt(
            2.0
            * pair.radius_i
            * pair.radius_i
            / (rule.max_radius * (pair.radius_i + rule.max_radius))
        )
    )
    return slowest if pair.free_speed == 0.0 else min(slowest, pair.free_speed)
