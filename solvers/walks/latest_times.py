"""Latest times at which a chaser can still collect a worth, as guidance for a search.

The best walks of a sweep, read the other way round. A state that is there long before it has to be
has time to spare, and one that is late cannot reach the goal by any plan. So partial plans can be
compared by their time to spare, in whatever they are short of.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from adr_opt.kernels.core.compile import inlined, kernel
from adr_opt.mission.mission import Mission

from .walks import WalkBound

STEPS = 64
"""Number of steps that distinguish worths, unless prizes are multiples of fewer."""

NO_TIME_S = 0.0
"""Latest time where a worth is out of reach: the beginning of time [s]."""


class Latest(NamedTuple):
    """Latest times, for kernels: see :func:`latest_time`.

    Attributes
    ----------
    time : (bodies, slots + 1, steps + 1) float64
        Latest time at which the best walk from a body, by slots of ΔV left, still collects
        a number of steps [s].
    slot : float
        [m/s].
    step : float
        Worth of a step.
    multipliers : (bodies,) float64
        Each target's; 0 for other bodies.
    goal : float
        What a whole plan is to be worth.
    """

    time: np.ndarray
    slot: float
    step: float
    multipliers: np.ndarray
    goal: float


@inlined
def latest_time(latest, body, left, rest):
    """Latest time at which a chaser at a body can still collect a rest, interpolated between slots.

    Parameters
    ----------
    latest : Latest
    body : int
    left : float
        ΔV left [m/s].
    rest : float
        What is still to be collected, less the multipliers of the targets not visited.
    """
    steps = latest.time.shape[2] - 1
    # Rounded down: if the rest can be collected, so can this, so no time is too early.
    n = min(max(int(np.floor(rest / latest.step + 1e-6)), 0), steps)
    slots = max(left, 0.0) / latest.slot
    c = min(int(slots), latest.time.shape[1] - 2)
    share = min(slots - c, 1.0)
    return (1.0 - share) * latest.time[body, c, n] + share * latest.time[body, c + 1, n]


@kernel
def _fill(buckets, best, bits, width, unit, step, last, time):
    """Fill the times: buckets from the last to the first, as values only grow along the way."""
    bodies, slots, steps = time.shape
    for i in range(bodies):
        for c in range(slots):
            n = 0
            for bucket in range(buckets.start[i + 1] - 1, buckets.start[i] - 1, -1):
                value = (best[(bucket + 1) * width + min(c, width - 1)] >> bits) * unit
                while n < steps and value >= n * step - 1e-9:
                    time[i, c, n] = min(buckets.closes[bucket], last)
                    n += 1


def latest_of(bound: WalkBound, mission: Mission, multipliers: np.ndarray, value: float) -> Latest:
    """Latest times from the sweep that a bound has just made.

    Parameters
    ----------
    bound : WalkBound
    mission : Mission
    multipliers : (bodies,) float64
        Those of the sweep.
    value : float
        The bound at them.

    Returns
    -------
    Latest
        With a goal of 0.
    """
    step = mission.prize_step
    if not step or value / step > STEPS or multipliers.any():
        step = max(value, 1e-12) / STEPS
    steps = int(value / step + 1e-9) + 1
    time = np.full((multipliers.size, bound.top + 1, steps + 1), NO_TIME_S)
    _fill(
        bound.buckets,
        bound.values.best[0],
        bound.bits,
        bound.width,
        bound.unit,
        step,
        mission.rules.duration,
        time,
    )
    if time.shape[1] == 1:
        time = np.repeat(time, 2, axis=1)
    return Latest(time, bound.slot, step, np.array(multipliers), 0.0)


def no_latest() -> Latest:
    """Unused latest times, for kernels with such an argument."""
    return Latest(np.zeros((1, 2, 1)), 1.0, 1.0, np.zeros(1), 0.0)
