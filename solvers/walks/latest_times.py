"""Latest times at which a chaser can still collect a required worth, for kernels."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from adr_opt.kernels.core.compile import inlined


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
