"""The flown plan, sampled: per leg, the arcs between its burns."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from ..errors import InputError
from ..flight.flyable import refuse_what_cannot_be_flown
from ..instance import Instance
from ..kernels.burns import PHASES as BURN_PHASES
from ..limits import service_begins
from ..plan import Leg, Plan
from .bodies import body_states
from .kepler import Array, drift

PHASES = ("wait", *BURN_PHASES, "service")
"""Phases of a leg in their order: waiting at the origin, five of flight, service at the end.

A chaser that arrives before a window opens waits once more, at its destination."""

FEWEST_INTERVALS = 8
"""Of an arc, however short: enough for any interpolation that readers of the files do."""

SHORTEST_ARC_S = 1e-3
"""Shorter arcs are rounding: a wait for a node that is crossed just then, for example."""

MOST_SAMPLES = 5_000_000


@dataclass(frozen=True)
class Arc:
    """Free motion between two burns, or rest at a body.

    Attributes
    ----------
    phase : str
        One of :data:`PHASES`.
    times_s : (n,) float64
        Since the epoch of the instance, evenly spaced, both ends included [s].
    positions_m : (n, 3) float64
        In the inertial frame of the elements [m].
    velocities_m_s : (n, 3) float64
        After the burn at the beginning, before the one at the end [m/s].
    """

    phase: str
    times_s: Array
    positions_m: Array
    velocities_m_s: Array

    @property
    def start_s(self) -> float:
        """When it begins [s]."""
        return float(self.times_s[0])

    @property
    def end_s(self) -> float:
        """When it ends [s]."""
        return float(self.times_s[-1])


@dataclass(frozen=True)
class LegPath:
    """The arcs of one leg in time order; each begins where and when the one before ends.

    Attributes
    ----------
    number : int
        From 1.
    leg : Leg
        As in the plan.
    arcs : tuple of Arc
        Phases that take no time are left out.
    """

    number: int
    leg: Leg
    arcs: tuple[Arc, ...]


@dataclass(frozen=True)
class Trajectory:
    """The flown plan.

    Attributes
    ----------
    instance : Instance
    plan : Plan
    step_s : float
        Largest time between two samples [s].
    legs : tuple of LegPath
    """

    instance: Instance
    plan: Plan
    step_s: float
    legs: tuple[LegPath, ...]

    def arcs(self) -> Iterator[tuple[LegPath, Arc]]:
        """All arcs in time order, each with its leg."""
        for path in self.legs:
            for arc in path.arcs:
                yield path, arc

    @property
    def start_s(self) -> float:
        """When the first arc begins; 0 for a plan without legs [s]."""
        return self.legs[0].arcs[0].start_s if self.legs else 0.0

    @property
    def end_s(self) -> float:
        """When the last arc ends; 0 for a plan without legs [s]."""
        return self.legs[-1].arcs[-1].end_s if self.legs else 0.0


def sample(instance: Instance, plan: Plan, step_s: float = 60.0) -> Trajectory:
    """Fly a plan in the dynamics of its instance and sample the flight.

    As :func:`adr_opt.flight.fly` flies it: each leg begins on the origin's orbit, at its first
    burn, and its burns are taken from the plan as they are. At the arrival the chaser is docked,
    so that service, and the wait before the next leg, are on the destination's orbit; the step
    there is the residual of the approach, a few centimetres. Orbits of bodies are the circles
    that the plan is made with (MODEL section 1).

    Parameters
    ----------
    instance : Instance
    plan : Plan
        Need not be free of violations; a plan without legs gives no arcs.
    step_s : float
        Largest time between two samples [s].

    Raises
    ------
    InputError
        The plan belongs to another instance or cannot be flown, the step is not a positive
        number, or there would be more than :data:`MOST_SAMPLES` samples.
    """
    if not (step_s > 0.0 and math.isfinite(step_s)):
        raise InputError(f"step_s = {step_s:g}: must be a positive number of seconds")
    refuse_what_cannot_be_flown(instance, plan)
    total_s = sum(_span(leg) for leg in plan.legs)
    if not total_s / step_s <= MOST_SAMPLES:
        raise InputError(
            f"a flight of {total_s:.3g} s, a state every {step_s:g} s, would have more than "
            f"{MOST_SAMPLES:,} states; take a longer step, or correct the times of the plan"
        )
    return Trajectory(
        instance,
        plan,
        float(step_s),
        tuple(
            LegPath(number, leg, _arcs(instance, number, leg, step_s))
            for number, leg in enumerate(plan.legs, start=1)
        ),
    )


def _span(leg: Leg) -> float:
    """From the first to the last of a leg's times, whatever their order in a spoiled plan [s]."""
    times = [leg.ready_s, leg.burns[0].time_s, leg.arrival_s, leg.end_s]
    return max(times) - min(times)


def _arcs(instance: Instance, number: int, leg: Leg, step_s: float) -> tuple[Arc, ...]:
    found = []
    start = leg.burns[0].time_s
    times = _times(leg.ready_s, start, step_s)
    if times is not None:
        found.append(_arc("wait", times, *body_states(instance, leg.origin, times)))
    position, velocity = (state[0] for state in body_states(instance, leg.origin, start))
    ends = [*(burn.time_s for burn in leg.burns[1:]), leg.arrival_s]
    try:
        for burn, end in zip(leg.burns, ends, strict=True):
            velocity = velocity + np.array(burn.delta_v_m_s)
            times = _times(burn.time_s, end, step_s)
            if times is None:
                continue
            positions, velocities = drift(
                position, velocity, times - burn.time_s, instance.oblateness_m2
            )
            found.append(_arc(burn.phase, times, positions, velocities))
            position, velocity = positions[-1], velocities[-1]
    except ArithmeticError as error:
        raise InputError(f"leg {number}: cannot be flown: {error}; correct its burns") from None
    begins = service_begins(instance, leg)
    for phase, since, until in (("wait", leg.arrival_s, begins), ("service", begins, leg.end_s)):
        times = _times(since, until, step_s)
        if times is not None:
            found.append(_arc(phase, times, *body_states(instance, leg.destination, times)))
    if not found:
        raise InputError(f"leg {number}: takes no time; correct its times")
    return tuple(found)


def _times(start: float, end: float, step_s: float) -> Array | None:
    duration = end - start
    if not duration >= SHORTEST_ARC_S:
        return None
    return np.linspace(start, end, 1 + max(FEWEST_INTERVALS, math.ceil(duration / step_s)))


def _arc(phase: str, times: Array, positions: Array, velocities: Array) -> Arc:
    for array in (times, positions, velocities):
        array.setflags(write=False)
    return Arc(phase, times, positions, velocities)
