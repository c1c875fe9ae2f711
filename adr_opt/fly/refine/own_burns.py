"""The plan's own burns in true dynamics: at their times, and close to their planned values.

A leg of four burns leaves six numbers free. Of all burns at the plan's times that meet the goal
those are flown for which

    Σ |u_k| + w Σ |u_k − p_k|

is least, u_k being flown and p_k the plan's: their ΔV, and a share w of what they are changed by.
With w ≥ 1 a burn is changed for no other reason than to meet the goal, since |p| ≤ |u| + |u − p|;
with w = 0 the burns would share the turn of the plane, which is no longer what was planned. The
changes are taken at their length and not squared, so that most of them are made by one burn or two,
there where they cost least.

Each convex step is a problem of :mod:`.least`: u_k and w·(u_k − p_k) are its vectors, and that they
differ by p_k are three of its equations.
"""

from __future__ import annotations

import numpy as np

from ...kernels.orbits.short_periods import Array
from .least import least_impulses
from .leg import MOST_CONVEX, WORTH, FlownImpulses, LegEnds, NoWay, close, fly

CHANGE_WEIGHT = 2.0 / 3.0
"""w, chosen so that flown burns stay close to the planned ones, for circles and ellipses."""


def cheapest_near(
    course: LegEnds, flown: FlownImpulses, planned: Array, weight: float = CHANGE_WEIGHT
) -> FlownImpulses:
    """Make burns that meet the goal cheap, while keeping them close to the plan's.

    Parameters
    ----------
    course : LegEnds
    flown : FlownImpulses
        Burns that meet the goal, at the times that are kept.
    planned : (burns, 3) float64
        What the plan burns at these times; zero where it has no burn [m/s].
    weight : float
        w.
    """
    low, high = flown.reach_m
    limits = min(course.lowest_m, low), max(course.highest_m, high)
    worth = _worth(flown.impulses, planned, weight)
    share = 1.0
    for _ in range(MOST_CONVEX):
        now = fly(course, flown.times, flown.impulses)
        wanted = np.einsum("kij,kj->i", now.effects, now.impulses) - now.miss
        step = _least(now.effects, wanted, planned, weight) - now.impulses
        before = worth
        while share > 0.02:
            tried = _tried(course, limits, flown.times, now.impulses + share * step)
            if tried is not None and _worth(tried.impulses, planned, weight) < worth:
                flown, worth = tried, _worth(tried.impulses, planned, weight)
                share = min(1.0, 2.0 * share)
                break
            share *= 0.5
        if before - worth <= WORTH * before:
            break
    return flown


def _worth(impulses: Array, planned: Array, weight: float) -> float:
    """The function to be minimised [m/s]."""
    sizes, changes = (np.sqrt(np.sum(of**2, axis=1)).sum() for of in (impulses, impulses - planned))
    return float(sizes + weight * changes)


def _tried(
    course: LegEnds, limits: tuple[float, float], times: Array, impulses: Array
) -> FlownImpulses | None:
    """Closed burns; None if that fails or leaves the altitude limits."""
    try:
        found = close(course, times, impulses)
    except NoWay:
        return None
    low, high = found.reach_m
    return found if limits[0] <= low and high <= limits[1] else None


def _least(effects: Array, wanted: Array, planned: Array, weight: float) -> Array:
    """Optimal burns of the linearised problem."""
    own = np.flatnonzero(np.any(planned != 0.0, axis=1))
    count, equations, _ = effects.shape
    wide = np.zeros((count + own.size, equations + 3 * own.size, 3))
    wide[:count, :equations] = effects
    # A burn that the plan has not is a change as a whole.
    scale = np.full(count, 1.0 + weight)
    scale[own] = 1.0
    wide[:count] /= scale[:, None, None]
    for number, at in enumerate(own):
        rows = slice(equations + 3 * number, equations + 3 * number + 3)
        wide[at, rows] = np.eye(3)
        wide[count + number, rows] = -np.eye(3) / weight
    found = least_impulses(wide, np.r_[wanted, planned[own].ravel()])
    impulses: Array = found.impulses[:count] / scale[:, None]
    return impulses
