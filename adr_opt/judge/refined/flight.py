"""Whether the states of refined legs follow from their burns, and end at their bodies.

An object is released on the means of its osculating elements over a lap.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from ...common.constants import EARTH_RADIUS_M, MU_M3_S2, OBLATENESS_M2
from ...common.errors import InputError
from ...plan.plan import Plan
from ...plan.refined_plan import RefinedLeg, RefinedPlan, RefinedState, RefinedTow
from ...problem.approach import approach_of
from ...problem.bodies import Target
from ...problem.chasers import Chaser
from ...problem.disposal import DisposalPerigee
from ...problem.drives import drive_of
from ...problem.instance import Instance
from ..check.altitude import Heights
from ..check.missed import CAPTURE_REVOLUTIONS, nearest_m, violations
from ..check.violation import MOST_RELEASE_OFF_M, Violation
from .holding import LEAST_SHARE, SPARE_M_S, found_m_s
from .propagation import advance, elements_of
from .tanks import Masses, chasers_of, planned_masses
from .thrust import (
    MOST_SHADOW_S,
    PROPELLANT_KG,
    Course,
    ThrustFlown,
    fly_thrust,
    refuse_wrong_thrust,
)
from .world import SAME_M, SAME_M_S, BodyStates, FreeMotion, Towing, begun, onward, prograde

Array = npt.NDArray[np.float64]

MOST_BEGUN = 1.5
"""Largest first burn of an approach, as a multiple of the one by its rule on a circle."""

SAME_TIME_S = 1e-6
"""Tolerance between the time of a burn and that of the state after it."""

OSCULATION_M = 10e3
"""Largest depth below the limit of altitude where harmonics act: limits are those of mean radii."""

WATCHED = 24
"""Times per revolution at which the altitude of a body with an ephemeris is sampled."""

PLACES = 144
"""Number of times in a revolution over which elements are averaged."""

STEPS = 2
"""Integration steps between two of those times."""


class _Passed(NamedTuple):
    """An event of a leg in the judge's flight: its name, its time, and the state after it."""

    event: str
    time_s: float
    state: Array


class _Judge(NamedTuple):
    """Inputs to the judgement of one leg."""

    instance: Instance
    world: FreeMotion
    bodies: BodyStates
    leg: RefinedLeg
    chaser: Chaser
    masses: Masses
    heights: Heights

    def target(self, name: str) -> Target:
        """A target by its name."""
        return next(target for target in self.instance.targets if target.name == name)


def check_flight(
    instance: Instance, plan: Plan, refined: RefinedPlan, world: FreeMotion, bodies: BodyStates
) -> Iterator[Violation]:
    """Check each leg, and the tows before and after it, by flying them."""
    owners = {number: chaser for chaser, legs in chasers_of(instance, plan) for number, _ in legs}
    masses, heights = planned_masses(instance, plan), Heights(instance)
    for leg in refined.legs:
        if leg.leg not in owners:
            continue  # an extra one: said elsewhere
        judge = _Judge(instance, world, bodies, leg, owners[leg.leg], masses[leg.leg], heights)
        try:
            refuse_wrong_thrust(instance, leg, judge.chaser)
            yield from _check_masses(judge)
            yield from _check_leg(judge)
        except InputError as error:
            yield Violation(leg.leg, "thrust", str(error).removeprefix(f"leg {leg.leg}: "))
        except ArithmeticError as error:
            yield Violation(leg.leg, "state", f"cannot be flown: {error}")


def _check_masses(judge: _Judge) -> Iterator[Violation]:
    """Check the masses assumed for low thrust against those of the plan."""
    drive = drive_of(judge.chaser, judge.instance.targets)
    if drive is None:
        return
    objects = {target.name: target.mass_kg or 0.0 for target in judge.instance.targets}
    leg = judge.leg
    found = [(leg.thrust, max(judge.masses.leaving, drive.lightest_kg))]
    if leg.tow is not None:
        both = max(judge.masses.tugging, drive.lightest_kg) + objects.get(leg.destination, 0.0)
        found.append((leg.tow.thrust, both))
    for thrust, true in found:
        if thrust is not None and abs(thrust.mass_kg - true) > PROPELLANT_KG:
            yield Violation(
                leg.leg, "mass", f"mass_kg = {thrust.mass_kg!r}, but in the plan {true!r}"
            )


def _check_leg(judge: _Judge) -> Iterator[Violation]:
    """Fly a leg from its stated departure, and compare all states."""
    instance, world, bodies, leg = judge.instance, judge.world, judge.bodies, judge.leg
    alone_m = math.inf
    if leg.tow_before is not None:
        led = Towing(world, bodies, instance, leg.leg).flown(leg.origin, leg.tow_before)
        yield from _check_released(
            judge, leg.origin, leg.tow_before, led, judged=leg.after_launch is True
        )
        alone_m = _lap(judge, onward(led.state, leg.tow_before), leg.tow_before)
    start = begun(world, bodies, leg, instance)
    yield from _off(leg.leg, "departure", _array(leg.states[0]), start, "where it begins")
    passed, lowest_m, shadow_s = _flown(judge)
    yield from _check_states(leg, passed)
    goals = {
        "stand-off": bodies.standoff(leg, instance.transfer.standoff_m),
        "arrival": bodies.state(leg.destination, leg.arrival_s),
    }
    for one in passed:
        if one.event in goals:
            yield from _off(
                leg.leg, one.event, one.state, goals[one.event], f"that of {leg.destination!r}"
            )
    yield from _check_begun(judge)
    if instance.transfer.approach == "safety-ellipse":
        yield from _check_missed(judge, passed)
    lowest_m = min(lowest_m, alone_m, _lowest_docked(judge, start))
    if leg.tow is not None:
        led = Towing(world, bodies, instance, leg.leg).flown(leg.destination, leg.tow)
        yield from _check_released(judge, leg.destination, leg.tow, led, judged=True)
        alone_m = _lap(judge, onward(led.state, leg.tow), leg.tow)
        lowest_m, shadow_s = min(lowest_m, alone_m, led.lowest_m), max(shadow_s, led.shadow_s)
    yield from _check_limits(judge, lowest_m, shadow_s)


def _flown(judge: _Judge) -> tuple[list[_Passed], float, float]:
    """Events of a leg as they follow from its burns and arcs.

    Also the least radius passed [m], and the time of thrust in the shadow [s].
    """
    world, leg = judge.world, judge.leg
    now, state, lowest, shadow_s = leg.states[0].time_s, _array(leg.states[0]), math.inf, 0.0
    passed, at_standoff = [_Passed("departure", now, state)], False
    if leg.thrust is not None:
        burnt = math.fsum(burn.size_m_s for burn in leg.burns)
        course = Course(leg.leg, now, leg.standoff_s, burnt)
        thrust = fly_thrust(judge.instance, leg.thrust, course, state, world.zonals)
        state, now, lowest, shadow_s = (
            thrust.state,
            leg.standoff_s,
            thrust.lowest_m,
            thrust.shadow_s,
        )
    for burn in leg.burns:
        if not at_standoff and burn.phase == "approach":
            state, low = world.arc(state, now, leg.standoff_s)
            now, lowest, at_standoff = leg.standoff_s, min(lowest, low), True
            passed.append(_Passed("stand-off", now, state))
        state, low = world.arc(state, now, burn.time_s)
        state, now, lowest = state.copy(), burn.time_s, min(lowest, low)
        state[3:] += burn.delta_v_m_s
        passed.append(_Passed("burn", now, state))
    if not at_standoff:
        raise ArithmeticError("no burn begins the approach")
    state, low = world.arc(state, now, leg.arrival_s)
    passed.append(_Passed("arrival", leg.arrival_s, state))
    return passed, min(lowest, low), shadow_s


def _check_begun(judge: _Judge) -> Iterator[Violation]:
    """Check that the approach begins by its rule, apart from the effect of eccentricity."""
    leg, target = judge.leg, judge.bodies.state(judge.leg.destination, judge.leg.standoff_s)
    axis = 1.0 / (2.0 / math.hypot(*target[:3]) - float(target[3:] @ target[3:]) / MU_M3_S2)
    rule = math.sqrt(MU_M3_S2 / axis**3) * math.hypot(
        *approach_of(judge.instance.transfer).burns[0, 1:4]
    )
    begins = math.hypot(*(leg.approach_m_s or (0.0,)))
    if begins > MOST_BEGUN * rule:
        yield Violation(
            leg.leg,
            "approach",
            f"approach_m_s: the first burn is {begins:.3g} m/s, but by the rule {rule:.3g} m/s",
        )


def _check_missed(judge: _Judge, passed: list[_Passed]) -> Iterator[Violation]:
    """Check the burns of a safety ellipse, with each one before the capture missed in turn."""
    leg, settings = judge.leg, judge.instance.transfer
    share = CAPTURE_REVOLUTIONS / approach_of(settings).revolutions
    until_s = leg.arrival_s - share * (leg.arrival_s - leg.standoff_s) + SAME_TIME_S
    made = [burn for burn in leg.burns if burn.phase == "approach" and burn.time_s <= until_s]
    target = judge.bodies.state(leg.destination, leg.standoff_s)
    chaser = next(one.state for one in passed if one.event == "stand-off").copy()
    burns = [(burn.time_s - leg.standoff_s, np.array(burn.delta_v_m_s)) for burn in made]
    if leg.approach_m_s is not None:  # of one vector with the stop: missed after that
        chaser[3:] -= leg.approach_m_s
        burns = [(0.0, np.array(leg.approach_m_s)), *burns]
    axis = 1.0 / (2.0 / math.hypot(*target[:3]) - float(target[3:] @ target[3:]) / MU_M3_S2)
    least = nearest_m(
        target[None],
        chaser[None],
        np.array([[since_s] for since_s, _ in burns]),
        lambda number, _: burns[number][1],
        math.tau * np.sqrt(np.array([axis**3]) / MU_M3_S2),
        OBLATENESS_M2 if judge.world.zonals.any() else 0.0,
    )
    yield from violations(leg.leg, leg.destination, least[:, 0], settings.keep_out_m)


def _check_states(leg: RefinedLeg, passed: list[_Passed]) -> Iterator[Violation]:
    """Check that each event has a state, and that states follow from the burns."""
    stated = [(one.event, one.time_s) for one in leg.states]
    true = [(one.event, one.time_s) for one in passed]
    if [event for event, _ in stated] != [event for event, _ in true] or any(
        abs(stated_s - true_s) > SAME_TIME_S
        for (_, stated_s), (_, true_s) in zip(stated, true, strict=True)
    ):
        yield Violation(
            leg.leg, "state", "its states must be those at departure and after each burn"
        )
        return
    for number, (one, known) in enumerate(zip(leg.states, passed, strict=True), start=1):
        yield from _off(
            leg.leg, "state", _array(one), known.state, f"where the burns lead, at state {number}"
        )


def _off(number: int, rule: str, stated: Array, true: Array, what: str) -> Iterator[Violation]:
    """Violation by a state that differs from the recomputed one."""
    far, fast = math.dist(stated[:3], true[:3]), math.dist(stated[3:], true[3:])
    if not (far <= SAME_M and fast <= SAME_M_S):
        yield Violation(number, rule, f"is {far:.3g} m and {fast:.3g} m/s off {what}")


def _check_released(
    judge: _Judge, name: str, tow: RefinedTow, led: ThrustFlown, *, judged: bool
) -> Iterator[Violation]:
    """Check the state of a release, and its orbit against the circle of disposal."""
    number = judge.leg.leg
    yield from _off(number, "release", _array(tow.released), led.state, "where the tow leads")
    if tow.released.event != "release":
        yield Violation(number, "release", f"its state is {tow.released.event!r}, not 'release'")
    if not judged:
        return
    disposal = judge.instance.disposal_of(judge.target(name))
    if isinstance(disposal, DisposalPerigee):
        wanted, said = disposal.perigee_m, "a perigee of"
        found = [_lap(judge, led.state, tow) - EARTH_RADIUS_M]
        # One that is lower from the beginning stays as it is.
        if found[0] < wanted and tow.delta_v_m_s == 0.0:
            return
    else:
        wanted, said = judge.instance.circle_m(name), "the circle at"
        orbit = released(prograde(led.state), judge.world.zonals)
        axis, e = EARTH_RADIUS_M + orbit.altitude_m, orbit.eccentricity
        found = [axis * (1.0 + side * e) - EARTH_RADIUS_M for side in (-1.0, 1.0)]
    if max(abs(each - wanted) for each in found) > MOST_RELEASE_OFF_M:
        there = " × ".join(f"{each / 1e3:.1f}" for each in found)
        yield Violation(
            number,
            "release",
            f"the object is released at {there} km, more than {MOST_RELEASE_OFF_M / 1e3:g} km off "
            f"{said} {wanted / 1e3:g} km",
        )


def _lap(judge: _Judge, state: Array, tow: RefinedTow) -> float:
    """Least radius in the first revolution after a release [m]."""
    inverse = 2.0 / math.hypot(*state[:3]) - float(state[3:] @ state[3:]) / MU_M3_S2
    if not inverse > 0.0:
        raise ArithmeticError("the burns lead away from the Earth")
    since_s = tow.released.time_s
    return judge.world.arc(state, since_s, since_s + math.tau / math.sqrt(MU_M3_S2 * inverse**3))[1]


def _lowest_docked(judge: _Judge, start: Array) -> float:
    """Least radius while docked: at the origin before the leg, at the destination after it [m]."""
    bodies, leg = judge.bodies, judge.leg
    until_s = leg.end_s if leg.tow is None else leg.tow.start_s
    spans = [(leg.destination, leg.arrival_s, until_s)]
    if leg.tow_before is None:
        spans.append((leg.origin, leg.ready_s, leg.states[0].time_s))
    lowest = math.inf
    for name, begin_s, end_s in spans:
        at_origin = name == leg.origin
        state = start if at_origin else bodies.state(name, leg.arrival_s)
        lap_s = math.tau * math.sqrt(math.hypot(*state[:3]) ** 3 / MU_M3_S2)
        if bodies.reported is not None and bodies.is_reported(name):
            times = np.linspace(max(begin_s, end_s - lap_s), end_s, WATCHED)
            lowest = min(lowest, float(_radii(bodies.reported.states(name, times)).min()))
            continue
        lasting = min(lap_s, end_s - begin_s)
        towards = end_s - lasting if at_origin else begin_s + lasting
        lowest = min(lowest, judge.world.arc(state, end_s if at_origin else begin_s, towards)[1])
    return lowest


def _radii(states: Array) -> Array:
    radii: Array = np.sqrt(np.sum(states[:, :3] ** 2, axis=1))
    return radii


def _check_limits(judge: _Judge, lowest_m: float, shadow_s: float) -> Iterator[Violation]:
    """Check the altitude of all arcs, thrust in the shadow, and the ΔV reserved for holding."""
    leg = judge.leg
    least_m = min(judge.heights.least_m(name) for name in (leg.origin, leg.destination))
    spare_m = OSCULATION_M if judge.world.zonals.any() else SAME_M
    if lowest_m - EARTH_RADIUS_M < least_m - spare_m:
        yield Violation(
            leg.leg,
            "altitude",
            f"comes down to {(lowest_m - EARTH_RADIUS_M) / 1e3:.1f} km, below the limit of "
            f"{least_m / 1e3:g} km",
        )
    if shadow_s > MOST_SHADOW_S:
        yield Violation(leg.leg, "shadow", f"thrusts {shadow_s:.3g} s in the Earth's shadow")
    if judge.bodies.reported is not None:
        needed = found_m_s(judge.bodies.reported, judge.world.coast, leg)
        if leg.holding_m_s < LEAST_SHARE * needed - SPARE_M_S:
            yield Violation(
                leg.leg,
                "holding",
                f"holding beside bodies takes {needed:.3g} m/s, but holding_m_s = "
                f"{leg.holding_m_s:.3g}",
            )


def _array(state: RefinedState) -> Array:
    return np.array([*state.position_m, *state.velocity_m_s])


class Released(NamedTuple):
    """The orbit of a released object.

    Attributes
    ----------
    altitude_m : float
        Mean semi-major axis above the radius of the Earth.
    eccentricity : float
        Of the mean eccentricity vector.
    """

    altitude_m: float
    eccentricity: float


def released(state: npt.NDArray[np.float64], zonals: npt.NDArray[np.float64]) -> Released:
    """Mean size and shape of the orbit from a state on.

    Harmonics change both within a revolution, by some kilometres; their means over one do not
    change to first order.

    Parameters
    ----------
    state : (6,) float64
        [m, m/s].
    zonals : (3,) float64
        J2, J3 and J4.
    """
    elements = elements_of(state)
    revolution = math.tau * math.sqrt(_axis(elements) ** 3 / MU_M3_S2)
    axes, shapes = np.empty(PLACES), np.empty((PLACES, 2))
    for place in range(PLACES):
        axes[place], shapes[place] = _axis(elements), elements[1:3]
        advance(elements, revolution / PLACES, STEPS, zonals)
    return Released(float(axes.mean()) - EARTH_RADIUS_M, math.hypot(*shapes.mean(axis=0)))


def _axis(elements: npt.NDArray[np.float64]) -> float:
    return float(elements[0] / (1.0 - elements[1] ** 2 - elements[2] ** 2))
