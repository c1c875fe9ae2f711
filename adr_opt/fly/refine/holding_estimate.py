"""ΔV of holding beside a body that an ephemeris moves, estimated and not flown.

A body on its ephemeris is on no trajectory of the field: a chaser let go on a state by SGP4 is some
hundreds of metres off after a revolution. Beside it, impulses lead from each reported position to
the next, :data:`PER_REVOLUTION` times a revolution; the first begins with the reported velocity,
and a last one ends with it. For shorter intervals the sum tends to that of continuous thrust.
"""

from __future__ import annotations

import math

import numpy as np

from ...common.constants import MU_M3_S2
from ...kernels.orbits import coast
from ...kernels.orbits.gravity import FIELDS
from ...kernels.orbits.short_periods import Array
from ...plan.plan import Leg
from ...sources.ephemerides import Ephemerides
from .bodies import Gravity
from .reported import times_of

PER_REVOLUTION = 24
"""Number of impulses in a revolution; with 60 it is 5 % more."""


def holding_m_s(known: Ephemerides, gravity: Gravity, leg: Leg, *, led: bool = False) -> float:
    """ΔV of a leg's wait at its origin and its service at its destination [m/s].

    Parameters
    ----------
    known : Ephemerides
        A body without one takes nothing.
    gravity : {"two-body", "j2", "j3", "j4"}
    leg : Leg
        With burns; where it ends in a tow, the chaser is held until that begins.
    led : bool
        It begins where a tow has led, and is held nowhere.
    """
    start_s, _, docked_s = times_of(leg)
    ready_s = start_s if led else leg.ready_s
    until_s = leg.removal_burns[0].time_s if leg.removal_burns else leg.end_s
    spans = (leg.origin, ready_s, start_s), (leg.destination, docked_s, until_s)
    return math.fsum(
        _beside(known, gravity, name, begin_s, end_s)
        for name, begin_s, end_s in spans
        if name in known.bodies and end_s > begin_s
    )


def _beside(known: Ephemerides, gravity: Gravity, name: str, begin_s: float, end_s: float) -> float:
    ephemeris = known.of(name)
    radius_m = math.hypot(*ephemeris.state(begin_s)[:3])
    step_s = math.tau * math.sqrt(radius_m**3 / MU_M3_S2) / PER_REVOLUTION
    times = np.linspace(begin_s, end_s, max(1, math.ceil((end_s - begin_s) / step_s)) + 1)
    return following_m_s(ephemeris.state(times), times, gravity)


def following_m_s(states: Array, times_s: Array, gravity: Gravity) -> float:
    """ΔV of impulses that lead from position to position [m/s].

    The misses of a few metres are closed to first order.

    Parameters
    ----------
    states : (n, 6) float64
        Reported [m, m/s].
    times_s : (n,) float64
        Theirs, at most a fraction of a revolution apart.
    gravity : {"two-body", "j2", "j3", "j4"}
    """
    total, velocity = 0.0, states[0, 3:]
    for at, span_s in enumerate(np.diff(times_s)):
        now, matrix = states[at].copy(), np.eye(6)
        coast.coast(now, float(span_s), FIELDS[gravity], matrix)
        change = np.linalg.solve(matrix[:3, 3:], states[at + 1, :3] - now[:3])
        total += math.dist(states[at, 3:] + change, velocity)
        velocity = now[3:] + matrix[3:, 3:] @ change
    return total + math.dist(states[-1, 3:], velocity)
