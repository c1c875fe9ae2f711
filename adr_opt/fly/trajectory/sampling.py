"""The flown plan, sampled: for each leg, the arcs between its burns.

A chaser waits at the origin of a leg, but where the leg follows upon a tow. One that has docked
before a window opens, or before the arrival that a drift is planned with, waits once more, at its
destination; and there, after the service, one that tows it.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from ...common.constants import DAY_S
from ...common.errors import InputError
from ...legs.service_limits import service_begins
from ...plan.after_tows import left_row
from ...plan.launched import as_launched
from ...plan.plan import Burn, Leg, Plan, Tow
from ...problem.instance import Instance
from ..flight.flyable import refuse_what_cannot_be_flown
from .bodies import after_burns, body_secular, body_states, leaving_state
from .kepler import Array, drift, secular

STEP_S, LONG_STEP_S, LONG_ARC_S = 60.0, 300.0, DAY_S
"""Default time between samples: the first, or the second on arcs longer than the third. A mission
of two years then has 200,000 states, not a million [s]."""

FEWEST_INTERVALS = 8
"""Least number of intervals of an arc: enough for interpolation by readers of the files."""

SHORTEST_ARC_S = 1e-3
"""Duration below which arcs are due to rounding: a wait for a node crossed just then, say."""

MOST_SAMPLES = 5_000_000


@dataclass(frozen=True)
class Arc:
    """Free motion between two burns, or rest at a body.

    Attributes
    ----------
    phase : str
        One of :data:`adr_opt.plan.phases.PHASES`.
    times_s : (n,) float64
        Since the epoch of the instance, evenly spaced, both ends included [s].
    positions_m : (n, 3) float64
        In the inertial frame of the elements [m].
    velocities_m_s : (n, 3) float64
        Within the plane of the orbit: what burns add to; after the burn at the beginning, before
        the one at the end [m/s].
    pace, node_rate_rad_s : float
        Under J2 the orbit is run through at this pace of two-body motion, and its plane turns
        about the axis of the Earth at this rate [–], [rad/s].
    """

    phase: str
    times_s: Array
    positions_m: Array
    velocities_m_s: Array
    pace: float = 1.0
    node_rate_rad_s: float = 0.0

    @property
    def rates_m_s(self) -> Array:
        """Rates of the positions: the velocities if no plane drifts, shape (n, 3) [m/s]."""
        if self.pace == 1.0 and self.node_rate_rad_s == 0.0:
            return self.velocities_m_s
        turning = np.cross([0.0, 0.0, self.node_rate_rad_s], self.positions_m)
        rates: Array = self.pace * self.velocities_m_s + turning
        return rates

    @property
    def start_s(self) -> float:
        """Start of the arc [s]."""
        return float(self.times_s[0])

    @property
    def end_s(self) -> float:
        """End of the arc [s]."""
        return float(self.times_s[-1])


@dataclass(frozen=True)
class LegPath:
    """Arcs of one leg in time order, each beginning where and when the previous one ends.

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
    chaser : str or None
        Whose legs they are; None where there is one chaser, or they are those of all.
    """

    instance: Instance
    plan: Plan
    step_s: float
    legs: tuple[LegPath, ...]
    chaser: str | None = None

    def arcs(self) -> Iterator[tuple[LegPath, Arc]]:
        """All arcs with their legs, in time order for each chaser."""
        for path in self.legs:
            for arc in path.arcs:
                yield path, arc

    @property
    def start_s(self) -> float:
        """Start of the first arc; 0 for a plan without legs [s]."""
        return min((path.arcs[0].start_s for path in self.legs), default=0.0)

    @property
    def end_s(self) -> float:
        """End of the last arc; 0 for a plan without legs [s]."""
        return max((path.arcs[-1].end_s for path in self.legs), default=0.0)


def sample(instance: Instance, plan: Plan, step_s: float | None = None) -> Trajectory:
    """Fly a plan in the dynamics of its instance and sample the flight.

    As :func:`adr_opt.fly.flight.fly` flies it: each leg begins on the origin's orbit, or where its
    tow leads, at its first burn, and its burns are taken from the plan as they are. After the last
    the chaser is docked, so that service, and the wait before the next leg, are on the
    destination's orbit; the step there is the residual of the approach, a few centimetres. Orbits
    of bodies are the circles
    that the plan is made with (docs/model.md section 1).

    Parameters
    ----------
    instance : Instance
    plan : Plan
        Need not be free of violations; a plan without legs gives no arcs.
    step_s : float, optional
        Largest time between two samples; by default :data:`STEP_S`, and :data:`LONG_STEP_S` on
        arcs that are longer than :data:`LONG_ARC_S` [s].

    Raises
    ------
    InputError
        The plan belongs to another instance or cannot be flown, the step is not a positive
        number, or there would be more than :data:`MOST_SAMPLES` samples.
    """
    if step_s is not None and not (step_s > 0.0 and math.isfinite(step_s)):
        raise InputError(f"step_s = {step_s:g}: must be a positive number of seconds")
    refuse_what_cannot_be_flown(instance, plan)
    instance = as_launched(instance, plan)
    total_s = sum(_span(leg) for leg in plan.legs)
    longest_s = LONG_STEP_S if step_s is None else step_s
    if not total_s / longest_s <= MOST_SAMPLES:
        raise InputError(
            f"a flight of {total_s:.3g} s, a state every {longest_s:g} s, would have more than "
            f"{MOST_SAMPLES:,} states; take a longer step, or correct the times of the plan"
        )
    lead_ins = plan.lead_ins
    paths = [
        LegPath(number, leg, _arcs(instance, number, leg, step_s, lead_ins.get(number, ())))
        for number, leg in enumerate(plan.legs, start=1)
    ]
    legs = tuple(path for path in paths if path.arcs)
    if step_s is None:
        arcs = [arc for path in legs for arc in path.arcs]
        step_s = max((_step(arc.end_s - arc.start_s, None) for arc in arcs), default=STEP_S)
    return Trajectory(instance, plan, float(step_s), legs)


def _span(leg: Leg) -> float:
    """Span from the earliest to the latest of a leg's times, even if out of order [s]."""
    times = [leg.ready_s, leg.leaves_s, leg.arrival_s, leg.done_s]
    return max(times) - min(times)


def _arcs(
    instance: Instance, number: int, leg: Leg, step_s: float | None, lead_in: tuple[Burn, ...]
) -> tuple[Arc, ...]:
    if leg.traits.from_nowhere:
        return tuple(_stay(instance, leg, step_s))
    found = []
    try:
        position, velocity = leaving_state(instance, leg, lead_in)
        times = None if lead_in else _times(leg.ready_s, leg.leaves_s, step_s)
        if times is not None:
            found.append(_at_body("wait", times, instance, leg.origin))
        if lead_in and left_row(instance, leg.origin, leg.departure_s) is not None:
            found += _released(
                instance, leg.origin, lead_in, (leg.departure_s, leg.leaves_s), step_s
            )
        for burn, after in pairwise(leg.impulses):
            end = after.time_s
            velocity = velocity + np.array(burn.delta_v_m_s)
            times = _times(burn.time_s, end, step_s)
            if times is None:
                continue
            oblateness = instance.oblateness_m2
            positions, velocities = drift(position, velocity, times - burn.time_s, oblateness)
            found.append(
                _arc(
                    burn.phase,
                    times,
                    positions,
                    velocities,
                    *secular(position, velocity, oblateness),
                )
            )
            position, velocity = positions[-1], velocities[-1]
        found += _stay(instance, leg, step_s)
    except ArithmeticError as error:
        raise InputError(f"leg {number}: cannot be flown: {error}; correct its burns") from None
    if not found:
        raise InputError(f"leg {number}: has no duration; correct its times")
    return tuple(found)


def _stay(instance: Instance, leg: Leg, step_s: float | None) -> Iterator[Arc]:
    """Stay from the end of a transfer to the end of the service, or of the tow."""
    begins = service_begins(instance, leg)
    for phase, since, until in (("wait", leg.docked_s, begins), ("service", begins, leg.end_s)):
        times = _times(since, until, step_s)
        if times is not None:
            yield _at_body(phase, times, instance, leg.destination)
    if leg.tow is None:
        return
    times = _times(leg.end_s, leg.tow.burns[0].time_s, step_s)
    if times is not None:
        yield _at_body("wait", times, instance, leg.destination)
    arc = _towed(instance, leg.destination, leg.tow, step_s)
    if arc is not None:
        yield arc
    span_s = leg.tow.burns[-1].time_s, leg.tow.end_s
    yield from _released(instance, leg.destination, leg.tow.burns, span_s, step_s)


def _towed(instance: Instance, body: str, tow: Tow, step_s: float | None) -> Arc | None:
    """The arc of a tow; None if its duration is negligible."""
    begin, end = tow.burns[0], tow.burns[-1]
    times = _times(begin.time_s, end.time_s, step_s)
    if times is None:
        return None
    _, position, velocity = after_burns(instance, body, tow.burns[:1])
    oblateness = instance.oblateness_m2
    positions, velocities = drift(position, velocity, times - begin.time_s, oblateness)
    return _arc("tow", times, positions, velocities, *secular(position, velocity, oblateness))


def _released(
    instance: Instance,
    body: str,
    burns: tuple[Burn, ...],
    span_s: tuple[float, float],
    step_s: float | None,
) -> Iterator[Arc]:
    """The wait between two times after the burns of a tow from apogee, if any."""
    times = _times(*span_s, step_s)
    if times is not None:
        now, position, velocity = after_burns(instance, body, burns)
        oblateness = instance.oblateness_m2
        positions, velocities = drift(position, velocity, times - now, oblateness)
        pace = secular(position, velocity, oblateness)
        yield _arc("wait", times, positions, velocities, *pace)


def _step(duration_s: float, step_s: float | None) -> float:
    """Largest time between two samples of an arc [s]."""
    if step_s is not None:
        return step_s
    return STEP_S if duration_s <= LONG_ARC_S else LONG_STEP_S


def _times(start: float, end: float, step_s: float | None) -> Array | None:
    duration = end - start
    if not duration >= SHORTEST_ARC_S:
        return None
    intervals = math.ceil(duration / _step(duration, step_s))
    return np.linspace(start, end, 1 + max(FEWEST_INTERVALS, intervals))


def _at_body(phase: str, times: Array, instance: Instance, body: str) -> Arc:
    return _arc(phase, times, *body_states(instance, body, times), *body_secular(instance, body))


def _arc(
    phase: str, times: Array, positions: Array, velocities: Array, pace: float, node_rate: float
) -> Arc:
    for array in (times, positions, velocities):
        array.setflags(write=False)
    return Arc(phase, times, positions, velocities, pace, node_rate)
