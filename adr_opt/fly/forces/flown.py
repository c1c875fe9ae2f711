"""Flight of refined plans with all forces."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import replace

import numpy as np

from ...common.constants import MU_M3_S2
from ...judge.admit import TANK, AnyRefined, admit
from ...judge.refined.world import FIELDS
from ...kernels.orbits.short_periods import Array
from ...plan.refined_plan import RefinedPlan
from ...problem.frame import Frame
from ...problem.instance import Instance
from ..flight.refined import PlannedLeg, planned_legs, refuse_strangers
from ..flight.result import TankFlight
from ..flight.tanks import legs_by_tank, tanks_of
from .course import Acting, LegCourse, Stretch, correction_m_s, kicked, last_lap
from .library import Moving, World
from .result import ForcedFlight, ForcedLeg, Off, total
from .settings import Forces


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
        Hears of how many legs are flown, and of how many there are.

    Raises
    ------
    InputError
        The refined plan belongs to another instance, or has violations.
    MissingExtra
        The library is not installed.
    """
    refined = admit(instance, refined, excused=TANK).plan
    refuse_strangers(instance, refined)
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
    """Motion with all forces off but the field of a refined plan, to compare integrators."""
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
    """The state of a chaser relative to a stand-off, uncorrected."""
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
    """Tanks of the refined plan with the corrections to the planned bodies on top."""
    by_number = {leg.leg: leg.planned_body for leg in legs}
    found = []
    tanks = legs_by_tank(instance, refined)
    for tank, its in zip(tanks_of(instance, refined), tanks, strict=True):
        more = total(by_number[leg.leg] for leg in its.legs)
        burns = tank.flown_delta_v_m_s
        flown = None if more is None or burns is None else burns + more
        found.append(replace(tank, flown_delta_v_m_s=flown))
    return tuple(found)
