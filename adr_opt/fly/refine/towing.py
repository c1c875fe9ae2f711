"""Tows in true dynamics: two burns against the motion, with the plan's size and times.

The plan's burns are those between circles, of which the first is half a revolution before the
second. An osculating orbit is no circle, by kilometres; burns of the same size leave the object on
an orbit as near to one. Nothing is met at its end, so that there is nothing to correct: the next
leg begins wherever the tow has led.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Protocol

import numpy as np

from ...kernels.orbits.short_periods import Array
from ...plan.plan import Burn
from ...plan.refined_plan import RefinedBurn, RefinedTow
from .bodies import Gravity, moved, recorded


class HasStates(Protocol):
    """Where bodies are at any time."""

    gravity: Gravity

    def state(self, name: str, time_s: float) -> Array:
        """Inertial state of a body at a time since the epoch, shape (6,) [m, m/s]."""
        ...


def towed(
    bodies: HasStates, name: str, planned: Sequence[Burn], leaves_s: float = math.inf
) -> RefinedTow:
    """Tow an object in true dynamics.

    Parameters
    ----------
    bodies : HasStates
        With the object.
    name : str
        Of the object.
    planned : sequence of Burn
        The two burns of the plan.
    leaves_s : float
        When the next leg leaves, which is the end of the tow up to rounding: no later [s].

    Raises
    ------
    ArithmeticError
        It leads into the Earth.
    """
    now = planned[0].time_s
    state, burns = bodies.state(name, now), []
    for burn in planned:
        time_s = min(burn.time_s, leaves_s)
        state, now = moved(state, time_s - now, bodies.gravity), time_s
        impulse = -burn.size_m_s * state[3:] / np.linalg.norm(state[3:])
        state[3:] += impulse
        made = tuple(impulse.tolist())
        burns.append(RefinedBurn(time_s=time_s, delta_v_m_s=made, phase="tow"))
    return RefinedTow(burns=tuple(burns), released=recorded("release", now, state))
