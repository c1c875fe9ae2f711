"""Osculating states: as in refined plans, and as arrays."""

from __future__ import annotations

import numpy as np

from ...kernels.orbits.short_periods import Array
from ...plan.refined_plan import BodyState, RefinedState


def recorded(event: str, time_s: float, state: Array) -> RefinedState:
    """A state of shape (6,) at an event, in the form of refined plans."""
    values = state.tolist()
    return RefinedState.model_validate(
        {
            "event": event,
            "time_s": float(time_s),
            "position_m": tuple(values[:3]),
            "velocity_m_s": tuple(values[3:]),
        }
    )


def state_of(known: RefinedState | BodyState) -> Array:
    """A state as an array, shape (6,) [m, m/s]."""
    return np.array([*known.position_m, *known.velocity_m_s])
