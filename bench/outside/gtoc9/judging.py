"""A flown campaign judged: every leg flown once more, by other means than it was found with.

Motion under the pull of the Earth with J2 by the extrapolated midpoint rule (W. Gragg, SIAM Journal
on Numerical Analysis 2, 1965, 384–403; R. Bulirsch and J. Stoer, Numerische Mathematik 8, 1966,
1–13). Positions, speeds, number of impulses, their times, perigees and the rules of :mod:`.scoring`
are asked for.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from adr_opt.common.constants import DAY_S, MU_M3_S2, OBLATENESS_M2
from adr_opt.kernels.core.compile import kernel

from ..reading import FloatArray
from .ephemeris import Debris
from .flown import Flight, FlownMission
from .scoring import Score, score

MOST_IMPULSES = 5
"""Maximum number of impulses per leg."""

CLOSE_M, CLOSE_M_S = 100.0, 1.0
"""Largest distance and relative speed at a rendezvous."""

LOWEST_M = 6600e3
"""Least radius of perigees."""

ROWS = 8
"""Rows of the extrapolation: steps are cut into 2, 4, … 16 parts."""

SLACK_S = 1e-5
"""Tolerance of times of impulses, which a file has rounded."""

PER_RADIAN = 3.0
"""Steps for a radian that the chaser runs through."""


@kernel
def _push(state, out):
    """The contest's equations of motion."""
    x, y, z = state[0], state[1], state[2]
    square = x * x + y * y + z * z
    strength = -MU_M3_S2 / (square * math.sqrt(square))
    share, polar = 1.5 * OBLATENESS_M2 / square, 5.0 * z * z / square
    out[0], out[1], out[2] = state[3], state[4], state[5]
    out[3] = strength * x * (1.0 + share * (1.0 - polar))
    out[4] = strength * y * (1.0 + share * (1.0 - polar))
    out[5] = strength * z * (1.0 + share * (3.0 - polar))


@kernel
def _perigee(state):
    """The osculating perigee [m]; negative where the orbit is not closed."""
    r = math.sqrt(state[0] ** 2 + state[1] ** 2 + state[2] ** 2)
    inverse = 2.0 / r - (state[3] ** 2 + state[4] ** 2 + state[5] ** 2) / MU_M3_S2
    if inverse <= 0.0:
        return -1.0
    along = state[0] * state[3] + state[1] * state[4] + state[2] * state[5]
    e = math.hypot(1.0 - r * inverse, along * math.sqrt(inverse / MU_M3_S2))
    return (1.0 - e) / inverse


@kernel
def coasted(state, seconds):
    """Move a state freely, in place; the lowest osculating perigee on the way [m]."""
    lowest = _perigee(state)
    if lowest <= 0.0 or seconds <= 0.0:
        return lowest
    r = math.sqrt(state[0] ** 2 + state[1] ** 2 + state[2] ** 2)
    turned = seconds * math.sqrt(MU_M3_S2 / r**3)
    steps = math.ceil(turned * PER_RADIAN)
    h = seconds / steps
    table = np.empty((ROWS, 6))
    before, now, after, slope = np.empty(6), np.empty(6), np.empty(6), np.empty(6)
    for _ in range(steps):
        for row in range(ROWS):
            parts = 2 * (row + 1)
            small = h / parts
            _push(state, slope)
            for axis in range(6):
                before[axis] = state[axis]
                now[axis] = state[axis] + small * slope[axis]
            for _ in range(parts - 1):
                _push(now, slope)
                for axis in range(6):
                    after[axis] = before[axis] + 2.0 * small * slope[axis]
                    before[axis], now[axis] = now[axis], after[axis]
            _push(now, slope)
            for axis in range(6):
                table[row, axis] = 0.5 * (now[axis] + before[axis] + small * slope[axis])
        # Neville's scheme in the square of the step.
        for order in range(1, ROWS):
            for row in range(ROWS - 1, order - 1, -1):
                ratio = ((row + 1.0) / (row + 1.0 - order)) ** 2 - 1.0
                for axis in range(6):
                    table[row, axis] += (table[row, axis] - table[row - 1, axis]) / ratio
        for axis in range(6):
            state[axis] = table[ROWS - 1, axis]
        lowest = min(lowest, _perigee(state))
    return lowest


@dataclass(frozen=True)
class JudgedLeg:
    """Result of a leg: ΔV [m/s], distance from the debris [m, m/s], lowest perigee [m]."""

    delta_v_m_s: float
    miss_m: float
    miss_m_s: float
    perigee_m: float


@dataclass(frozen=True)
class Judged:
    """A campaign as flown: its legs, J, and all rules that are broken."""

    legs: tuple[tuple[JudgedLeg, ...], ...]
    score: Score
    violations: tuple[str, ...]


def judged_leg(
    one: Debris, other: Debris, departure_d: float, arrival_d: float, flight: Flight
) -> JudgedLeg:
    """Fly a leg by its impulses.

    Parameters
    ----------
    one, other : Debris
    departure_d, arrival_d : float
        [d, MJD2000].
    flight : Flight
    """
    state = one.state(departure_d * DAY_S)
    now, perigee = 0.0, _perigee(state)
    last = (arrival_d - departure_d) * DAY_S
    for time, impulse in zip(flight.times_s, flight.impulses_m_s, strict=True):
        perigee = min(perigee, coasted(state, time - now))
        state[3:] += impulse
        now = time
    perigee = min(perigee, coasted(state, last - now))
    off = state - other.state(arrival_d * DAY_S)
    size = float(np.linalg.norm(flight.impulses_m_s, axis=1).sum())
    return JudgedLeg(size, math.hypot(*off[:3]), math.hypot(*off[3:]), float(perigee))


def judged(missions: Sequence[FlownMission], debris: Sequence[Debris]) -> Judged:
    """Fly a campaign by its impulses, and score it.

    Parameters
    ----------
    missions : sequence of FlownMission
    debris : sequence of Debris
        All of which must be removed.
    """
    broken: list[str] = []
    legs = []
    for number, mission in enumerate(missions):
        found = []
        stops = mission.removals.stops
        for one, other, flight in zip(stops[:-1], stops[1:], mission.flights, strict=True):
            leg = judged_leg(
                debris[one.debris], debris[other.debris], one.departure_d, other.arrival_d, flight
            )
            where = f"mission {number}, leg from {one.debris} to {other.debris}"
            broken += [
                f"{where}: {said}"
                for said in _said(one.departure_d, other.arrival_d, flight.times_s, leg)
            ]
            found.append(leg)
        legs.append(tuple(found))
    sizes = [[leg.delta_v_m_s for leg in found] for found in legs]
    total = score([mission.removals for mission in missions], sizes, len(debris))
    return Judged(tuple(legs), total, (*broken, *total.violations))


def _said(departure_d: float, arrival_d: float, times_s: FloatArray, leg: JudgedLeg) -> list[str]:
    """Rules on flying that a leg breaks."""
    broken = []
    if times_s.size > MOST_IMPULSES:
        broken.append(f"{times_s.size} impulses")
    last = (arrival_d - departure_d) * DAY_S
    if (np.diff(times_s, prepend=0.0, append=last) < -SLACK_S).any():
        broken.append("impulses out of order, or outside of the leg")
    # NaN is no arrival either.
    if not (leg.miss_m <= CLOSE_M and leg.miss_m_s <= CLOSE_M_S):
        broken.append(f"{leg.miss_m:.3g} m and {leg.miss_m_s:.3g} m/s off on arrival")
    if not leg.perigee_m >= LOWEST_M:
        broken.append(f"a perigee of {leg.perigee_m / 1e3:.1f} km")
    return broken
