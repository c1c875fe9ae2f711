"""A programme of thrust corrected such that its integrated flight meets the goal."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from ...kernels.orbits.short_periods import Array
from .thrust_search import derivative_of, minimum_norm
from .thrust_task import Integration, Programme, ThrustTask

POSITION_M, SPEED_M_S = 1e-2, 1e-5
"""Tolerances at the goal."""

GOOD_M, GOOD_M_S = 0.2, 2e-4
"""Misses that are good enough if no step makes them smaller."""

MOST_STEPS, MOST_DERIVATIVES = 30, 6
"""Maximum numbers of steps, and of derivatives by differences of integrated flights."""

STEP_M_S, LEAST_STEP_M_S = 0.02, 1e-3
"""First and last step of those differences."""


class _Flight(NamedTuple):
    """A programme with its integrated flight and what that misses by."""

    programme: Programme
    flown: Integration
    off: Array


def closed(task: ThrustTask, programme: Programme) -> Programme | None:
    """A programme near a predicted one whose integrated flight meets the goal; None if none does.

    Newton's steps of least change, with the derivative of the prediction, improved by what each
    flight shows (C. G. Broyden, Mathematics of Computation 19, 1965, 577), or taken anew of
    integrated flights where a step does not help.
    """
    mean = task.predict(programme).mean
    turned = float(mean[4] + mean[5] - task.origin[4] - task.origin[5])

    def fly(one: Programme) -> _Flight:
        flown = task.integrate(one)
        return _Flight(one, flown, task.off_integrated(flown, turned))

    now = fly(programme)
    slope = derivative_of(task, programme, task.laps_to(mean))
    step_m_s, anew = STEP_M_S, 0
    for _ in range(MOST_STEPS):
        if _within(task, now.flown, POSITION_M, SPEED_M_S):
            return now.programme
        change = minimum_norm(slope, -now.off)
        tried = fly(now.programme.steered_by(now.programme.steered + change))
        before, after = float(np.linalg.norm(now.off)), float(np.linalg.norm(tried.off))
        if after < before:
            wrong = tried.off - now.off - slope @ change
            slope = slope + np.outer(wrong, change) / float(change @ change)
            now = tried
        if after < 0.5 * before:
            continue
        if anew == MOST_DERIVATIVES or not math.isfinite(before):
            break
        anew += 1
        slope = np.empty((6, 10))
        for column in range(10):
            side = np.zeros(10)
            side[column] = step_m_s
            steered = now.programme.steered
            above, below = (
                fly(now.programme.steered_by(steered + each)).off for each in (side, -side)
            )
            slope[:, column] = (above - below) / (2.0 * step_m_s)
        step_m_s = max(0.5 * step_m_s, LEAST_STEP_M_S)
    return now.programme if _within(task, now.flown, GOOD_M, GOOD_M_S) else None


def _within(task: ThrustTask, flown: Integration, most_m: float, most_m_s: float) -> bool:
    apart = flown.end - task.goal
    return math.hypot(*apart[:3]) < most_m and math.hypot(*apart[3:]) < most_m_s
