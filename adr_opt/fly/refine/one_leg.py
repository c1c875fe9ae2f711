"""Refinement of one leg: from the docked start via the stand-off to the target."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from ...common.constants import EARTH_RADIUS_M, MU_M3_S2
from ...kernels.orbits.short_periods import Array
from ...plan.plan import Burn, Leg
from ...plan.refined_plan import Freedom, RefinedBurn, RefinedLeg, RefinedState
from ...problem.approach import approach_of
from ...problem.instance import Instance
from ...problem.settings import SequenceSettings
from ..trajectory.bodies import leaving_state
from ..trajectory.kepler import drift, secular
from .bodies import MovingBodies, moved, recorded, state_of
from .leg import FlownImpulses, LegEnds, NoWay, cheapen, close, residual
from .own_burns import cheapest_near
from .tow import towed

HELPERS = 24
"""Number of times for additional impulses if the plan's own burns cannot be closed."""

LAST_REVOLUTIONS = 2
"""Number of revolutions before the stand-off in which to place them if that fails, too."""


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
    before, approach = parted(leg)
    start_s, standoff_s, docked_s = leg.leaves_s, approach[0].time_s, leg.docked_s
    length = instance.transfer.standoff_m
    transfer, to_target = planned_angles(instance, leg, lead_in)
    rule = instance.transfer
    led = towed(instance, bodies, leg.origin, lead_in, start_s) if lead_in else None
    if led is None:
        start = bodies.state(leg.origin, start_s)
    else:
        start = moved(state_of(led.onward), start_s - led.released.time_s, bodies.gravity)
    last = LegEnds(
        bodies.following(leg.destination, standoff_s, length),
        bodies.state(leg.destination, docked_s),
        standoff_s,
        docked_s,
        to_target,
        bodies.gravity,
    )
    begins = first_of_approach(last, rule, approach)
    course = LegEnds(
        start,
        last.start + np.r_[np.zeros(3), begins],
        start_s,
        standoff_s,
        transfer,
        bodies.gravity,
        EARTH_RADIUS_M + rule.min_altitude_m,
        EARTH_RADIUS_M + rule.max_altitude_m,
    )
    retargeted = aim(course, before)
    flown = cheapen(course, retargeted) if freedom == "free" else retargeted
    last = replace(last, start=flown.states[-1])
    docking = docked(last, rule, approach)
    phases = _phases(() if freedom == "free" else leg.burns, flown)
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
        approach_m_s=tuple(begins.tolist()),
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
    """The plan's burns, changed as little as possible; with extra ones if they cannot be closed.

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


def parted(leg: Leg) -> tuple[tuple[Burn, ...], tuple[Burn, ...]]:
    """Impulses up to the stand-off, the vector there included, and burns of the approach."""
    before = tuple(burn for burn in leg.impulses if burn.time_s <= (leg.standoff_s or 0.0))
    return before, tuple(burn for burn in leg.burns if burn.phase == "approach")


def first_of_approach(last: LegEnds, settings: SequenceSettings, burns: tuple[Burn, ...]) -> Array:
    """First burn of an approach from rest at the stand-off, shape (3,) [m/s].

    The transfer ends with it: its last impulse is one vector with this.
    """
    if settings.approach == "half-lap":
        begins: Array = close(last, *_with_a_middle(burns, last.angle), evenly=True).impulses[0]
        return begins
    return _by_rule(last, approach_of(settings).burns[0], last.start)


def docked(last: LegEnds, settings: SequenceSettings, burns: tuple[Burn, ...]) -> FlownImpulses:
    """The rest of an approach that has begun."""
    if settings.approach == "half-lap":
        times, impulses = _with_a_middle(burns, last.angle)
        return close(last, times[1:], impulses[1:], evenly=True)
    return _round_the_target(last, settings, [burn.time_s for burn in burns])


def _with_a_middle(burns: tuple[Burn, ...], angle: float) -> tuple[Array, Array]:
    """Burns of the approach with another a quarter lap after the first.

    Half a lap after it an impulse across the plane has no effect, and on an ellipse next to none:
    what the planes of the chaser and the target differ by, some decimetres, is closed between. So
    changes are shared out evenly, and not by the size of burns.
    """
    times = np.array([burn.time_s for burn in burns])
    impulses = np.array([burn.delta_v_m_s for burn in burns])
    if times.size > 2:  # a safety ellipse has burns across the plane
        return times, impulses
    quarter = times[0] + (times[-1] - times[0]) * 0.5 * math.pi / max(angle, math.pi)
    return np.insert(times, 1, quarter), np.insert(impulses, 1, 0.0, axis=0)


def _by_rule(last: LegEnds, row: Array, state: Array) -> Array:
    """A burn of a safety ellipse at a state, by its row of :class:`.Approach`, (3,) [m/s]."""
    axis = 1.0 / (
        2.0 / math.hypot(*last.goal[:3]) - float(last.goal[3:] @ last.goal[3:]) / MU_M3_S2
    )
    n, speed = math.sqrt(MU_M3_S2 / axis**3), math.hypot(*state[3:])
    ahead, normal = state[3:] / speed, np.cross(state[:3], state[3:])
    normal /= math.hypot(*normal)
    outward = np.cross(ahead, normal)
    made: Array = n * (row[1] * outward + row[2] * (n * axis / speed) * ahead + row[3] * normal)
    return made


def _round_the_target(
    last: LegEnds, settings: SequenceSettings, times_s: Sequence[float]
) -> FlownImpulses:
    """A safety ellipse after its first burn: by rule, and a capture that ends at the target.

    No burn before the capture is changed to reach anything: what keeps the chaser clear of the
    target if one is missed is their pattern.
    """
    rows = approach_of(settings).burns
    state, now, before, made = last.start, last.start_s, [], []
    for row, time_s in zip(rows[1:-2], times_s[1:], strict=False):
        state, now = moved(state, time_s - now, last.gravity), time_s
        before.append(state.copy())
        made.append(_by_rule(last, row, state))
        state = state.copy()
        state[3:] += made[-1]
    begin_s, end_s = times_s[-2:]
    state = moved(state, begin_s - now, last.gravity)
    angle = last.angle * (end_s - begin_s) / (last.end_s - last.start_s)
    capture = replace(last, start=state, start_s=begin_s, angle=angle)
    at = np.array([begin_s, 0.5 * (begin_s + end_s), end_s])
    towards = np.zeros((3, 3))
    towards[0] = _by_rule(last, rows[-2] * [0.0, 0.0, 0.0, 1.0, 0.0], state)
    closed = close(capture, at, towards, evenly=True)
    return FlownImpulses(
        np.r_[times_s[1:-2], closed.times],
        np.vstack([made, closed.impulses]),
        np.vstack([before, closed.states]),
        closed.effects,
        closed.miss,
    )


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
