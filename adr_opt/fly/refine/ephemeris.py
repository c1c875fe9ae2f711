"""A refined plan as states over time, of the chaser or of a visited body."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from ...common.errors import InputError
from ...kernels.orbits.short_periods import Array
from ...plan.refined_plan import RefinedLeg, RefinedPlan, RefinedTow
from ...plan.refined_thrust import RefinedThrust
from ..trajectory.sampling import FEWEST_INTERVALS, MOST_SAMPLES, SHORTEST_ARC_S, STEP_S, Arc
from .bodies import Gravity, Whereabouts, moved, state_of
from .thrust_record import thrust_states


@dataclass(frozen=True)
class EphemerisTrack:
    """A coast without burns, and a description of its context.

    ``reported`` says that its states are those of an ephemeris, whose velocities need not be the
    derivatives of the positions.
    """

    comment: str
    arc: Arc
    reported: bool = False


def tracks(
    refined: RefinedPlan,
    *,
    body: str | None = None,
    step_s: float | None = None,
    leg: int | None = None,
    chaser: str | None = None,
    bodies: Whereabouts | None = None,
) -> tuple[EphemerisTrack, ...]:
    """The flight of a refined plan, arc by arc.

    Parameters
    ----------
    refined : RefinedPlan
    body : str, optional
        A visited body, from the first to the last time of the legs; the chaser by default.
    step_s : float, optional
        Largest time between two states [s]; a minute by default.
    leg : int, optional
        Only this leg, by its number in the plan.
    chaser : str, optional
        Only the legs of this one of several chasers.
    bodies : Whereabouts, optional
        Where they are; needed for a plan that was refined onto ephemerides.

    Raises
    ------
    InputError
        No ephemerides of a plan refined onto them, no legs, no such leg or body, a step that is
        not positive, or too many states.
    """
    step = STEP_S if step_s is None else step_s
    if not (step > 0.0 and math.isfinite(step)):
        raise InputError(f"step_s = {step:g}: must be a positive number of seconds")
    legs = [one for one in refined.legs if leg in (None, one.leg) and chaser in (None, one.chaser)]
    if not legs and leg is None and refined.legs:
        raise InputError(f"{chaser!r} has no refined legs: there is nothing to export")
    if not legs:
        raise InputError(
            "the refined plan has no legs: there is nothing to export"
            if leg is None
            else f"leg = {leg}: the refined plan has no such leg"
        )
    start, end = min(one.ready_s for one in legs), max(one.done_s for one in legs)
    if not (end - start) / step <= MOST_SAMPLES:
        raise InputError(
            f"{end - start:.3g} s, a state every {step:g} s, would be more than {MOST_SAMPLES:,} "
            "states; take a longer step"
        )
    if bodies is None:
        if refined.ephemerides is not None:
            raise InputError(
                "the plan was refined onto ephemerides; give the whereabouts of bodies"
            )
        bodies = Whereabouts(refined, {})
    if body is not None:
        if body not in bodies.bodies:
            raise InputError(f"{body!r} is not a body that the refined plan visits")
        arc = _docked("service", body, bodies, (start, end), step)
        said = f"{body}, {bodies.source_of(body)}"
        return (EphemerisTrack(said, arc, bodies.is_reported(body)),) if arc else ()
    return tuple(track for one in legs for track in _of_leg(bodies, one, step))


def _of_leg(bodies: Whereabouts, leg: RefinedLeg, step: float) -> Iterator[EphemerisTrack]:
    name = f"leg {leg.leg}, {leg.origin} to {leg.destination}"
    beside = {"wait": leg.origin, "service": leg.destination}
    for arc, with_thrust in _arcs(bodies, leg, step):
        if arc is not None:
            said = ", with low thrust" if with_thrust else ""
            reported = arc.phase in beside and bodies.is_reported(beside[arc.phase])
            yield EphemerisTrack(f"{name}: {arc.phase}{said}", arc, reported)


def _arcs(bodies: Whereabouts, leg: RefinedLeg, step: float) -> Iterator[tuple[Arc | None, bool]]:
    """Arcs of a leg, and whether each has low thrust; None where one is too short."""
    gravity, departure_s = bodies.gravity, leg.states[0].time_s

    def coast(phase: str, start_s: float, state: Array, end_s: float) -> tuple[Arc | None, bool]:
        return _arc(phase, start_s, state, end_s, step, gravity), False

    def docked(phase: str, body: str, start_s: float, end_s: float) -> tuple[Arc | None, bool]:
        return _docked(phase, body, bodies, (start_s, end_s), step), False

    def towing(body: str, tow: RefinedTow) -> tuple[Arc | None, bool]:
        state, end_s = bodies.state(body, tow.start_s), tow.released.time_s
        if tow.thrust is not None:
            return _thrusting("tow", tow.thrust, state, (tow.start_s, end_s), step, gravity), True
        state[3:] += tow.burns[0].delta_v_m_s
        return coast("tow", tow.start_s, state, end_s)

    def waiting(tow: RefinedTow, end_s: float) -> tuple[Arc | None, bool]:
        return coast("wait", tow.released.time_s, state_of(tow.onward), end_s)

    if leg.tow_before is None:
        yield docked("wait", leg.origin, leg.ready_s, departure_s)
    else:
        if leg.after_launch:
            yield towing(leg.origin, leg.tow_before)
        yield waiting(leg.tow_before, departure_s)
    state, now, phase = state_of(leg.states[0]), departure_s, "transfer"
    if leg.thrust is not None:
        arc = _thrusting(phase, leg.thrust, state, (now, leg.standoff_s), step, gravity)
        yield arc, True
        state, now = np.r_[arc.positions_m[-1], arc.velocities_m_s[-1]], leg.standoff_s
    for burn in leg.burns:
        yield coast(phase, now, state, burn.time_s)
        state = moved(state, burn.time_s - now, gravity)
        state[3:] += burn.delta_v_m_s
        now = burn.time_s
        phase = "approach" if now >= leg.standoff_s else burn.phase
    yield docked("service", leg.destination, leg.arrival_s, leg.end_s)
    if leg.tow is not None:
        yield docked("wait", leg.destination, leg.end_s, leg.tow.start_s)
        yield towing(leg.destination, leg.tow)


def _thrusting(
    phase: str,
    thrust: RefinedThrust,
    state: Array,
    span_s: tuple[float, float],
    step: float,
    gravity: Gravity,
) -> Arc:
    """A flight with low thrust, in one piece."""
    begin, end = span_s
    times = _times(begin, end, step)
    return _made(phase, times, thrust_states(thrust, state, begin, times, gravity))


def _docked(
    phase: str, body: str, bodies: Whereabouts, span_s: tuple[float, float], step: float
) -> Arc | None:
    """A time beside a body; None if it is too short."""
    begin, end = span_s
    if not end - begin >= SHORTEST_ARC_S:
        return None
    times = _times(begin, end, step)
    return _made(phase, times, bodies.along(body, times))


def _arc(
    phase: str, start: float, state: Array, end: float, step: float, gravity: Gravity
) -> Arc | None:
    if not end - start >= SHORTEST_ARC_S:
        return None
    times = _times(start, end, step)
    found = np.empty((times.size, 6))
    found[0] = state
    for at in range(1, times.size):
        found[at] = moved(found[at - 1], times[at] - times[at - 1], gravity)
    return _made(phase, times, found)


def _times(begin: float, end: float, step: float) -> Array:
    count = max(FEWEST_INTERVALS, math.ceil((end - begin) / step))
    return np.linspace(begin, end, count + 1)


def _made(phase: str, times: Array, found: Array) -> Arc:
    for array in (times, found):
        array.setflags(write=False)
    return Arc(phase, times, found[:, :3], found[:, 3:])
