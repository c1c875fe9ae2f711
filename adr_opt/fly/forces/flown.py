"""Flight of refined plans with all forces.

A leg is corrected in the last revolution before its stand-off, at the least ΔV. Two impulses a
revolution apart do not suffice: after a whole revolution, an impulse has moved the chaser along the
track alone, so that no size of it removes an error across the track or in height. So corrections
may be made every 30° of that revolution, the last at the stand-off, on top of the burns that the
leg has there; those of least total size are taken (:mod:`..refine.least`). Derivatives are those of
a zonal field. The corrected end is flown with all forces, and what is left of the miss corrected
again.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import replace
from typing import Any, NamedTuple

import numpy as np

from ...common.constants import MU_M3_S2
from ...judge.admit import TANK, AnyRefined, admit
from ...kernels.orbits import coast
from ...kernels.orbits.gravity import FIELDS
from ...kernels.orbits.short_periods import Array
from ...plan.launched import as_launched
from ...plan.refined_plan import RefinedLeg, RefinedPlan
from ...problem.frame import Frame
from ...problem.instance import Instance
from ..flight.flights import TankFlight
from ..flight.refined import PlannedLeg, planned_legs, refuse_strangers
from ..flight.tanks import legs_by_tank, tanks_of
from ..refine.least import least_impulses
from .forced_flight import ForcedFlight, ForcedLeg, Off, total
from .library import Moving, PushedWindow, World, pushes
from .settings import Forces

PLACES = 12
"""Number of equal parts of the last revolution; corrections are made at their ends."""

MOST_ROUNDS = 12

CLOSE_M, CLOSE_M_S = 0.1, 1e-4
"""Largest miss after a correction, in position [m] and velocity [m/s]."""

Fly = Callable[[Array], Array]


class LastLap(NamedTuple):
    """The last revolution of a leg, flown without correction.

    Attributes
    ----------
    start : (6,) float64
        State of the chaser at the first time, before the burn there [m, m/s].
    times : (n,) float64
        Of burns and possible corrections, in order [s].
    burns : (n, 3) float64
        Those of the leg; 0 where it has none [m/s].
    end_s : float
        Of the stand-off.
    reached : (6,) float64
        State there, by these burns alone.
    """

    start: Array
    times: Array
    burns: Array
    end_s: float
    reached: Array


class Stretch(NamedTuple):
    """Times [s] between which a leg is corrected, with the states of the chaser at both."""

    begin_s: float
    end_s: float
    start: Array
    reached: Array


def last_lap(span: Stretch, burns: dict[float, Array]) -> LastLap:
    """The last revolution over a span, the burns of the leg by time."""
    start, begin_s, end_s = span.start, span.begin_s, span.end_s
    places = np.linspace(begin_s, end_s, PLACES + 1)
    times = np.array(sorted({*places.tolist(), *burns}))
    made = np.array([burns.get(float(time), np.zeros(3)) for time in times])
    return LastLap(start, times, made, end_s, span.reached)


def correction_m_s(last: LastLap, goal: Array, fly: Fly) -> float | None:
    """ΔV of the least impulses that lead to a goal; None if none are found [m/s].

    Parameters
    ----------
    last : LastLap
    goal : (6,) float64
    fly : callable
        The state at the end with all forces, from all impulses, shape (n, 3).
    """
    impulses = np.zeros_like(last.burns)
    try:
        for number in range(MOST_ROUNDS):
            missing = goal - (fly(last.burns + impulses) if number else last.reached)
            if math.hypot(*missing[:3]) <= CLOSE_M and math.hypot(*missing[3:]) <= CLOSE_M_S:
                return math.fsum(math.hypot(*one) for one in impulses)
            _, matrices, _ = coast.fly(
                last.start, last.times, last.burns + impulses, last.end_s, FIELDS["j4"], True
            )
            effects = matrices[:, :, 3:]
            change = missing + np.einsum("kij,kj->i", effects, impulses)
            impulses = least_impulses(np.ascontiguousarray(effects), change).impulses
            if not bool(np.isfinite(impulses).all()):
                return None
    except ArithmeticError:  # led into the Earth, or away from it
        pass
    return None


BODY_STEPS = 72
"""Steps per revolution of bodies: errors of metres a week, where forces move them kilometres."""


class Acting(NamedTuple):
    """Forces on the chaser and on the bodies, as objects of the library."""

    chaser: Any
    body: Any


class LegCourse:
    """Burns and windows of thrust of a leg before its approach.

    Parameters
    ----------
    world : World
    acting : Acting
    leg : RefinedLeg

    Raises
    ------
    ArithmeticError
        No burn begins the approach.
    """

    def __init__(self, world: World, acting: Acting, leg: RefinedLeg) -> None:
        self._world, self.acting = world, acting
        self.burns = _burns_before(leg)
        self._pushes = () if leg.thrust is None else tuple(pushes(leg.thrust))

    def beside(
        self, chaser: Array, body: Array, start_s: float, end_s: float
    ) -> tuple[Array, Array]:
        """States of chaser and body at the end, before the burn there."""
        return self._flown(chaser, body, (start_s, end_s), self.burns)

    def alone(
        self, chaser: Array, start_s: float, end_s: float, burns: dict[float, Array]
    ) -> Array:
        """State of the chaser at the end, after the burn there; thrust as planned."""
        found, _ = self._flown(chaser, None, (start_s, end_s), burns)
        return kicked(found, burns, end_s)

    def _flown(
        self,
        chaser: Array,
        body: Array | None,
        span_s: tuple[float, float],
        burns: Mapping[float, Array],
    ) -> tuple[Array, Array]:
        now, end_s = span_s
        times = {*burns, *(time for push in self._pushes for time in push[:2]), end_s}
        for time in sorted(time for time in times if now < time <= end_s):
            chaser = kicked(chaser, burns, now)
            objects = [Moving(chaser, self.acting.chaser, self._push(now, time))]
            if body is not None:
                objects.append(Moving(body, self.acting.body, steps=BODY_STEPS))
            chaser, *rest = self._world.coast(objects, now, time)
            body = rest[0] if rest else None
            now = time
        return chaser, chaser if body is None else body

    def _push(self, start_s: float, end_s: float) -> PushedWindow | None:
        """Thrust between two times within which no window begins or ends."""
        for push in self._pushes:
            if push.begin_s <= start_s and end_s <= push.end_s:
                return push
        return None


def kicked(state: Array, burns: Mapping[float, Array], time_s: float) -> Array:
    """The state after the burn at a time, if any."""
    if time_s not in burns:
        return state
    found: Array = state + np.concatenate([np.zeros(3), burns[time_s]])
    return found


def _burns_before(leg: RefinedLeg) -> dict[float, Array]:
    """Burns before the approach, by time; simultaneous ones are added."""
    found: dict[float, Array] = {}
    for burn in leg.burns:
        if burn.phase == "approach":
            return found
        found[burn.time_s] = found.get(burn.time_s, np.zeros(3)) + np.array(burn.delta_v_m_s)
    raise ArithmeticError("no burn begins the approach; add the approach burns")


def fly_forced(
    instance: Instance,
    refined: AnyRefined,
    forces: Forces | None = None,
    report: Callable[[int, int], None] = lambda done, total: None,
) -> ForcedFlight:
    """Fly a refined plan with all forces; nothing is corrected on the way.

    Parameters
    ----------
    instance : Instance
    refined : RefinedPlan or Admitted
    forces : Forces, optional
        Those of :class:`Forces` by default.
    report : callable
        Called with the number of legs flown, and of all legs.

    Raises
    ------
    InputError
        The refined plan belongs to another instance, or has violations.
    MissingExtra
        The library is not installed.
    """
    refined = admit(instance, refined, excused=TANK).plan
    refuse_strangers(instance, refined)
    instance = as_launched(instance, refined.planned)
    settings = Forces() if forces is None else forces
    world, acting = all_forces(instance, settings)
    legs: list[ForcedLeg] = []
    report(0, len(refined.legs))
    for planned in planned_legs(instance, refined):
        legs.append(fly_leg(world, acting, planned, instance.transfer.standoff_m))
        report(len(legs), len(refined.legs))
    return ForcedFlight(
        forces=settings,
        gravity=refined.gravity,
        legs=tuple(legs),
        tanks=_with_corrections(instance, refined, legs),
        missing=tuple(missing.leg for missing in refined.missing),
    )


def all_forces(instance: Instance, settings: Forces) -> tuple[World, Acting]:
    """Motion with all forces."""
    world = World.of(instance)
    return world, Acting(
        world.all_forces(settings, settings.area_mass_m2_kg),
        world.all_forces(settings, settings.of_targets_m2_kg),
    )


def plan_field(instance: Instance, gravity: str) -> tuple[World, Acting]:
    """Motion in the gravity field of the refined plan only, to compare integrators."""
    # The axis of that field is the one of the elements, whatever their frame.
    world = World(instance.epoch, Frame(name="GCRF"))
    forces = world.zonal(FIELDS[gravity])
    return world, Acting(forces, forces)


def fly_leg(world: World, acting: Acting, planned: PlannedLeg, standoff_m: float) -> ForcedLeg:
    """Fly one leg and its body side by side, and correct its end."""
    leg = planned.leg
    found = ForcedLeg(
        leg=leg.leg,
        origin=leg.origin,
        destination=leg.destination,
        kind=leg.kind,
        flown_delta_v_m_s=leg.spent_m_s,
        planned_body=None,
        flown_body=None,
    )
    try:
        on_plan, on_body = _arrivals(world, LegCourse(world, acting, leg), planned, standoff_m)
    except ArithmeticError as error:
        return replace(found, lost=str(error))
    return replace(found, planned_body=on_plan, flown_body=on_body)


def _arrivals(
    world: World, course: LegCourse, planned: PlannedLeg, standoff_m: float
) -> tuple[Off, Off]:
    """Arrival relative to the planned body, and to the body under the same forces."""
    begin_s, end_s = planned.leg.states[0].time_s, planned.leg.standoff_s
    last_s = max(begin_s, end_s - _revolution_s(planned.standoff))
    start, body = course.beside(planned.chaser, planned.body, begin_s, last_s)
    chaser, body = course.beside(start, body, last_s, end_s)
    chaser = kicked(chaser, course.burns, end_s)
    # The point that follows the body is where that was a moment ago.
    delay = standoff_m / math.hypot(*body[3:])
    following = world.coast([Moving(body, course.acting.body)], end_s + delay, end_s)[0]
    following[3:] += planned.leg.approach_m_s or 0.0
    burns = {at: burn for at, burn in course.burns.items() if last_s <= at <= end_s}
    last = last_lap(Stretch(last_s, end_s, start, chaser), burns)

    def fly(impulses: Array) -> Array:
        made = dict(zip(last.times.tolist(), impulses, strict=True))
        return course.alone(start, last_s, end_s, made)

    def off(goal: Array) -> Off:
        return replace(_off(chaser, goal), correction_m_s=correction_m_s(last, goal, fly))

    return off(planned.standoff), off(following)


def _revolution_s(state: Array) -> float:
    inverse = 2.0 / math.hypot(*state[:3]) - float(state[3:] @ state[3:]) / MU_M3_S2
    return math.tau / math.sqrt(MU_M3_S2 * inverse**3)


def _off(chaser: Array, goal: Array) -> Off:
    """Uncorrected arrival of a chaser relative to a stand-off."""
    outward = goal[:3] / math.hypot(*goal[:3])
    momentum = np.cross(goal[:3], goal[3:])
    across = momentum / math.hypot(*momentum)
    away = chaser[:3] - goal[:3]
    return Off(
        radial_m=float(outward @ away),
        along_m=float(np.cross(across, outward) @ away),
        across_m=float(across @ away),
        speed_m_s=math.hypot(*(chaser[3:] - goal[3:])),
        correction_m_s=None,
    )


def _with_corrections(
    instance: Instance, refined: RefinedPlan, legs: list[ForcedLeg]
) -> tuple[TankFlight, ...]:
    """Tanks of the refined plan, with the corrections to the planned bodies added."""
    by_number = {leg.leg: leg.planned_body for leg in legs}
    found = []
    tanks = legs_by_tank(instance, refined)
    for tank, its in zip(tanks_of(instance, refined), tanks, strict=True):
        more = total(by_number[leg.leg] for leg in its.legs)
        burns = tank.flown_delta_v_m_s
        flown = None if more is None or burns is None else burns + more
        found.append(replace(tank, flown_delta_v_m_s=flown))
    return tuple(found)
