"""One leg flown many times with errors."""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import NamedTuple

import numpy as np

from ...common.constants import MU_M3_S2
from ...common.errors import InputError
from ...kernels.orbits.short_periods import Array
from ...plan.refined_plan import RefinedLeg
from ..refine.bodies import Gravity
from ..refine.states import state_of
from .displaced import DisplacedBodies
from .errors import FlightErrors
from .exact import fly_exactly
from .feedback import PLANNED, BodiesOff, LegPart, UncertainEnds, fly, parts_of

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
    """Time that a revolution takes from a state, shape (6,) [s]."""
    axis = 1.0 / (2.0 / float(np.linalg.norm(state[:3])) - float(state[3:] @ state[3:]) / MU_M3_S2)
    return math.tau * math.sqrt(axis**3 / MU_M3_S2)


def _ends(
    leg: RefinedLeg, displaced: DisplacedBodies, known_before_s: float | None
) -> tuple[UncertainEnds, BodiesOff | None]:
    """What is uncertain about the bodies of a leg, and by how much they are off."""
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
