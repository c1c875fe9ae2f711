"""Refinement of one leg: from the docked start via the stand-off to the target; and of tows.

The plan's tows are burns along the motion, two of them half a revolution apart or one at an apogee.
An osculating orbit is no circle, by kilometres; burns of the same size leave the object on an orbit
as near to one. Nothing is met at its end, so that there is nothing to correct: the next leg begins
wherever the tow has led.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Protocol

import numpy as np

from ...common.constants import EARTH_RADIUS_M, MU_M3_S2
from ...kernels.orbits.short_periods import Array
from ...plan.plan import Burn, Leg
from ...plan.refined_plan import Freedom, RefinedBurn, RefinedLeg, RefinedState, RefinedTow
from ...problem.bodies import DisposalPerigee
from ...problem.instance import Instance
from ..trajectory.bodies import leaving_state
from ..trajectory.kepler import drift, secular
from .bodies import Gravity, MovingBodies, moved, recorded, state_of
from .leg import FlownImpulses, LegEnds, NoWay, cheapen, close, residual
from .own_burns import cheapest_near


class HasStates(Protocol):
    """Where bodies are at any time."""

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
    """Radii of perigee of an object and of its chaser, where that is what its tow aims at [m]."""
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
    """A burn as large as planned, with or against a velocity as the plan has it, (3,) [m/s]."""
    size = math.copysign(burn.size_m_s, float(velocity @ np.array(burn.delta_v_m_s)))
    impulse: Array = size * velocity / np.linalg.norm(velocity)
    return impulse


PLACES = 144
"""Number of times in a revolution among which the least radius is looked for."""

AIMED_STEPS, CLOSE_M = 12, 10.0
"""Maximum number of steps of a burn that aims at a perigee, and how near it comes [m]."""

BACK_SPARE_M = 1e3
"""How far above the limit of altitude a chaser comes back to [m]."""

HELPERS = 24
"""Number of times for additional impulses if the plan's own burns cannot be closed."""

LAST_REVOLUTIONS = 2
"""Number of revolutions before the stand-off that hold them if that fails, too."""


def refine_leg(
    instance: Instance,
    bodies: MovingBodies,
    number: int,
    leg: Leg,
    freedom: Freedom,
    lead_in: tuple[Burn, ...] = (),
    after_launch: bool = False,
) -> RefinedLeg:
    """Guide one leg to its stand-off, and from there to its target.

    Parameters
    ----------
    instance : Instance
    bodies : MovingBodies
        With the origin and the destination.
    number : int
        From 1.
    leg : Leg
        With burns in time order, the last of them those of the approach.
    freedom : {"free", "planned"}
        Whether ΔV is made least with impulses at any time from the first burn to the stand-off, or
        the plan's burns keep their times and are kept near what they were (:mod:`.own_burns`).
    lead_in : tuple of Burn
        Those that lead to its beginning from the orbit of its origin: of a tow.
    after_launch : bool
        Whether the chaser was launched onto the origin.

    Raises
    ------
    ArithmeticError
        No trajectory was found.
    """
    first = next(at for at, burn in enumerate(leg.burns) if burn.phase == "approach")
    before, approach = leg.burns[:first], leg.burns[first:]
    start_s, standoff_s, docked_s = leg.burns[0].time_s, approach[0].time_s, approach[-1].time_s
    length = instance.transfer.standoff_m
    transfer, to_target = planned_angles(instance, leg, lead_in)
    rule = instance.transfer
    led = towed(instance, bodies, leg.origin, lead_in, start_s) if lead_in else None
    if led is None:
        start = bodies.state(leg.origin, start_s)
    else:
        start = moved(state_of(led.onward), start_s - led.released.time_s, bodies.gravity)
    course = LegEnds(
        start,
        bodies.following(leg.destination, standoff_s, length),
        start_s,
        standoff_s,
        transfer,
        bodies.gravity,
        EARTH_RADIUS_M + rule.min_altitude_m,
        EARTH_RADIUS_M + rule.max_altitude_m,
    )
    retargeted = aim(course, before)
    flown = cheapen(course, retargeted) if freedom == "free" else retargeted
    last = LegEnds(
        flown.states[-1],
        bodies.state(leg.destination, docked_s),
        standoff_s,
        docked_s,
        to_target,
        bodies.gravity,
    )
    docking = close(last, *with_a_middle(approach, to_target))
    phases = _phases(() if freedom == "free" else before, flown)
    burns = [*_burns(flown, phases), *_burns(docking, ["approach"] * docking.times.size)]
    misses = residual(course, flown), residual(last, docking)
    return RefinedLeg(
        leg=number,
        kind=leg.kind,
        origin=leg.origin,
        destination=leg.destination,
        ready_s=min(leg.ready_s, start_s) if led is None else start_s,
        standoff_s=standoff_s,
        arrival_s=docked_s,
        end_s=max(leg.end_s, docked_s),
        planned_delta_v_m_s=leg.delta_v_m_s,
        retargeted_delta_v_m_s=retargeted.delta_v_m_s + docking.delta_v_m_s,
        flown_delta_v_m_s=math.fsum(burn.size_m_s for burn in burns),
        lowest_altitude_m=flown.reach_m[0] - EARTH_RADIUS_M,
        residual_m=max(miss[0] for miss in misses),
        residual_m_s=max(miss[1] for miss in misses),
        burns=tuple(burns),
        states=tuple(_states(course, flown, docking)),
        tow_before=led,
        after_launch=True if after_launch and led is not None else None,
        tow=None if leg.tow is None else towed(instance, bodies, leg.destination, leg.tow.burns),
    )


def planned_angles(
    instance: Instance, leg: Leg, lead_in: tuple[Burn, ...] = ()
) -> tuple[float, float]:
    """Planned angles travelled by the chaser: to the stand-off, and from there on [rad]."""
    position, velocity = leaving_state(instance, leg, lead_in)
    angles, approaching = [0.0, 0.0], 0
    for burn, after in zip(leg.burns[:-1], leg.burns[1:], strict=True):
        if burn.phase == "approach":
            approaching = 1
        span = after.time_s - burn.time_s
        velocity = velocity + np.array(burn.delta_v_m_s)
        axis = 1.0 / (2.0 / math.hypot(*position) - float(velocity @ velocity) / MU_M3_S2)
        pace, node_rate = secular(position, velocity, instance.oblateness_m2)
        momentum = np.cross(position, velocity)
        # The latitude counts from the node, which drifts along the orbit meanwhile.
        rate = pace * math.sqrt(MU_M3_S2 / axis**3)
        rate += node_rate * momentum[2] / math.hypot(*momentum)
        angles[approaching] += rate * span
        positions, velocities = drift(position, velocity, span, instance.oblateness_m2)
        position, velocity = positions[0], velocities[0]
    return angles[0], angles[1]


def aim(course: LegEnds, burns: tuple[Burn, ...]) -> FlownImpulses:
    """The plan's burns, changed little; with some more if they cannot be closed.

    Weeks before its end a leg is far from linear in what a burn changes. What the plan is off by in
    eccentricity, above all, can be made up for at the end, by whichever impulses do it.
    """
    times = np.array([burn.time_s for burn in burns])
    planned = np.array([burn.delta_v_m_s for burn in burns])
    last_s = LAST_REVOLUTIONS * math.tau * math.sqrt(math.hypot(*course.goal[:3]) ** 3 / MU_M3_S2)
    from_s = max(course.start_s, course.end_s - last_s)
    for helping, evenly in (
        (np.empty(0), False),
        (np.linspace(course.start_s, course.end_s, HELPERS), False),
        (np.linspace(from_s, course.end_s, HELPERS), True),
    ):
        every = np.r_[times, helping]
        order = np.argsort(every, kind="stable")
        wanted = np.vstack([planned, np.zeros((helping.size, 3))])[order]
        try:
            closed = close(course, every[order], wanted, evenly=evenly)
        except NoWay as error:
            no_way = error
        else:
            return cheapest_near(course, closed, wanted)
    raise no_way


def with_a_middle(burns: tuple[Burn, ...], angle: float) -> tuple[Array, Array]:
    """Burns of the approach with another a quarter lap after the first.

    Half a lap after it an impulse across the plane has no effect: what the planes of the chaser
    and the target differ by, some decimetres, is closed between.
    """
    times = np.array([burn.time_s for burn in burns])
    impulses = np.array([burn.delta_v_m_s for burn in burns])
    quarter = times[0] + (times[-1] - times[0]) * 0.5 * math.pi / max(angle, math.pi)
    return np.insert(times, 1, quarter), np.insert(impulses, 1, 0.0, axis=0)


def _phases(burns: tuple[Burn, ...], flown: FlownImpulses) -> list[str]:
    """Phase of the plan's burn at each time; ``transfer`` where the plan has none."""
    known = {burn.time_s: burn.phase for burn in reversed(burns)}
    return [known.get(float(time), "transfer") for time in flown.times]


def _burns(flown: FlownImpulses, phases: list[str]) -> list[RefinedBurn]:
    return [
        RefinedBurn.model_validate(
            {"time_s": float(time), "delta_v_m_s": tuple(impulse.tolist()), "phase": phase}
        )
        for time, impulse, phase in zip(flown.times, flown.impulses, phases, strict=True)
    ]


def _states(course: LegEnds, flown: FlownImpulses, docking: FlownImpulses) -> list[RefinedState]:
    """States at departure, after each burn, at the stand-off, and docked."""
    found = [recorded("departure", course.start_s, course.start)]
    for part in (flown, docking):
        for time, before, impulse in zip(part.times, part.states[:-1], part.impulses, strict=True):
            after = before.copy()
            after[3:] += impulse
            found.append(recorded("burn", time, after))
        if part is flown:
            found.append(recorded("stand-off", course.end_s, part.states[-1]))
    # The last burn is at the target: what follows it is docked.
    found.append(recorded("arrival", docking.times[-1], docking.states[-1]))
    return found
