"""Judge of refined plans, with a different integrator from the one that made them.

Bodies and coasts are those of :mod:`adr_opt.judge.refined.world`. The chaser begins at its origin's
state; of a plan that was refined onto ephemerides at the stated state, whose distance from its
origin counts as a miss.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from dataclasses import replace
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from ...common.errors import InputError
from ...judge.admit import TANK, AnyRefined, admit
from ...judge.refined.flight import released
from ...judge.refined.holding import found_m_s
from ...judge.refined.thrust import Course, ThrustFlown, fly_thrust, refuse_wrong_thrust
from ...judge.refined.world import BodyStates, FreeMotion, Towing, begun, reported_of
from ...plan.launched import as_launched
from ...plan.refined_plan import RefinedLeg, RefinedPlan, RefinedState
from ...problem.instance import Instance
from ...problem.support import refuse
from .flyable import REFINED
from .refined_result import RefinedFlight, RefinedLegFlight
from .tanks import refined_routes, tanks_of

Array = npt.NDArray[np.float64]


def fly_refined(
    instance: Instance,
    refined: AnyRefined,
    report: Callable[[int, int], None] = lambda done, total: None,
) -> RefinedFlight:
    """Fly a refined plan in its gravity field and report its misses.

    Parameters
    ----------
    instance : Instance
    refined : RefinedPlan or Admitted
    report : callable
        Called with the number of legs flown, and of all legs.

    Raises
    ------
    InputError
        The refined plan belongs to another instance or has violations; or, let in unjudged, it
        names an unknown body, or leads away from the Earth.
    """
    admitted = admit(instance, refined, excused=TANK)
    refined = admitted.plan
    refuse_strangers(instance, refined)
    instance = as_launched(instance, refined.planned)
    world = FreeMotion(refined.gravity)
    reported = reported_of(instance, refined)
    bodies = BodyStates(world, refined, reported)
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
        violations=admitted.violations,
    )


def refuse_strangers(instance: Instance, refined: RefinedPlan) -> None:
    """Raise :class:`InputError` for a refined plan of another instance, or with unknown names.

    Or for one that lacks a tow, or has one too many.
    """
    refuse(instance, REFINED)
    refined.instance.refuse_other(instance, "refined plan")
    for chaser, legs in refined_routes(instance, refined):
        for leg in legs:
            refuse_wrong_thrust(instance, leg, chaser)
    towed = {target.name for target in instance.targets if target.service.is_flown}
    for leg in refined.legs:
        for name, tow in ((leg.origin, leg.tow_before), (leg.destination, leg.tow)):
            if name not in instance.names:
                raise InputError(f"leg {leg.leg}: {name!r} is not a body of the instance")
            if (name in towed) != (tow is not None):
                wrong = "towed, but the leg has no tow of it" if name in towed else "not towed"
                raise InputError(f"leg {leg.leg}: {name!r} is {wrong}; refine the plan again")


def _fly_leg(
    world: FreeMotion, bodies: BodyStates, leg: RefinedLeg, instance: Instance
) -> RefinedLegFlight:
    now = leg.states[0].time_s
    begin, there = leg.states[0], begun(world, bodies, leg, instance)
    onto = leg.holding_delta_v_m_s is not None
    chaser = _stated(begin) if onto else there[:, None].copy()
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
    behind = bodies.standoff(leg, instance.transfer.standoff_m)
    target = bodies.state(leg.destination, leg.arrival_s)
    return RefinedLegFlight(
        leg=leg.leg,
        origin=leg.origin,
        destination=leg.destination,
        kind=leg.kind,
        planned_delta_v_m_s=leg.planned_delta_v_m_s,
        flown_delta_v_m_s=burnt + (0.0 if thrust is None else thrust.delta_v_m_s),
        departure_miss_m=math.dist(begin.position_m, there[:3]),
        departure_miss_m_s=math.dist(begin.velocity_m_s, there[3:]) if onto else None,
        holding_delta_v_m_s=leg.holding_delta_v_m_s,
        standoff_miss_m=math.dist(at_standoff[:3], behind[:3]),
        standoff_miss_m_s=math.dist(at_standoff[3:], behind[3:]),
        arrival_miss_m=math.dist(chaser[:3, 0], target[:3]),
        arrival_miss_m_s=math.dist(chaser[3:, 0], target[3:]),
        towing_m_s=leg.removal_m_s,
        planned_towing_m_s=leg.planned_removal_m_s,
        **_of_thrust(leg, thrust, burnt),
        **({} if leg.tow is None else _of_tow(Towing(world, bodies, instance, leg.leg), leg)),
    )


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
        That it is to have behind the destination, on the way with which the approach begins.
    """

    leg: RefinedLeg
    chaser: Array
    body: Array
    standoff: Array


def planned_legs(instance: Instance, refined: RefinedPlan) -> Iterator[PlannedLeg]:
    """Start and goal states of the legs of a refined plan.

    Raises
    ------
    InputError
        A state leads into the centre of the Earth or away from it.
    """
    world = FreeMotion(refined.gravity)
    reported = reported_of(instance, refined)
    bodies = BodyStates(world, refined, reported)
    for leg in refined.legs:
        begin_s, end_s = leg.states[0].time_s, leg.standoff_s
        there = bodies.state(leg.destination, end_s)[:, None]
        try:
            if leg.holding_delta_v_m_s is None:
                chaser = begun(world, bodies, leg, instance)
            else:
                chaser = _stated(leg.states[0])[:, 0]
            if reported is not None and leg.destination in reported.bodies:
                body = reported.state(leg.destination, begin_s)
            else:
                body = world.coast(there, end_s, begin_s)[:, 0]
            planned = PlannedLeg(
                leg, chaser, body, bodies.standoff(leg, instance.transfer.standoff_m)
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


def _of_tow(towing: Towing, leg: RefinedLeg) -> dict[str, float]:
    """Distance of a tow's end from the stated place, and figures of a spiral."""
    assert leg.tow is not None
    led = towing.flown(leg.destination, leg.tow)
    found = {"tow_miss_m": math.dist(led.state[:3], leg.tow.released.position_m)}
    if leg.tow.thrust is None:
        return found
    orbit = released(led.state, towing.world.zonals)
    return found | {
        "tow_propellant_kg": leg.tow.thrust.mass_kg - led.mass_kg,
        "tow_shadow_s": led.shadow_s,
        "release_off_m": orbit.altitude_m - towing.instance.circle_m(leg.destination),
        "release_eccentricity": orbit.eccentricity,
    }
