"""One leg flown many times with errors.

A few of the flights are repeated without linearisation, as a reference for the feedback: all states
are integrated, and before each burn those that are left are targeted anew as they would be on
board: the least squares of :mod:`.feedback` by Gauss's and Newton's steps, with the miss of the
step before, found by flying it.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import NamedTuple

import numpy as np

from ...common.constants import MU_M3_S2
from ...common.errors import InputError
from ...kernels.orbits import coast, equinoctial
from ...kernels.orbits.gravity import FIELDS
from ...kernels.orbits.short_periods import Array
from ...plan.refined_plan import RefinedLeg
from ..refine.bodies import Gravity, state_of
from .displaced import DisplacedBodies
from .errors import FlightErrors
from .feedback import PLANNED, BodiesOff, LegPart, UncertainEnds, fly, parts_of

STEPS = 3
"""Number of targeting steps before each burn."""


def fly_exactly(
    part: LegPart, begun: Array, drawn: Array, errors: FlightErrors, off: BodiesOff | None = None
) -> tuple[float, Array]:
    """Fly a part of a leg once.

    Parameters
    ----------
    part : LegPart
    begun : (6,) float64
        By how much the flight is off at the beginning [m, m/s].
    drawn : (burns, 3) float64
        Standard normal numbers.
    errors : FlightErrors
    off : BodiesOff, optional
        Of the bodies, each of shape (6,).

    Returns
    -------
    float
        ΔV [m/s].
    (6,) float64
        The state at the end less that of the refined plan, or less that of the stand-off where
        the destination is [m, m/s].

    Raises
    ------
    ArithmeticError
        It leads away from the Earth or into its centre.
    """
    zonals, none = FIELDS[part.gravity], np.empty((0, 0))
    docked, goal, moved_target = part.start, part.goal, np.zeros(6)
    if off is not None:
        docked, goal, moved_target = moved(docked, off.origin), moved(goal, off.target), off.target
    now, angle, spent = docked + begun, 0.0, 0.0
    last = part.times.size - 1
    for at, impulse in enumerate(part.impulses):
        if at < part.seen and part.gains[at] is not None:
            known = docked.copy()  # no burn before this one is seen
            coast.coast(known, part.times[at] - part.times[0], zonals, none)
        else:
            known = now
        target = moved_target if at >= part.tracked else np.zeros(6)
        burn = impulse + _correction(part, known, at, angle, target)
        burn = errors.of_burns(burn[:, None], drawn[at][:, None])[:, 0]
        spent += math.hypot(*burn)
        now = now.copy()
        now[3:] += burn
        until = part.times[at + 1] if at < last else part.end_s
        angle += coast.coast(now, until - part.times[at], zonals, none)
    if not np.isfinite(now).all():
        raise ArithmeticError("a flight with errors leads away from the Earth or into its centre")
    return spent, now - goal


def moved(state: Array, off: Array) -> Array:
    """A state moved by elements in its own frame, both of shape (6,)."""
    frame = equinoctial.own_frame(state)
    there: Array = equinoctial.state_of(equinoctial.elements(state, frame) + off, frame)
    return there


def _correction(part: LegPart, state: Array, at: int, angle: float, target: Array) -> Array:
    """Correction of a burn, from the state before it, the angle covered so far and the goal."""
    gain, effects = part.gains[at], part.effects[at:]
    if gain is None:
        return np.zeros(3)
    changes = np.zeros((len(effects), 3))
    for _ in range(STEPS):
        miss = _miss(part, state, at, angle, changes) - target
        changes = gain @ (miss - np.einsum("kij,kj->i", effects, changes))
    return np.asarray(changes[0])


def _miss(part: LegPart, state: Array, at: int, angle: float, changes: Array) -> Array:
    """Predicted miss in elements after this burn and those that follow, laps counted."""
    impulses = part.impulses[at:] + changes
    states, _, rest = coast.fly(
        state, part.times[at:], impulses, part.end_s, FIELDS[part.gravity], False
    )
    frame = equinoctial.own_frame(part.goal)
    reached, goal = (equinoctial.elements(one, frame) for one in (states[-1], part.goal))
    miss: Array = reached - goal
    if not np.isfinite(miss).all():
        raise ArithmeticError("a flight with errors leads away from the Earth or into its centre")
    miss[5] = math.remainder(miss[5], math.tau)
    miss[5] += math.tau * round((angle + rest - part.angle - miss[5]) / math.tau)
    return miss


EXACT_FLIGHTS = 10
"""Number of flights repeated without linearisation."""


class LegFlights(NamedTuple):
    """Flights of one leg."""

    delta_v_m_s: Array  # (flights,)
    standoff: Array  # (6, flights), misses in position and velocity
    arrival_m: Array  # (flights,)
    exact_m_s: Array  # (exact flights,), difference of ΔV
    exact_m: float  # largest difference of places at the stand-off
    revolution_s: float
    target_m: Array | None  # (flights,), of the destination from where it is planned


def fly_leg(
    leg: RefinedLeg,
    gravity: Gravity,
    errors: FlightErrors,
    rng: np.random.Generator,
    flights: int,
    corrections: int,
    displaced: DisplacedBodies,
    known_before_s: float | None,
) -> LegFlights:
    """Fly a leg many times; parameters are as of ``sample_flights``.

    Raises
    ------
    InputError
        It has no approach, or its burns or errors lead away from the Earth.
    """
    if all(burn.phase != "approach" for burn in leg.burns) or leg.burns[0].phase == "approach":
        raise InputError(f"leg {leg.leg}: no burns lead to an approach; add them")
    ends, off = _ends(leg, displaced, known_before_s)
    transfer, approach = parts_of(leg, gravity, corrections, ends)
    if not all(np.isfinite(part.effects).all() for part in (transfer, approach)):
        raise InputError(f"leg {leg.leg}: cannot be flown: its burns lead away from the Earth")
    begun = errors.of_departure(rng.standard_normal((6, flights)))
    drawn = [rng.standard_normal((part.times.size, 3, flights)) for part in (transfer, approach)]
    to_standoff = fly(transfer, begun, drawn[0], errors, off)
    # The approach is flown beside the destination, wherever that is.
    to_target = fly(approach, to_standoff.miss, drawn[1], errors)
    spent = to_standoff.delta_v_m_s + to_target.delta_v_m_s
    try:
        exact = list(_exactly((transfer, approach), begun, drawn, errors, off))
    except ArithmeticError as error:
        raise InputError(f"leg {leg.leg}: {error}; take smaller errors") from None
    return LegFlights(
        delta_v_m_s=spent,
        standoff=to_standoff.miss,
        arrival_m=np.linalg.norm(to_target.miss[:3], axis=0),
        exact_m_s=np.array([cost for cost, _ in exact]) - spent[: len(exact)],
        exact_m=max(
            float(np.linalg.norm(there - to_standoff.miss[:3, at]))
            for at, (_, there) in enumerate(exact)
        ),
        revolution_s=revolution_s(transfer.goal),
        target_m=None
        if leg.destination not in displaced
        else np.linalg.norm(transfer.states[:3] @ off.target, axis=0),  # type: ignore[union-attr]
    )


def revolution_s(state: Array) -> float:
    """Duration of a revolution from a state of shape (6,) [s]."""
    axis = 1.0 / (2.0 / float(np.linalg.norm(state[:3])) - float(state[3:] @ state[3:]) / MU_M3_S2)
    return math.tau * math.sqrt(axis**3 / MU_M3_S2)


def _ends(
    leg: RefinedLeg, displaced: DisplacedBodies, known_before_s: float | None
) -> tuple[UncertainEnds, BodiesOff | None]:
    """Errors of the bodies of a leg: their model, and their values in each flight."""
    origin, target = leg.origin in displaced, leg.destination in displaced
    if not (origin or target):
        return PLANNED, None
    if known_before_s is None:
        standoff = next(state for state in leg.states if state.event == "stand-off")
        known_before_s = revolution_s(state_of(standoff))
    return (
        UncertainEnds(origin, leg.standoff_s - known_before_s if target else None),
        BodiesOff(
            displaced.at(leg.origin, leg.states[0].time_s),
            displaced.at(leg.destination, leg.standoff_s),
        ),
    )


def _exactly(
    parts: tuple[LegPart, LegPart],
    begun: Array,
    drawn: list[Array],
    errors: FlightErrors,
    off: BodiesOff | None,
) -> Iterator[tuple[float, Array]]:
    """ΔV of the first flights, and their position errors at the stand-off."""
    for at in range(min(EXACT_FLIGHTS, begun.shape[1])):
        this = None if off is None else BodiesOff(off.origin[:, at], off.target[:, at])
        first, standoff = fly_exactly(parts[0], begun[:, at], drawn[0][:, :, at], errors, this)
        second, _ = fly_exactly(parts[1], standoff, drawn[1][:, :, at], errors)
        yield first + second, standoff[:3]
