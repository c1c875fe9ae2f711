"""Fly the burns of a plan, leg by leg."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np

from ...common.errors import InputError
from ...judge.admit import AnyPlan, admit
from ...kernels.orbits import ephemeris
from ...plan.after_tows import left_row
from ...plan.launched import as_launched
from ...plan.plan import Burn, Leg
from ...problem.instance import Instance
from ...problem.orbit import Orbit
from ..trajectory.bodies import body_states
from .flights import Flight, LegFlight
from .flyable import refuse_what_cannot_be_flown
from .mean_flight import MeanDynamics, is_between_circles
from .retargeted import Aim
from .tanks import burnt_m_s, plan_tanks
from .two_body import State, TwoBody, distance


def fly(instance: Instance, plan: AnyPlan) -> Flight:
    """Fly the burns of a plan in the dynamics of its instance.

    Each leg begins on the origin's own orbit, or where the tow of the origin leads, which begins
    there; the burns are taken from the plan as they are.
    Bodies move on the circles that the model plans with (docs/model.md section 1). A leg with an
    eccentric orbit is flown a second time on the true orbits, with its burns retargeted
    (:mod:`.retargeted`). What that takes, and what the burns of legs that drift take, is counted
    tank by tank.

    Parameters
    ----------
    instance : Instance
    plan : Plan or Admitted
        Free of violations, unless it was let in unjudged (:func:`adr_opt.judge.admit.admit`).

    Raises
    ------
    InputError
        The plan belongs to another instance or has violations; or, let in unjudged, it names an
        unknown body, or has burns that cannot be flown: out of time order, after the arrival,
        without an approach, or leading to no orbit; or a tow is missing, or one too many.
    MissingExtra
        boinor is not installed.
    """
    admitted = admit(instance, plan)
    plan = admitted.plan
    refuse_what_cannot_be_flown(instance, plan)
    instance = as_launched(instance, plan)
    motion = MeanDynamics() if instance.dynamics == "j2" else TwoBody()
    orbits = dict(zip(instance.names, instance.body_orbits, strict=True))
    flown, lead_ins = [], plan.lead_ins
    for number, leg in enumerate(plan.legs, start=1):
        lead_in = lead_ins.get(number, ())
        before = _led(instance, motion, orbits, number, leg, lead_in)
        one = _fly_leg(instance, motion, orbits, number, leg, before)
        if not is_between_circles(orbits, leg):
            one = replace(
                one, on_true_orbits=True, true_delta_v_m_s=_true_m_s(instance, orbits, leg, lead_in)
            )
        flown.append(one)
    taken = {
        one.leg: one.true_delta_v_m_s if one.on_true_orbits else burnt_m_s(leg)
        for one, leg in zip(flown, plan.legs, strict=True)
    }
    worst = max((leg.miss_m for leg in flown), default=0.0)
    return Flight(
        worst,
        tuple(flown),
        plan_tanks(instance, plan, taken),
        instance.dynamics,
        violations=admitted.violations,
    )


def _true_m_s(
    instance: Instance, orbits: dict[str, Orbit], leg: Leg, lead_in: tuple[Burn, ...]
) -> float | None:
    """ΔV of a leg on the true orbits; None if it does not arrive [m/s]."""
    try:
        return Aim(instance, orbits, leg, lead_in).delta_v_m_s()
    except (ArithmeticError, ValueError):
        return None


def _led(
    instance: Instance,
    motion: TwoBody,
    orbits: dict[str, Orbit],
    number: int,
    leg: Leg,
    lead_in: tuple[Burn, ...],
) -> State | None:
    """State where a leg begins after lead-in burns, as planned; None without such burns."""
    if not lead_in:
        return None
    try:
        now, row = lead_in[0].time_s, left_row(instance, leg.origin, leg.departure_s)
        state = motion.body(orbits[leg.origin], now)
        if row is not None:
            position, velocity = body_states(instance, leg.origin, now, true_orbits=True)
            state = position[0], velocity[0]
        for burn in lead_in:
            position, velocity = motion.coast(state, burn.time_s - now)
            state, now = (position, velocity + np.array(burn.delta_v_m_s)), burn.time_s
        state = motion.coast(state, leg.leaves_s - now)
        if row is None or not ephemeris.eccentricity_at(row, ephemeris.EPOCH_S):
            return state
        true: State = ephemeris.state_at(row, leg.leaves_s)
        return true
    except ArithmeticError as error:
        raise InputError(
            f"leg {number}: the tow before it cannot be flown: {error}; correct its burns"
        ) from None


def _fly_leg(
    instance: Instance,
    motion: TwoBody,
    orbits: dict[str, Orbit],
    number: int,
    leg: Leg,
    before: State | None,
) -> LegFlight:
    if not leg.traits.has_burns:
        return LegFlight(number, leg.origin, leg.destination, leg.kind)
    target = orbits[leg.destination]
    standoff = None
    try:
        now = leg.burns[0].time_s
        chaser = motion.body(orbits[leg.origin], now) if before is None else before
        for burn in leg.burns:
            position, velocity = motion.coast(chaser, burn.time_s - now)
            now = burn.time_s
            if standoff is None and burn.phase == "approach":
                behind = _behind(motion.body(target, now), instance.transfer.standoff_m)
                standoff = (distance(position, behind[0]), distance(velocity, behind[1]))
            chaser = position, velocity + np.array(burn.delta_v_m_s)
        # A grid of times has a later arrival: the chaser has docked by then.
        arrival = now if leg.traits.on_time_grid else leg.arrival_s
        at_arrival = motion.coast(chaser, arrival - now)
        goal = motion.body(target, arrival)
    except ArithmeticError as error:
        raise InputError(f"leg {number}: cannot be flown: {error}; correct its burns") from None
    assert standoff is not None  # every leg has an approach
    return LegFlight(
        leg=number,
        origin=leg.origin,
        destination=leg.destination,
        kind=leg.kind,
        planned_delta_v_m_s=leg.delta_v_m_s,
        burns_delta_v_m_s=leg.burns_delta_v_m_s,
        miss_m=standoff[0],
        relative_speed_m_s=standoff[1],
        arrival_miss_m=distance(at_arrival[0], goal[0]),
    )


def _behind(state: State, length: float) -> State:
    """State of a point that follows on a circular orbit, at a distance along it."""
    position, velocity = state
    radius, speed = math.sqrt(position @ position), math.sqrt(velocity @ velocity)
    cosine, sine = math.cos(length / radius), math.sin(length / radius)
    outward, ahead = position / radius, velocity / speed
    return (radius * (cosine * outward - sine * ahead), speed * (cosine * ahead + sine * outward))
