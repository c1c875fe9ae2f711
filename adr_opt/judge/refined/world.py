"""Free motion in the gravity field of a refined plan, and states of its bodies.

The pull is written once more, and :mod:`.propagation` integrates the change of elements by an
explicit method, where the refinement integrates positions by an implicit one. Bodies are propagated
from the states at the epoch that the file states, if these are those of their orbits. Of a plan
that was refined onto ephemerides, bodies are where :mod:`.as_reported` reads that they are.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from ...common.constants import EARTH_RADIUS_M, J2, MU_M3_S2, OBLATENESS_M2
from ...kernels.orbits import elements
from ...kernels.orbits.gravity import J3, J4
from ...kernels.orbits.short_periods import osculating
from ...plan.refined_plan import RefinedLeg, RefinedPlan, RefinedTow
from ...problem.instance import Instance
from ..check.violation import Violation
from .as_reported import ReportedStates
from .propagation import advance, elements_of, state_of
from .thrust import Course, ThrustFlown, fly_thrust

Array = npt.NDArray[np.float64]

SAME_M, SAME_M_S = 10.0, 1e-2
"""Tolerances of states [m], [m/s]."""

KEPT_UP_M, KEPT_UP_M_S = 5e3, 5.0
"""The same of states at the epoch where harmonics act: the size of an orbit is corrected such that
the body keeps up with its mean elements, and so is its place."""


def check_bodies(
    instance: Instance, refined: RefinedPlan, reported: ReportedStates | None
) -> Iterator[Violation]:
    """Check each body's state at the epoch against the instance or its ephemeris.

    Parameters
    ----------
    reported : ReportedStates or None
        Of a plan that was refined onto ephemerides.
    """
    orbits = dict(zip(instance.names, instance.body_orbits, strict=True))
    gravity = refined.gravity
    two_body = gravity == "two-body"
    limit = (SAME_M, SAME_M_S) if two_body else (KEPT_UP_M, KEPT_UP_M_S)
    for body in refined.bodies:
        if body.name not in orbits:
            yield Violation(None, "body", f"{body.name!r} is not a body of the instance")
            continue
        stated = np.array([*body.position_m, *body.velocity_m_s])
        if reported is not None and body.name in reported.bodies:
            true, most = reported.state(body.name, 0.0), (SAME_M, SAME_M_S)
        elif instance.decay_of(body.name):
            yield Violation(
                None,
                "body",
                f"the orbit of {body.name!r} decays, and the plan is not refined onto ephemerides",
            )
            continue
        else:
            row = np.array(orbits[body.name].row(0.0 if two_body else OBLATENESS_M2))
            true, most = osculating(*elements.equinoctial_at(row, 0.0), FIELDS[gravity]), limit
        off, fast = math.dist(stated[:3], true[:3]), math.dist(stated[3:], true[3:])
        if not (off <= most[0] and fast <= most[1]):
            yield Violation(
                None,
                "body",
                f"{body.name!r} is {off:.3g} m and {fast:.3g} m/s off its place at the epoch",
            )


STEPS = 72
"""Steps per revolution at the lowest perigee: enough for agreement with the collocation within some
centimetres after two years; more do not help."""

FIELDS = {
    "two-body": np.array([0.0, 0.0, 0.0]),
    "j2": np.array([J2, 0.0, 0.0]),
    "j3": np.array([J2, J3, 0.0]),
    "j4": np.array([J2, J3, J4]),
}
MIRROR = np.array([1.0, -1.0, 1.0, 1.0, -1.0, 1.0])
"""Reflection that leaves zonal fields unchanged and makes retrograde orbits prograde."""


class FreeMotion:
    """Free motion of many states at once, as columns of shape (6, n) [m, m/s].

    Parameters
    ----------
    gravity : {"two-body", "j2", "j3", "j4"}
    steps : int
        In a revolution at the lowest perigee.
    """

    def __init__(self, gravity: str, steps: int = STEPS) -> None:
        self.zonals, self._steps = FIELDS[gravity], steps

    def coast(self, states: Array, start_s: float, end_s: float) -> Array:
        """The states after a coast.

        Raises
        ------
        ArithmeticError
            They lead into the centre of the Earth or out of numbers.
        """
        if start_s == end_s:
            return states
        revolution = math.tau * math.sqrt(_lowest(states) ** 3 / MU_M3_S2)
        found = np.empty(states.shape)
        for at, state in enumerate(states.T):
            found[:, at] = self._moved(state, end_s - start_s, revolution)[0]
        return found

    def arc(self, state: Array, start_s: float, end_s: float) -> tuple[Array, float]:
        """One state after a coast, shape (6,), and the least radius passed on the way [m].

        Raises
        ------
        ArithmeticError
            As of :meth:`coast`.
        """
        if start_s == end_s:
            return state, math.hypot(*state[:3])
        revolution = math.tau * math.sqrt(_lowest(state[:, None]) ** 3 / MU_M3_S2)
        return self._moved(state, end_s - start_s, revolution)

    def _moved(self, state: Array, duration_s: float, revolution_s: float) -> tuple[Array, float]:
        """A state after a time, and the least radius on the way [m]."""
        sides = _sides(state)
        elements = elements_of(sides * state)
        steps = math.ceil(abs(duration_s) / revolution_s * self._steps)
        least = advance(elements, duration_s, steps, self.zonals)
        found = sides * state_of(elements)
        if not math.isfinite(math.fsum(found)):
            raise ArithmeticError("the states are no longer numbers")
        return found, float(least)


def prograde(state: Array) -> Array:
    """A state, reflected if its orbit is retrograde: zonal fields are the same there."""
    found: Array = _sides(state) * state
    return found


def _sides(state: Array) -> Array:
    return MIRROR if state[0] * state[4] < state[1] * state[3] else np.ones(6)


def _lowest(states: Array) -> float:
    """Lowest perigee of some states [m], at least a tenth of the Earth's radius.

    Raises
    ------
    ArithmeticError
        An orbit is not closed, or at the centre of the Earth.
    """
    return max(min(map(_perigee, states.T.tolist())), 0.1 * EARTH_RADIUS_M)


def _perigee(state: list[float]) -> float:
    """Perigee of a state, by plain numbers: arrays of three take ten times as long [m]."""
    x, y, z, u, v, w = state
    radius = math.hypot(x, y, z)
    if radius == 0.0:
        raise ArithmeticError("a state is at the centre of the Earth")
    inverse = 2.0 / radius - (u * u + v * v + w * w) / MU_M3_S2
    if not inverse > 0.0:
        raise ArithmeticError("the burns lead away from the Earth")
    momentum = (y * w - z * v) ** 2 + (z * u - x * w) ** 2 + (x * v - y * u) ** 2
    return (1.0 - math.sqrt(max(1.0 - momentum * inverse / MU_M3_S2, 0.0))) / inverse


class BodyStates:
    """States of bodies at the beginnings and ends of legs.

    Those that nothing is reported of are propagated from the epoch.
    """

    def __init__(
        self, world: FreeMotion, refined: RefinedPlan, reported: ReportedStates | None
    ) -> None:
        self._world, self.reported = world, reported
        wanted: dict[str, set[float]] = {}
        for leg in refined.legs:
            led = leg.tow_before
            begins_s = leg.states[0].time_s if led is None else led.start_s
            wanted.setdefault(leg.origin, set()).add(begins_s)
            times_s = {leg.standoff_s, leg.arrival_s}
            wanted.setdefault(leg.destination, set()).update(
                times_s if leg.tow is None else times_s | {leg.tow.start_s}
            )
        at_epoch = {
            body.name: np.array([*body.position_m, *body.velocity_m_s]) for body in refined.bodies
        }
        self._known: dict[tuple[str, float], Array] = {}
        for name, times in wanted.items():
            now, state = 0.0, at_epoch[name]
            for time_s in sorted(times):
                if self.is_reported(name):
                    assert reported is not None
                    state = reported.state(name, time_s)
                else:
                    state, now = world.arc(state, now, time_s)[0], time_s
                self._known[name, time_s] = state

    def is_reported(self, name: str) -> bool:
        """Whether the states of a body come from an ephemeris."""
        return self.reported is not None and name in self.reported.bodies

    def state(self, name: str, time_s: float) -> Array:
        """State of a body at a time named by a leg, shape (6,)."""
        return self._known[name, time_s]

    def standoff(self, leg: RefinedLeg, length_m: float) -> Array:
        """State of the chaser required at the stand-off of a leg, shape (6,).

        Of the point that follows the destination on its orbit, slightly delayed, and on the way
        with which the approach begins.
        """
        name, time_s = leg.destination, leg.standoff_s
        state = self._known[name, time_s]
        delay_s = length_m / math.hypot(*state[3:])
        if self.reported is not None and name in self.reported.bodies:
            behind = self.reported.state(name, time_s - delay_s).copy()
        else:
            behind = self._world.coast(state[:, None], delay_s, 0.0)[:, 0].copy()
        behind[3:] += leg.approach_m_s or 0.0
        return behind


class Towing(NamedTuple):
    """Inputs to the flight of a leg's tows.

    Attributes
    ----------
    world : FreeMotion
    bodies : BodyStates
    instance : Instance
    leg : int
        Number of the leg.
    """

    world: FreeMotion
    bodies: BodyStates
    instance: Instance
    leg: int

    def flown(self, name: str, tow: RefinedTow) -> ThrustFlown:
        """Fly a tow; with burns, mass and shadow do not matter."""
        state = self.bodies.state(name, tow.start_s)
        if tow.thrust is not None:
            course = Course(self.leg, tow.start_s, tow.released.time_s, 0.0)
            return fly_thrust(self.instance, tow.thrust, course, state, self.world.zonals)
        moving, now, lowest = state, tow.start_s, math.inf
        for burn in tow.burns:
            if burn.phase == "return":  # without the object
                break
            moving, low = self.world.arc(moving, now, burn.time_s)
            moving, now, lowest = moving.copy(), burn.time_s, min(lowest, low)
            moving[3:] += burn.delta_v_m_s
        return ThrustFlown(moving, tow.delta_v_m_s, math.nan, 0.0, lowest)


def begun(world: FreeMotion, bodies: BodyStates, leg: RefinedLeg, instance: Instance) -> Array:
    """State of the chaser when a leg begins, before its first burn, shape (6,)."""
    now = leg.states[0].time_s
    if leg.tow_before is None:
        return bodies.state(leg.origin, now)
    led = Towing(world, bodies, instance, leg.leg).flown(leg.origin, leg.tow_before)
    alone = onward(led.state, leg.tow_before)
    return world.arc(alone, leg.tow_before.released.time_s, now)[0]


def onward(state: Array, tow: RefinedTow) -> Array:
    """State of the chaser after a release, including its burn back."""
    alone = state.copy()
    for burn in tow.burns:
        if burn.phase == "return":
            alone[3:] += burn.delta_v_m_s
    return alone


def reported_of(instance: Instance, refined: RefinedPlan) -> ReportedStates | None:
    """States of the ephemerides that a plan was refined onto; None if it was not.

    Raises
    ------
    InputError, MissingExtra
        As of :class:`.as_reported.ReportedStates`.
    """
    onto = refined.ephemerides
    return None if onto is None else ReportedStates(instance, onto)
