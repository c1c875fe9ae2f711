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
from .bodies import Gravity, moved
from .states import state_of
from .thrust_states import thrust_states


@dataclass(frozen=True)
class EphemerisTrack:
    """A coast without burns, and a description of its context."""

    comment: str
    arc: Arc


def tracks(
    refined: RefinedPlan,
    *,
    body: str | None = None,
    step_s: float | None = None,
    leg: int | None = None,
    chaser: str | None = None,
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

    Raises
    ------
    InputError
        No legs, no such leg or body, a step that is not positive, or too many states.
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
    states = {one.name: state_of(one) for one in refined.bodies}
    if body is not None:
        if body not in states:
            raise InputError(f"{body!r} is not a body that the refined plan visits")
        begin = moved(states[body], start, refined.gravity)
        arc = _arc("service", start, begin, end, step, refined.gravity)
        return (EphemerisTrack(f"{body}, from the state at the epoch", arc),) if arc else ()
    return tuple(track for one in legs for track in _of_leg(refined, states, one, step))


def _of_leg(
    refined: RefinedPlan, states: dict[str, Array], leg: RefinedLeg, step: float
) -> Iterator[EphemerisTrack]:
    name = f"leg {leg.leg}, {leg.origin} to {leg.destination}"
    for arc, with_thrust in _arcs(refined, states, leg, step):
        if arc is not None:
            said = ", with low thrust" if with_thrust else ""
            yield EphemerisTrack(f"{name}: {arc.phase}{said}", arc)


def _arcs(
    refined: RefinedPlan, states: dict[str, Array], leg: RefinedLeg, step: float
) -> Iterator[tuple[Arc | None, bool]]:
    """Arcs of a leg, and whether each has low thrust; None where one is too short."""
    gravity, departure_s = refined.gravity, leg.states[0].time_s

    def coast(phase: str, start_s: float, state: Array, end_s: float) -> tuple[Arc | None, bool]:
        return _arc(phase, start_s, state, end_s, step, gravity), False

    def towing(body: str, tow: RefinedTow) -> tuple[Arc | None, bool]:
        state, end_s = moved(states[body], tow.start_s, gravity), tow.released.time_s
        if tow.thrust is not None:
            return _thrusting("tow", tow.thrust, state, (tow.start_s, end_s), step, gravity), True
        state[3:] += tow.burns[0].delta_v_m_s
        return coast("tow", tow.start_s, state, end_s)

    if leg.tow_before is None:
        waiting = moved(states[leg.origin], leg.ready_s, gravity)
        yield coast("wait", leg.ready_s, waiting, departure_s)
    elif leg.after_launch:
        yield towing(leg.origin, leg.tow_before)
    state, now, phase = state_of(leg.states[0]), departure_s, "transfer"
    if leg.thrust is not None:
        arc = _thrusting(phase, leg.thrust, state, (now, leg.standoff_s), step, gravity)
        yield arc, True
        state, now = np.r_[arc.positions_m[-1], arc.velocities_m_s[-1]], leg.standoff_s
    for burn in leg.burns:
        yield coast(phase, now, state, burn.time_s)
        state = moved(state, burn.time_s - now, gravity)
        state[3:] += burn.delta_v_m_s
        now, phase = burn.time_s, burn.phase
    target = moved(states[leg.destination], leg.arrival_s, gravity)
    yield coast("service", leg.arrival_s, target, leg.end_s)
    if leg.tow is not None:
        waiting = moved(states[leg.destination], leg.end_s, gravity)
        yield coast("wait", leg.end_s, waiting, leg.tow.start_s)
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
    times = np.linspace(begin, end, max(FEWEST_INTERVALS, math.ceil((end - begin) / step)) + 1)
    found = thrust_states(thrust, state, begin, times, gravity)
    for array in (times, found):
        array.setflags(write=False)
    return Arc(phase, times, found[:, :3], found[:, 3:])


def _arc(
    phase: str, start: float, state: Array, end: float, step: float, gravity: Gravity
) -> Arc | None:
    if not end - start >= SHORTEST_ARC_S:
        return None
    count = max(FEWEST_INTERVALS, math.ceil((end - start) / step))
    times = np.linspace(start, end, count + 1)
    found = np.empty((times.size, 6))
    found[0] = state
    for at in range(1, times.size):
        found[at] = moved(found[at - 1], times[at] - times[at - 1], gravity)
    for array in (times, found):
        array.setflags(write=False)
    return Arc(phase, times, found[:, :3], found[:, 3:])
