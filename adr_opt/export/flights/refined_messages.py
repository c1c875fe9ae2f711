"""Refined plans as messages of a state and burns, or as scripts, with osculating states."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import replace
from itertools import pairwise

from ...common.errors import InputError
from ...fly.flight.tanks import refined_routes
from ...fly.refine.bodies import moved, state_of
from ...fly.trajectory.axes import Axes
from ...kernels.orbits.short_periods import Array
from ...plan.refined_plan import RefinedLeg, RefinedPlan
from ...problem.chasers import TankByMass
from ...problem.instance import Instance
from . import ocm, opm
from .course import Burnt, CourseLeg, FlightCourse, Propulsion, burnt_from, burnt_of
from .gmat import AXES, cartesian, script
from .gmat_thrust import history, whole_millisecond
from .thrust_history import thrust_windows

DEGREES = {"two-body": 0, "j2": 2, "j3": 3, "j4": 4}
"""Degree of the zonal field, by the gravity of a refined plan."""

GMATS_OWN = (
    "GMAT flies in its own zonal field, about its own pole and with the constants of its JGM2.cof, "
    "which differ from these in their last digits. At each arrival the script docks the chaser."
)
"""Warning in scripts."""


def to_opm(
    course: FlightCourse,
    refined: RefinedPlan,
    legs: Sequence[RefinedLeg],
    axes: Axes,
    object_id: str | None,
) -> str:
    """Initial state of the legs of a course, and all their burns.

    When propagated in the field that it names, it follows the plan to what burns leave,
    millimetres after a leg: through service, too, where the plan has the chaser docked.
    """
    start_s = round(_ready_s(legs[0]) * 1e6) / 1e6
    state = _chaser_state(refined, legs[0], start_s)
    return opm.message(course, axes, object_id, start_s, state)


def to_gmat(
    course: FlightCourse,
    refined: RefinedPlan,
    legs: Sequence[RefinedLeg],
    axes: Axes,
    history_name: str | None = None,
) -> tuple[str, str]:
    """The script: osculating states of chaser and bodies, burns as impulses, coasts by time.

    With low thrust there is a second text, for a file of that name beside the script; else it is
    empty.
    """
    degree = DEGREES[refined.gravity]
    if degree:
        course = replace(course, said=(*course.said, GMATS_OWN))
    start_s = whole_millisecond(course.instance, _ready_s(legs[0]))
    bodies = {body.name: state_of(body) for body in refined.bodies}

    def state(body: str | None) -> Iterator[tuple[str, str]]:
        now = (
            _chaser_state(refined, legs[0], start_s)
            if body is None
            else moved(bodies[body], start_s, refined.gravity)
        )
        return cartesian(axes, now[:3], now[3:])

    if course.propulsion is None:
        return script(course, axes, degree, start_s, state), ""
    text = script(course, axes, degree, start_s, state, history_name)
    return text, history(course, axes, AXES[axes.frame.name])


def to_ocm(
    course: FlightCourse,
    refined: RefinedPlan,
    legs: Sequence[RefinedLeg],
    axes: Axes,
    object_id: str | None,
) -> str:
    """States at the beginnings of the legs of a course, and all their thrust and burns."""
    times = [round(_ready_s(leg) * 1e6) / 1e6 for leg in legs]
    starts = [
        ocm.StateAt(time_s, _chaser_state(refined, leg, time_s))
        for leg, time_s in zip(legs, times, strict=True)
    ]
    return ocm.to_ocm(course, axes, object_id, starts)


def refuse_between_ephemerides(
    refined: RefinedPlan, legs: Sequence[RefinedLeg], format: str
) -> None:
    """Raise :class:`InputError` for plans between ephemerides, whose burns do not cover services.

    Beside an ephemeris the chaser is held by what no burn of the plan says, and scripts move
    bodies freely.
    """
    if refined.ephemerides is None or format == "ocm":
        return
    if format == "script":
        raise InputError(
            "the plan was refined onto ephemerides, but bodies of a script do not follow them; "
            "write .oem, .ocm or .opm"
        )
    if len(legs) > 1:
        raise InputError(
            "the plan was refined onto ephemerides, but no burns hold the chaser beside them; "
            f"write .oem or .ocm, or a single leg as .{format}"
        )


def _ready_s(leg: RefinedLeg) -> float:
    """Start of a flight that begins with a leg [s].

    Between ephemerides, after the wait: nothing moves freely through that.
    """
    onto = leg.holding_delta_v_m_s is not None
    return leg.states[0].time_s if leg.is_led or onto else leg.ready_s


def _chaser_state(refined: RefinedPlan, leg: RefinedLeg, time_s: float) -> Array:
    """State of the chaser near the beginning of a leg: docked, or at the end of its tow."""
    if leg.is_led or refined.ephemerides is not None:
        departure = leg.states[0]
        return moved(state_of(departure), time_s - departure.time_s, refined.gravity)
    (origin,) = (state_of(body) for body in refined.bodies if body.name == leg.origin)
    return moved(origin, time_s, refined.gravity)


def refined_course(
    instance: Instance,
    refined: RefinedPlan,
    legs: Sequence[RefinedLeg],
    chaser: str | None,
    said: Sequence[str],
) -> FlightCourse:
    """Course of some legs of a refined plan, with masses if all legs are refined.

    Raises
    ------
    InputError
        They do not follow each other, or an object is towed by a spiral.
    """
    for leg in legs:
        if any(tow is not None and tow.thrust is not None for tow in (leg.tow_before, leg.tow)):
            raise InputError(
                f"leg {leg.leg}: the spiral of its tow is not written as a message or script; "
                "write .oem"
            )
    for one, after in pairwise(legs):
        if one.destination != after.origin:
            raise InputError(
                f"leg {after.leg} begins at {after.origin!r}, and leg {one.leg} ends at "
                f"{one.destination!r}: the legs between are not refined; write .oem, or one leg"
            )
    burnt: dict[int, tuple[Burnt, ...]] = {}
    if not refined.missing:
        wanted = {leg.leg for leg in legs}
        for its, route in refined_routes(instance, refined):
            if any(leg.leg in wanted for leg in route):
                flown = [CourseLeg.of(leg.leg, leg) for leg in route]
                if its.is_launched:
                    # No refined leg, but the kit that stays there is aboard at first.
                    start = route[0].ready_s
                    flown = [CourseLeg(0, its.name, route[0].origin, start, start, ()), *flown]
                burnt |= burnt_of(instance, its, flown)
    own = tuple(
        replace(CourseLeg.of(leg.leg, leg), windows=thrust_windows(leg, refined.gravity))
        for leg in legs
    )
    burnt |= {leg.leg: _burnt_after_thrust(leg) for leg in legs if leg.thrust is not None}
    propulsion = _propulsion(instance, refined, legs)
    return FlightCourse(instance, chaser, own, tuple(said), burnt, propulsion)


def _burnt_after_thrust(leg: RefinedLeg) -> tuple[Burnt, ...]:
    """Propellant use of the burns of a leg with low thrust."""
    assert leg.thrust is not None
    left = leg.thrust.mass_kg * math.exp(-leg.thrust.delta_v_m_s / leg.thrust.exhaust_m_s)
    return burnt_from(left, leg.impulses, leg.thrust.exhaust_m_s)


def _propulsion(
    instance: Instance, refined: RefinedPlan, legs: Sequence[RefinedLeg]
) -> Propulsion | None:
    """Low thrust of the chaser of some legs, if it has any."""
    exhausts = [leg.thrust.exhaust_m_s for leg in legs if leg.thrust is not None]
    if not exhausts:
        return None
    numbers = {leg.leg for leg in legs}
    for its, route in refined_routes(instance, refined):
        tank = its.tank
        if numbers & {leg.leg for leg in route} and isinstance(tank, TankByMass):
            return Propulsion(tank.dry_mass_kg, exhausts[0])
    raise InputError("the chaser with low thrust has no tank by mass; refine the plan again")
