"""Flown thrust in the form of refined plans: arcs with laws and windows, and states along them."""

from __future__ import annotations

import math

import numpy as np

from ...kernels.orbits import thrusting
from ...kernels.orbits.gravity import FIELDS
from ...kernels.orbits.short_periods import Array
from ...kernels.orbits.thrusting import Push
from ...plan.refined_thrust import RefinedThrust, SteeredArc
from .bodies import Gravity


def steered_arcs(push: Push, laws: Array, windows: Array) -> tuple[SteeredArc, ...]:
    """Arcs of thrust with the ΔV of each.

    Parameters
    ----------
    push : Push
        At the beginning of the first one.
    laws : (arcs, 5) float64
    windows : (windows, 3) float64
        Beginning [s], end [s] and arc of each window, as :func:`.thrusting.fly` writes them.
    """
    arcs, mass = [], push.mass
    for number, law in enumerate(laws):
        mine = windows[windows[:, 2] == number, :2]
        after = mass - push.force / push.exhaust * float(np.diff(mine, axis=1).sum())
        arcs.append(
            SteeredArc(
                delta_v_m_s=push.exhaust * math.log(mass / after),
                steering=tuple(law.tolist()),
                windows_s=tuple((float(start), float(end)) for start, end in mine),
            )
        )
        mass = after
    return tuple(arcs)


def thrust_states(
    thrust: RefinedThrust, begin: Array, begin_s: float, times_s: Array, gravity: Gravity
) -> Array:
    """States of a flight with low thrust, shape (times, 6) [m, m/s].

    Parameters
    ----------
    thrust : RefinedThrust
    begin : (6,) float64
        State before it [m, m/s].
    begin_s : float
        Its time [s].
    times_s : (times,) float64
        In order, none before that.
    gravity : {"two-body", "j2", "j3", "j4"}
    """
    windows = [
        (start, end, float(number))
        for number, arc in enumerate(thrust.arcs)
        for start, end in arc.windows_s
    ]
    laws = np.array([arc.steering for arc in thrust.arcs])
    push = Push(thrust.force_n, thrust.exhaust_m_s, thrust.mass_kg, 0.0)
    now = thrusting.elements_of(begin, begin_s)
    found: Array = thrusting.follow(
        now, times_s, np.array(windows).reshape(-1, 3), laws, push, FIELDS[gravity]
    )
    return found
