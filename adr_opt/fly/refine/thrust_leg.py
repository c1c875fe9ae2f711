"""Refinement of one leg of low thrust: two arcs to the stand-off, and impulses of the approach."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from ...common.constants import EARTH_RADIUS_M
from ...kernels.orbits import thrusting
from ...kernels.orbits.gravity import FIELDS
from ...kernels.orbits.short_periods import Array
from ...plan.plan import Leg
from ...plan.refined_plan import RefinedBurn, RefinedLeg
from ...plan.refined_thrust import RefinedThrust
from ...problem.instance import Instance
from .bodies import TrueBodies, moved, recorded, state_of
from .leg import FlownImpulses, LegEnds, close, residual
from .spiral import SpiralTow, towed_by_spiral
from .thrust_guess import first_guess
from .thrust_record import steered_arcs
from .thrust_search import candidates, closed, closed_again
from .thrust_task import Integration, Programme, Propelled, ThrustTask

MOST_WINDOWS = 40000
"""Maximum number of windows of thrust in a leg."""

LESSONS = 2
"""Number of integrated flights used to correct the prediction of a programme."""

APPROACH_BURNS = 3
"""Number of impulses of the approach, initially a quarter of it apart."""


class Tows(NamedTuple):
    """Spirals next to a leg.

    Attributes
    ----------
    before, after : SpiralTow or None
        Of its origin and of its destination.
    after_launch : bool
        Whether the chaser was launched onto the origin.
    """

    before: SpiralTow | None
    after: SpiralTow | None
    after_launch: bool


NO_TOWS = Tows(None, None, after_launch=False)


def refine_thrust_leg(
    instance: Instance,
    bodies: TrueBodies,
    number: int,
    leg: Leg,
    chaser: Propelled,
    tows: Tows = NO_TOWS,
) -> RefinedLeg:
    """Guide one leg of low thrust to its stand-off, and from there to its target.

    Parameters
    ----------
    instance : Instance
    bodies : TrueBodies
        With the origin and the destination.
    number : int
        From 1.
    leg : Leg
        With two arcs.
    chaser : Propelled
    tows : Tows, optional
        Spirals before and after the leg.

    Raises
    ------
    ArithmeticError
        No trajectory was found.
    """
    assert leg.manoeuvres is not None
    start_s, standoff_s, docked_s = leg.departure_s, leg.manoeuvres[-1].end_s, leg.arrival_s
    led = None if tows.before is None else towed_by_spiral(bodies, tows.before)
    if led is None:
        start = bodies.state(leg.origin, start_s)
    else:
        start = moved(state_of(led.released), start_s - led.released.time_s, bodies.gravity)
    length = instance.transfer.standoff_m
    goal = bodies.following(leg.destination, standoff_s, length)
    for push in chaser.pushes():
        task = ThrustTask(start, goal, start_s, standoff_s, push, bodies.gravity)
        task = task.learnt(first_guess(task, leg.manoeuvres))
        for guess in candidates(task, leg.manoeuvres):
            near, known = guess, task
            for _ in range(LESSONS):
                known = known.learnt(near)
                near = closed_again(known, near)
            programme = closed(known, near)
            if programme is not None:
                found = _recorded(number, leg, task, programme, _Approach(bodies, leg, docked_s))
                return found.replace(
                    ready_s=found.ready_s if led is None else start_s,
                    tow_before=led,
                    after_launch=True if tows.after_launch and led is not None else None,
                    tow=None if tows.after is None else towed_by_spiral(bodies, tows.after),
                )
    raise ArithmeticError("no arcs of thrust were found that reach the stand-off in time")


@dataclass(frozen=True)
class _Approach:
    """The way from the stand-off to the target."""

    bodies: TrueBodies
    leg: Leg
    docked_s: float

    def made(self, begin: Array, begin_s: float) -> tuple[LegEnds, FlownImpulses]:
        """Impulses of little ΔV that complete the approach."""
        goal = self.bodies.state(self.leg.destination, self.docked_s)
        turned = math.sqrt(float(begin[3:] @ begin[3:]) / float(begin[:3] @ begin[:3]))
        angle = turned * (self.docked_s - begin_s)
        course = LegEnds(begin, goal, begin_s, self.docked_s, angle, self.bodies.gravity)
        times = np.array([begin_s, begin_s + 0.25 * (self.docked_s - begin_s), self.docked_s])
        return course, close(course, times, np.zeros((APPROACH_BURNS, 3)), evenly=True)


def _recorded(
    number: int, leg: Leg, task: ThrustTask, programme: Programme, approach: _Approach
) -> RefinedLeg:
    """The leg in the form of a refined plan."""
    flown = task.integrate(programme, np.empty((MOST_WINDOWS, 3)))
    last, docking = approach.made(flown.end, task.end_s)
    burns = tuple(
        RefinedBurn(time_s=float(time), delta_v_m_s=tuple(impulse.tolist()), phase="approach")
        for time, impulse in zip(docking.times, docking.impulses, strict=True)
    )
    states = [recorded("departure", task.start_s, task.start)]
    states.append(recorded("stand-off", task.end_s, flown.end))
    for time, before, impulse in zip(
        docking.times, docking.states[:-1], docking.impulses, strict=True
    ):
        after = before.copy()
        after[3:] += impulse
        states.append(recorded("burn", time, after))
    states.append(recorded("arrival", docking.times[-1], docking.states[-1]))
    missed = flown.end - task.goal
    misses = (math.hypot(*missed[:3]), math.hypot(*missed[3:])), residual(last, docking)
    thrust = _thrust(task, programme, flown, docking.delta_v_m_s)
    spent = math.fsum((thrust.delta_v_m_s, *(burn.size_m_s for burn in burns)))
    return RefinedLeg(
        leg=number,
        kind=leg.kind,
        origin=leg.origin,
        destination=leg.destination,
        ready_s=min(leg.ready_s, task.start_s),
        standoff_s=task.end_s,
        arrival_s=float(docking.times[-1]),
        end_s=max(leg.end_s, float(docking.times[-1])),
        planned_delta_v_m_s=leg.delta_v_m_s,
        retargeted_delta_v_m_s=spent,
        flown_delta_v_m_s=spent,
        lowest_altitude_m=_lowest_m(task, programme, flown) - EARTH_RADIUS_M,
        residual_m=max(miss[0] for miss in misses),
        residual_m_s=max(miss[1] for miss in misses),
        burns=burns,
        states=tuple(states),
        thrust=thrust,
    )


def _thrust(
    task: ThrustTask, programme: Programme, flown: Integration, approach_m_s: float
) -> RefinedThrust:
    """Arcs with their windows, and the propellant of the leg."""
    push = task.push
    arcs = steered_arcs(push, programme.laws, flown.windows)
    left = flown.mass_kg * math.exp(-approach_m_s / push.exhaust)
    return RefinedThrust(
        force_n=push.force,
        exhaust_m_s=push.exhaust,
        mass_kg=push.mass,
        propellant_kg=push.mass - left,
        arcs=arcs,
    )


def _lowest_m(task: ThrustTask, programme: Programme, flown: Integration) -> float:
    """Lowest perigee of the origin's orbit, the drift orbit and the target's [m]."""
    perigees = []
    ends = [task.start_s, programme.second_s, task.end_s]
    now = thrusting.elements_of(task.start, task.start_s)
    thrusting.fly(
        now, ends[1], task.push, task.arcs(programme), FIELDS[task.gravity], np.empty((0, 3))
    )
    for state in (task.start, thrusting.state_of(now), flown.end):
        p, f, g = thrusting.elements_of(state, 0.0)[:3]
        perigees.append(p / (1.0 + math.hypot(f, g)))
    return float(min(perigees))
