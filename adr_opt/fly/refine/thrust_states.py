"""States along a refined leg of low thrust."""

from __future__ import annotations

import numpy as np

from ...kernels.orbits import thrusting
from ...kernels.orbits.gravity import FIELDS
from ...kernels.orbits.thrusting import Push
from ...plan.refined_plan import RefinedLeg
from .bodies import Gravity
from .short_periods import Array
from .states import state_of


def thrust_states(leg: RefinedLeg, times_s: Array, gravity: Gravity) -> Array:
    """States of the chaser between its departure and its stand-off, shape (times, 6) [m, m/s].

    Parameters
    ----------
    leg : RefinedLeg
        With thrust.
    times_s : (times,) float64
        In order.
    gravity : {"two-body", "j2", "j3", "j4"}
    """
    assert leg.thrust is not None
    windows = [
        (start, end, float(number))
        for number, arc in enumerate(leg.thrust.arcs)
        for start, end in arc.windows_s
    ]
    laws = np.array([arc.steering for arc in leg.thrust.arcs])
    push = Push(leg.thrust.force_n, leg.thrust.exhaust_m_s, leg.thrust.mass_kg, 0.0)
    now = thrusting.elements_of(state_of(leg.states[0]), leg.states[0].time_s)
    found: Array = thrusting.follow(
        now, times_s, np.array(windows).reshape(-1, 3), laws, push, FIELDS[gravity]
    )
    return found
