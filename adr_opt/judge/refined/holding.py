"""ΔV of station-keeping beside bodies on ephemerides, recomputed by the judge.

What a body does besides moving freely is the second difference of its reported positions, less that
of free motion from its reported state. The difference between its velocity and the derivative of
its position cancels in it.
"""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np
import numpy.typing as npt

from ...plan.refined_plan import RefinedLeg
from .as_reported import ReportedStates

Array = npt.NDArray[np.float64]
Coast = Callable[[Array, float, float], Array]

APART_S = 120.0
"""Time between the positions of a difference [s]."""

MOST_PLACES = 200
"""Maximum number of samples of a stay."""

LEAST_SHARE, SPARE_M_S = 0.8, 0.1
"""Tolerance on a stated figure: least share of the recomputed ΔV, and further shortfall [m/s]."""


def found_m_s(reported: ReportedStates, coast: Coast, leg: RefinedLeg) -> float:
    """ΔV of station-keeping by continuous thrust during the wait and service of a leg [m/s].

    An object that is towed is held beside until the tow begins.

    Parameters
    ----------
    reported : ReportedStates
    coast : callable
        States as columns, begin and end [s] → states at the end.
    leg : RefinedLeg
    """
    start_s, total = leg.states[0].time_s, 0.0
    for name, begin_s, end_s in (
        (leg.origin, leg.ready_s, start_s),
        (leg.destination, leg.arrival_s, leg.end_s if leg.tow is None else leg.tow.start_s),
    ):
        # Differences stay within the time: an ephemeris may end with it.
        within_s = end_s - begin_s - 2.0 * APART_S
        if name in reported.bodies and within_s > 0.0:
            count = min(math.ceil(within_s / (2.0 * APART_S)), MOST_PLACES) + 1
            times = np.linspace(begin_s + APART_S, end_s - APART_S, count)
            total += _mean_m_s2(reported, coast, name, times) * (end_s - begin_s)
    return total


def _mean_m_s2(reported: ReportedStates, coast: Coast, name: str, times: Array) -> float:
    """Mean acceleration of a body beyond that of the gravity field [m/s²]."""
    now = reported.states(name, times).T
    off = np.zeros((3, times.size))
    for apart_s in (-APART_S, APART_S):
        there = reported.states(name, times + apart_s).T
        off += there[:3] - coast(now, 0.0, apart_s)[:3]
    return float(np.sqrt(np.sum(off**2, axis=0)).mean()) / APART_S**2
