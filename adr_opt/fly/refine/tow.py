"""Refinement of tows: burns along the true motion; those that lower a perigee are aimed.

The plan's tows are two burns half a revolution apart, or one at an apogee. An osculating orbit is
no ellipse, by kilometres; burns of the same size leave the object as near to its circle. Nothing is
met at the end, so that there is nothing to correct: the next leg begins wherever the tow has led. A
perigee that is lowered is the least radius of the first revolution after it, which a burn aims at;
the chaser aims likewise at its own limit, on its way back.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Protocol

import numpy as np

from ...common.constants import EARTH_RADIUS_M, MU_M3_S2
from ...kernels.orbits.short_periods import Array
from ...plan.plan import Burn
from ...plan.refined_plan import RefinedBurn, RefinedTow
from ...problem.disposal import DisposalPerigee
from ...problem.instance import Instance
from .bodies import Gravity, moved, recorded

PLACES = 144
"""Number of samples of a revolution in the search for the least radius."""

AIMED_STEPS, CLOSE_M = 12, 10.0
"""Maximum number of steps of a burn that aims at a perigee, and how near it comes [m]."""

BACK_SPARE_M = 1e3
"""Height above the limit of altitude to which a chaser returns [m]."""


class HasStates(Protocol):
    """Interface to the states of bodies at any time."""

    gravity: Gravity

    def state(self, name: str, time_s: float) -> Array:
        """Inertial state of a body at a time since the epoch, shape (6,) [m, m/s]."""
        ...


def towed(
    instance: Instance,
    bodies: HasStates,
    name: str,
    planned: Sequence[Burn],
    leaves_s: float = math.inf,
) -> RefinedTow:
    """Tow an object in true dynamics.

    Parameters
    ----------
    instance : Instance
    bodies : HasStates
        With the object.
    name : str
        Of the object.
    planned : sequence of Burn
        The burns of the plan.
    leaves_s : float
        When the next leg leaves, which is the end of the tow up to rounding: no later [s].

    Raises
    ------
    ArithmeticError
        It leads into the Earth, or no burn leads to the perigee.
    """
    now, aims = planned[0].time_s, _perigees(instance, name)
    state, burns = bodies.state(name, now), []
    released = state
    for at, burn in enumerate(planned):
        time_s = min(burn.time_s, leaves_s)
        state, now = moved(state, time_s - now, bodies.gravity), time_s
        impulse = along(burn, state[3:])
        if aims is not None:
            impulse = _aimed(state, impulse, aims[at], bodies.gravity)
        state[3:] += impulse
        if burn.phase == "tow":
            released = state.copy()
        made = tuple(impulse.tolist())
        burns.append(RefinedBurn(time_s=time_s, delta_v_m_s=made, phase=burn.phase))
    return RefinedTow(
        burns=tuple(burns),
        released=recorded("release", now, released),
        planned_delta_v_m_s=None if aims is None else math.fsum(each.size_m_s for each in planned),
    )


def _perigees(instance: Instance, name: str) -> tuple[float, float] | None:
    """Radii of perigee of an object and its chaser where the tow aims at a perigee [m]."""
    target = instance.targets[instance.names.index(name) - instance.first_target]
    disposal = instance.disposal_of(target)
    if not isinstance(disposal, DisposalPerigee):
        return None
    least = EARTH_RADIUS_M + instance.transfer.min_altitude_m + BACK_SPARE_M
    return EARTH_RADIUS_M + disposal.perigee_m, least


def lowest_m(state: Array, gravity: Gravity) -> float:
    """Least radius in the first revolution from a state on [m].

    Raises
    ------
    ArithmeticError
        The orbit is not closed.
    """
    inverse = 2.0 / math.hypot(*state[:3]) - float(state[3:] @ state[3:]) / MU_M3_S2
    if not inverse > 0.0:
        raise ArithmeticError("the burns lead away from the Earth")
    step_s = math.tau / math.sqrt(MU_M3_S2 * inverse**3) / PLACES
    radii = [math.hypot(*state[:3])]
    for _ in range(PLACES):
        state = moved(state, step_s, gravity)
        radii.append(math.hypot(*state[:3]))
    at = int(np.argmin(radii))
    if not 0 < at < PLACES:
        return radii[at]
    # By the parabola through the least radius and its neighbours.
    before, least, after = radii[at - 1 : at + 2]
    return least - (after - before) ** 2 / (8.0 * (before - 2.0 * least + after))


def _aimed(state: Array, planned: Array, perigee_m: float, gravity: Gravity) -> Array:
    """The impulse nearest to a planned one, along the motion, that leads to a perigee, (3,) [m/s].

    By the secant method: the least radius goes up with the speed, where it is not that of now.

    Raises
    ------
    ArithmeticError
        None was found.
    """
    ahead = state[3:] / np.linalg.norm(state[3:])

    def off(speed: float) -> float:
        after = state.copy()
        after[3:] += speed * ahead
        return lowest_m(after, gravity) - perigee_m

    one = float(planned @ ahead)
    if one == 0.0:
        return planned
    other = one + 1.0
    missed, known = off(one), off(other)
    for _ in range(AIMED_STEPS):
        if abs(known) < CLOSE_M:
            return other * ahead
        if known == missed:
            break
        one, other, missed = other, other - known * (other - one) / (known - missed), known
        known = off(other)
    raise ArithmeticError(f"no burn was found that leads to a perigee radius of {perigee_m:.0f} m")


def along(burn: Burn | RefinedBurn, velocity: Array) -> Array:
    """A burn of planned size and sense along a velocity, (3,) [m/s]."""
    size = math.copysign(burn.size_m_s, float(velocity @ np.array(burn.delta_v_m_s)))
    impulse: Array = size * velocity / np.linalg.norm(velocity)
    return impulse
