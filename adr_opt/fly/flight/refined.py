"""Judge of refined plans, with a different integrator from the one that made them.

Nothing of :mod:`adr_opt.kernels` is used but constants and the compiler: the pull is written once
more, and :mod:`.propagation` integrates the change of elements by an explicit method, where the
refinement integrates positions by an implicit one. Bodies are propagated from the states at the
epoch that the file states, the chaser from its origin's. Of a plan that was refined onto
ephemerides, bodies are where :mod:`.as_reported` reads that they are, and the chaser begins at the
stated state, whose distance from its origin counts as a miss.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from dataclasses import replace
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from ...common.constants import EARTH_RADIUS_M, J2, MU_M3_S2
from ...common.errors import InputError
from ...kernels.orbits.gravity import J3, J4
from ...plan.refined_plan import RefinedLeg, RefinedPlan, RefinedState, RefinedTow
from ...problem.instance import Instance
from ...problem.support import refuse
from .as_reported import ReportedStates
from .flyable import REFINED, refuse_foreign
from .held import found_m_s
from .propagation import advance, elements_of, state_of
from .refined_result import RefinedFlight, RefinedLegFlight
from .release import released
from .tanks import refined_routes, tanks_of
from .thrust_flight import Course, ThrustFlown, fly_thrust, refuse_wrong_thrust

Array = npt.NDArray[np.float64]

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


def fly_refined(
    instance: Instance,
    refined: RefinedPlan,
    report: Callable[[int, int], None] = lambda done, total: None,
) -> RefinedFlight:
    """Fly a refined plan in its gravity field and report its misses.

    Parameters
    ----------
    instance : Instance
    refined : RefinedPlan
    report : callable
        Hears of how many legs are flown, and of how many there are.

    Raises
    ------
    InputError
        The refined plan belongs to another instance, names an unknown body, or leads away from
        the Earth.
    """
    refuse_strangers(instance, refined)
    world = _World(refined.gravity)
    onto = refined.ephemerides
    reported = None if onto is None else ReportedStates(instance, onto)
    bodies = _Ephemeris(world, refined, reported)
    flown = []
    report(0, len(refined.legs))
    for leg in refined.legs:
        try:
            flown.append(_fly_leg(world, bodies, leg, instance))
            if reported is not None:
                needed = found_m_s(reported, world.coast, leg)
                flown[-1] = replace(flown[-1], holding_found_m_s=needed)
        except ArithmeticError as error:
            raise InputError(f"leg {leg.leg}: cannot be flown: {error}") from None
        report(len(flown), len(refined.legs))
    return RefinedFlight(
        gravity=refined.gravity,
        legs=tuple(flown),
        tanks=tanks_of(instance, refined),
        missing=tuple(missing.leg for missing in refined.missing),
    )


def refuse_strangers(instance: Instance, refined: RefinedPlan) -> None:
    """Raise :class:`InputError` for a refined plan of another instance, or with unknown names.

    Or for one that lacks a tow, or has one too many.
    """
    refuse(instance, REFINED)
    refuse_foreign(instance, refined)
    for chaser, legs in refined_routes(instance, refined):
        for leg in legs:
            refuse_wrong_thrust(instance, leg, chaser)
    towed = {target.name for target in instance.targets if target.service.is_flown}
    for leg in refined.legs:
        for name, tow in ((leg.origin, leg.tow_before), (leg.destination, leg.tow)):
            if name not in instance.names:
                raise InputError(f"leg {leg.leg}: {name!r} is not a body of the instance")
            if (name in towed) != (tow is not None):
                wrong = "towed, and the leg has no tow of it" if name in towed else "not towed"
                raise InputError(f"leg {leg.leg}: {name!r} is {wrong}; refine the plan again")


class _World:
    """Free motion of many states at once, as columns of shape (6, n) [m, m/s]."""

    def __init__(self, gravity: str) -> None:
        self.zonals = FIELDS[gravity]

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
        steps = math.ceil(abs(end_s - start_s) / revolution * STEPS)
        found = np.empty(states.shape)
        for at, state in enumerate(states.T):
            retrograde = state[0] * state[4] < state[1] * state[3]
            sides = MIRROR if retrograde else np.ones(6)
            elements = elements_of(sides * state)
            advance(elements, end_s - start_s, steps, self.zonals)
            found[:, at] = sides * state_of(elements)
        if not bool(np.isfinite(found).all()):
            raise ArithmeticError("the states are no longer numbers")
        return found


def _lowest(states: Array) -> float:
    """Lowest perigee of some states [m], at least a tenth of the Earth's radius.

    Raises
    ------
    ArithmeticError
        An orbit is not closed.
    """
    positions, velocities = states[:3].T, states[3:].T
    radius = np.sqrt(np.sum(positions**2, axis=1))
    inverse = 2.0 / radius - np.sum(velocities**2, axis=1) / MU_M3_S2
    if not bool((inverse > 0.0).all()):
        raise ArithmeticError("the burns lead away from the Earth")
    momentum = np.sum(np.cross(positions, velocities) ** 2, axis=1)
    e = np.sqrt(np.maximum(1.0 - momentum * inverse / MU_M3_S2, 0.0))
    return float(max(((1.0 - e) / inverse).min(), 0.1 * EARTH_RADIUS_M))


class _Ephemeris:
    """States of bodies at the beginnings and ends of legs.

    Those that nothing is reported of are propagated together from the epoch.
    """

    def __init__(
        self, world: _World, refined: RefinedPlan, reported: ReportedStates | None
    ) -> None:
        self._world, self._reported = world, reported
        elsewhere = () if reported is None else reported.bodies
        wanted: dict[float, set[str]] = {}
        for leg in refined.legs:
            led = leg.tow_before
            begins_s = leg.states[0].time_s if led is None else led.start_s
            wanted.setdefault(begins_s, set()).add(leg.origin)
            if leg.tow is not None:
                wanted.setdefault(leg.tow.start_s, set()).add(leg.destination)
            for time in (leg.standoff_s, leg.arrival_s):
                wanted.setdefault(time, set()).add(leg.destination)
        last = {name: time for time in sorted(wanted) for name in wanted[time]}
        states = {
            body.name: np.array([*body.position_m, *body.velocity_m_s])
            for body in refined.bodies
            if body.name in last and body.name not in elsewhere
        }
        self._known: dict[tuple[str, float], Array] = {}
        now = 0.0
        for time in sorted(wanted):
            for name in wanted[time].difference(states):
                assert reported is not None  # the others have a state at the epoch
                self._known[name, time] = reported.state(name, time)
            names = [name for name in states if last[name] >= time]
            if not names:
                continue
            moved = world.coast(np.stack([states[name] for name in names], axis=1), now, time)
            states = dict(zip(names, moved.T, strict=True))
            now = time
            for name in wanted[time].intersection(states):
                self._known[name, time] = states[name]

    def state(self, name: str, time_s: float) -> Array:
        """State of a body at a time named by a leg, shape (6,)."""
        return self._known[name, time_s]

    def following(self, name: str, time_s: float, length_m: float) -> Array:
        """State of the point that follows a body on its orbit, slightly delayed."""
        state = self._known[name, time_s]
        if self._reported is not None and name in self._reported.bodies:
            return self._reported.state(name, time_s - length_m / math.hypot(*state[3:]))
        return self._world.coast(state[:, None], length_m / math.hypot(*state[3:]), 0.0)[:, 0]


def _fly_leg(
    world: _World, bodies: _Ephemeris, leg: RefinedLeg, instance: Instance
) -> RefinedLegFlight:
    now = leg.states[0].time_s
    begin, begun = leg.states[0], _begun(world, bodies, leg, instance)[:, 0]
    onto = leg.holding_delta_v_m_s is not None
    chaser = _stated(begin) if onto else begun[:, None].copy()
    at_standoff = None
    thrust = None
    if leg.thrust is not None:
        burnt_m_s = math.fsum(burn.size_m_s for burn in leg.burns)
        course = Course(leg.leg, now, leg.standoff_s, burnt_m_s)
        thrust = fly_thrust(instance, leg.thrust, course, chaser[:, 0], world.zonals)
        chaser, now = thrust.state[:, None], leg.standoff_s
    for burn in leg.burns:
        if at_standoff is None and burn.phase == "approach":
            chaser, now = world.coast(chaser, now, leg.standoff_s), leg.standoff_s
            at_standoff = chaser[:, 0]
        chaser, now = world.coast(chaser, now, burn.time_s), burn.time_s
        chaser = chaser.copy()
        chaser[3:, 0] += burn.delta_v_m_s
    if at_standoff is None:
        raise ArithmeticError("no burn begins the approach; add the approach burns")
    chaser = world.coast(chaser, now, leg.arrival_s)
    burnt = math.fsum(burn.size_m_s for burn in leg.burns)
    behind = bodies.following(leg.destination, leg.standoff_s, instance.transfer.standoff_m)
    target = bodies.state(leg.destination, leg.arrival_s)
    return RefinedLegFlight(
        leg=leg.leg,
        origin=leg.origin,
        destination=leg.destination,
        kind=leg.kind,
        planned_delta_v_m_s=leg.planned_delta_v_m_s,
        flown_delta_v_m_s=burnt + (0.0 if thrust is None else thrust.delta_v_m_s),
        departure_miss_m=math.dist(begin.position_m, begun[:3]),
        departure_miss_m_s=math.dist(begin.velocity_m_s, begun[3:]) if onto else None,
        holding_delta_v_m_s=leg.holding_delta_v_m_s,
        standoff_miss_m=math.dist(at_standoff[:3], behind[:3]),
        standoff_miss_m_s=math.dist(at_standoff[3:], behind[3:]),
        arrival_miss_m=math.dist(chaser[:3, 0], target[:3]),
        arrival_miss_m_s=math.dist(chaser[3:, 0], target[3:]),
        towing_m_s=leg.removal_m_s,
        planned_towing_m_s=leg.planned_removal_m_s,
        **_of_thrust(leg, thrust, burnt),
        **({} if leg.tow is None else _of_tow(_Towing(world, bodies, instance, leg.leg), leg)),
    )


def _begun(world: _World, bodies: _Ephemeris, leg: RefinedLeg, instance: Instance) -> Array:
    """State of the chaser when a leg begins, before its first burn, shape (6, 1)."""
    now = leg.states[0].time_s
    if leg.tow_before is None:
        return bodies.state(leg.origin, now)[:, None].copy()
    end_s = leg.tow_before.released.time_s
    led = _Towing(world, bodies, instance, leg.leg).flown(leg.origin, leg.tow_before)
    return world.coast(led.state[:, None], end_s, now)


def _stated(begin: RefinedState) -> Array:
    """A state of a refined plan, shape (6, 1)."""
    return np.array([*begin.position_m, *begin.velocity_m_s])[:, None]


class PlannedLeg(NamedTuple):
    """A leg with states in the field of its plan, each of shape (6,) [m, m/s].

    Attributes
    ----------
    leg : RefinedLeg
    chaser : (6,) float64
        When it begins, before the first burn.
    body : (6,) float64
        The destination at the same time.
    standoff : (6,) float64
        The point behind the destination when the approach begins.
    """

    leg: RefinedLeg
    chaser: Array
    body: Array
    standoff: Array


def planned_legs(instance: Instance, refined: RefinedPlan) -> Iterator[PlannedLeg]:
    """Where the legs of a refined plan begin and are to arrive.

    Raises
    ------
    InputError
        A state leads into the centre of the Earth or away from it.
    """
    world = _World(refined.gravity)
    onto = refined.ephemerides
    reported = None if onto is None else ReportedStates(instance, onto)
    bodies = _Ephemeris(world, refined, reported)
    for leg in refined.legs:
        begin_s, end_s = leg.states[0].time_s, leg.standoff_s
        there = bodies.state(leg.destination, end_s)[:, None]
        try:
            if leg.holding_delta_v_m_s is None:
                begun = _begun(world, bodies, leg, instance)
            else:
                begun = _stated(leg.states[0])
            if reported is not None and leg.destination in reported.bodies:
                body = reported.state(leg.destination, begin_s)
            else:
                body = world.coast(there, end_s, begin_s)[:, 0]
            planned = PlannedLeg(
                leg,
                begun[:, 0],
                body,
                bodies.following(leg.destination, end_s, instance.transfer.standoff_m),
            )
        except ArithmeticError as error:
            raise InputError(f"leg {leg.leg}: cannot be flown: {error}") from None
        yield planned


def _of_thrust(leg: RefinedLeg, thrust: ThrustFlown | None, burnt_m_s: float) -> dict[str, float]:
    """Propellant of a leg of low thrust, planned and flown, and thrust in the shadow."""
    if thrust is None or leg.thrust is None:
        return {}
    full, exhaust = leg.thrust.mass_kg, leg.thrust.exhaust_m_s
    return {
        "planned_propellant_kg": full * -math.expm1(-leg.planned_delta_v_m_s / exhaust),
        "flown_propellant_kg": full - thrust.mass_kg * math.exp(-burnt_m_s / exhaust),
        "shadow_s": thrust.shadow_s,
    }


class _Towing(NamedTuple):
    """What tows of a leg are flown with."""

    world: _World
    bodies: _Ephemeris
    instance: Instance
    leg: int

    def flown(self, name: str, tow: RefinedTow) -> ThrustFlown:
        """Fly a tow; one by burns has no mass and no shadow."""
        world, state = self.world, self.bodies.state(name, tow.start_s)
        if tow.thrust is not None:
            course = Course(self.leg, tow.start_s, tow.released.time_s, 0.0)
            return fly_thrust(self.instance, tow.thrust, course, state, world.zonals)
        begin, end = tow.burns
        moving = state[:, None].copy()
        moving[3:, 0] += begin.delta_v_m_s
        moving = world.coast(moving, begin.time_s, end.time_s).copy()
        moving[3:, 0] += end.delta_v_m_s
        return ThrustFlown(moving[:, 0], tow.delta_v_m_s, math.nan, 0.0)


def _of_tow(towing: _Towing, leg: RefinedLeg) -> dict[str, float]:
    """How far from the stated place a tow ends, and what is told of a spiral."""
    assert leg.tow is not None
    led = towing.flown(leg.destination, leg.tow)
    found = {"tow_miss_m": math.dist(led.state[:3], leg.tow.released.position_m)}
    if leg.tow.thrust is None:
        return found
    orbit = released(led.state, towing.world.zonals)
    return found | {
        "tow_propellant_kg": leg.tow.thrust.mass_kg - led.mass_kg,
        "tow_shadow_s": led.shadow_s,
        "release_off_m": orbit.altitude_m - (towing.instance.mission.disposal_altitude_m or 0.0),
        "release_eccentricity": orbit.eccentricity,
    }
