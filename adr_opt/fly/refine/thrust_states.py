"""States along a refined flight with low thrust."""

from __future__ import annotations

import numpy as np

from ...kernels.orbits import thrusting
from ...kernels.orbits.gravity import FIELDS
from ...kernels.orbits.short_periods import Array
from ...kernels.orbits.thrusting import Push
from ...plan.refined_thrust import RefinedThrust
from .bodies import Gravity


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
