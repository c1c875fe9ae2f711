"""Correction of a leg in the last revolution before its stand-off, at the least ΔV.

Two impulses a revolution apart do not suffice: after a whole revolution, an impulse has moved the
chaser along the track alone, so that no size of it removes an error across the track or in height.
So corrections may be made every 30° of that revolution, the last at the stand-off, on top of the
burns that the leg has there; those of least total size are taken (:mod:`..refine.least`).
Derivatives are those of a zonal field. The corrected end is flown with all forces, and what is left
of the miss corrected again.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from ...kernels.orbits import coast
from ...kernels.orbits.gravity import FIELDS
from ...kernels.orbits.short_periods import Array
from ..refine.least import least_impulses

PLACES = 12
"""Number of equal parts of the revolution, at whose ends a correction may be made."""

MOST_ROUNDS = 12

CLOSE_M, CLOSE_M_S = 0.1, 1e-4
"""Largest miss after a correction, in position [m] and velocity [m/s]."""

Fly = Callable[[Array], Array]


class LastLap(NamedTuple):
    """The last revolution of a leg, as it is flown without a correction.

    Attributes
    ----------
    start : (6,) float64
        State of the chaser at the first time, before the burn there [m, m/s].
    times : (n,) float64
        Of burns and possible corrections, in order [s].
    burns : (n, 3) float64
        Those of the leg; 0 where it has none [m/s].
    end_s : float
        Of the stand-off.
    reached : (6,) float64
        State there, by these burns alone.
    """

    start: Array
    times: Array
    burns: Array
    end_s: float
    reached: Array


class Stretch(NamedTuple):
    """Times [s] between which a leg is corrected, with the states of the chaser at both."""

    begin_s: float
    end_s: float
    start: Array
    reached: Array


def last_lap(span: Stretch, burns: dict[float, Array]) -> LastLap:
    """The last revolution over a span, the burns of the leg by time."""
    start, begin_s, end_s = span.start, span.begin_s, span.end_s
    places = np.linspace(begin_s, end_s, PLACES + 1)
    times = np.array(sorted({*places.tolist(), *burns}))
    made = np.array([burns.get(float(time), np.zeros(3)) for time in times])
    return LastLap(start, times, made, end_s, span.reached)


def correction_m_s(last: LastLap, goal: Array, fly: Fly) -> float | None:
    """ΔV of the least impulses that lead to a goal; None if none are found [m/s].

    Parameters
    ----------
    last : LastLap
    goal : (6,) float64
    fly : callable
        The state at the end with all forces, from all impulses, shape (n, 3).
    """
    impulses = np.zeros_like(last.burns)
    try:
        for number in range(MOST_ROUNDS):
            missing = goal - (fly(last.burns + impulses) if number else last.reached)
            if math.hypot(*missing[:3]) <= CLOSE_M and math.hypot(*missing[3:]) <= CLOSE_M_S:
                return math.fsum(math.hypot(*one) for one in impulses)
            _, matrices, _ = coast.fly(
                last.start, last.times, last.burns + impulses, last.end_s, FIELDS["j4"], True
            )
            effects = matrices[:, :, 3:]
            change = missing + np.einsum("kij,kj->i", effects, impulses)
            impulses = least_impulses(np.ascontiguousarray(effects), change).impulses
            if not bool(np.isfinite(impulses).all()):
                return None
    except ArithmeticError:  # led into the Earth, or away from it
        pass
    return None
