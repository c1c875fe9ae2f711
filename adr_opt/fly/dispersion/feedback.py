"""A part of a refined leg with errors, corrected at its remaining burns by linear feedback.

What is wrong is measured at the end: the miss that the burns of the refined plan would lead to from
here on, in equinoctial elements in the frame of the goal, in which it is nearly linear even after
weeks. A burn k adds M_k δu to it, with M_k from the state-transition matrices. Before each burn the
least weighted squares of corrections at it and at all later ones are solved for,

    minimise  |S (m + Σ M_j δu_j)|² / (1 m)²  +  Σ |δu_j / w_j|² / (0.1 m/s)²,

and δu_k is made: the gain is one matrix a burn, known beforehand (A. Bryson and Y.-C. Ho, Applied
Optimal Control, 1975, chapter 5, for feedback of terminal misses). The second sum keeps corrections
small where the burns that are left have no leverage: what remains is the approach's.

Bodies may be elsewhere than planned (:mod:`.displaced`). Where the origin is, is known when the leg
begins; where the destination is, from a time on: before it, corrections lead to the planned place.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from ...common.constants import MU_M3_S2
from ...kernels.orbits import coast, equinoctial
from ...kernels.orbits.gravity import FIELDS
from ...kernels.orbits.short_periods import Array
from ...plan.plan import Vector
from ...plan.refined_plan import RefinedBurn, RefinedLeg
from ..refine.bodies import Gravity, state_of
from .errors import FlightErrors

WORTH_M_S_PER_M = 0.1
"""Correction per metre of miss; the approach closes it for about a twentieth of that, but begins
beside the target."""

LEAST_WEIGHT = 0.3
"""Weight of a small burn relative to the largest remaining one. Along a burn, half of the
corrections save what the other half cost, and across it they cost next to nothing;
alone they cost in full."""

SHORTEST_ARC = 0.1
"""Length of an arc below which it gets no pure correction burns [revolutions]."""

CLOSE_S = 1e-3
"""Times closer than this are one [s]."""


@dataclass(frozen=True)
class UncertainEnds:
    """Errors of the bodies at both ends of a leg.

    Attributes
    ----------
    origin : bool
        Whether the origin may be elsewhere than planned.
    tracked_s : float or None
        Time from which it is known where the destination is; None if it is where it is planned [s].
    """

    origin: bool = False
    tracked_s: float | None = None


PLANNED = UncertainEnds()
"""Default: both bodies are at their planned places."""


class BodiesOff(NamedTuple):
    """Errors of bodies as equinoctial elements, in the frame of the planned state.

    Attributes
    ----------
    origin, target : (6, n) float64
        At the beginning of a part, and at its end.
    """

    origin: Array
    target: Array


@dataclass(frozen=True)
class LegPart:
    """A leg up to its stand-off, or its approach, around which flights are linearised.

    Attributes
    ----------
    gravity : {"two-body", "j2", "j3", "j4"}
    start, goal : (6,) float64
        States of the refined plan at the beginning, before any burn, and at the end [m, m/s].
    times : (burns,) float64
        The first one is the beginning; where the plan has no burn then, one of zero stands [s].
    end_s : float
        [s].
    impulses : (burns, 3) float64
        Of the refined plan; zero for corrections [m/s].
    angle : float
        That the refined plan runs through [rad].
    beginning : (6, 6) float64
        Derivative of the miss, in elements, by the state at the beginning.
    effects : (burns, 6, 3) float64
        The same by each impulse.
    gains : tuple of (burns left, 3, 6) float64
        For each burn, corrections at it and at those after it by the miss; none for burns that
        come before anything is known.
    seen : int
        The first burn at which errors of the chaser are known; before it, those of the origin are.
    tracked : int
        The first burn at which it is known where the destination is.
    starts, states : (6, 6) float64
        Derivative of the state at the beginning, and at the end, by the elements there.
    """

    gravity: Gravity
    start: Array
    goal: Array
    times: Array
    end_s: float
    impulses: Array
    angle: float
    beginning: Array
    effects: Array
    gains: tuple[Array | None, ...]
    seen: int
    tracked: int
    starts: Array
    states: Array


@dataclass(frozen=True)
class Parted:
    """Flights of a part: ΔV of each, shape (n,) [m/s], and the final state error, (6, n)."""

    delta_v_m_s: Array
    miss: Array


def parts_of(
    leg: RefinedLeg, gravity: Gravity, corrections: int, ends: UncertainEnds = PLANNED
) -> tuple[LegPart, LegPart]:
    """The two parts of a refined leg: up to the stand-off, and the approach.

    Parameters
    ----------
    leg : RefinedLeg
        With an approach.
    gravity : {"two-body", "j2", "j3", "j4"}
    corrections : int
        Burns for corrections alone after each burn.
    ends : UncertainEnds
    """
    first = next(at for at, burn in enumerate(leg.burns) if burn.phase == "approach")
    begin = leg.states[0]
    transfer = part(
        state_of(begin),
        begin.time_s,
        leg.burns[:first],
        leg.standoff_s,
        gravity,
        corrections,
        ends,
        blind=True,
    )
    # The impulse at the stand-off, which also begins the approach, is the last one of the transfer;
    # what it leaves wrong is corrected after it, like what any other burn does.
    stop = leg.burns[first - 1].replace(time_s=leg.standoff_s, delta_v_m_s=(0.0, 0.0, 0.0))
    approach = part(
        transfer.goal,
        leg.standoff_s,
        (stop, *leg.burns[first:]),
        leg.arrival_s,
        gravity,
        corrections,
        blind=True,
    )
    return transfer, approach


def part(
    start: Array,
    start_s: float,
    burns: tuple[RefinedBurn, ...],
    end_s: float,
    gravity: Gravity,
    corrections: int = 0,
    ends: UncertainEnds = PLANNED,
    *,
    blind: bool = False,
) -> LegPart:
    """Linearise around the burns of a refined plan.

    Parameters
    ----------
    start : (6,) float64
        [m, m/s].
    start_s, end_s : float
        [s].
    burns : tuple of RefinedBurn
    gravity : {"two-body", "j2", "j3", "j4"}
    corrections : int
        Burns for corrections alone after each burn, evenly in the revolution that follows it or
        until the next one; also after the destination is tracked.
    ends : UncertainEnds
    blind : bool
        The first burn is made as planned: the error at the beginning is seen after it.
    """
    made = [(burn.time_s, burn.delta_v_m_s) for burn in burns]
    tracked_s = math.inf if ends.tracked_s is None else max(ends.tracked_s, burns[0].time_s)
    if tracked_s < end_s and all(abs(time_s - tracked_s) > CLOSE_S for time_s, _ in made):
        made = sorted([*made, (tracked_s, (0.0, 0.0, 0.0))])
    times, impulses, first = _with_corrections(start, start_s, made, end_s, corrections)
    states, arcs, angle = coast.fly(start, times, impulses, end_s, FIELDS[gravity], True)
    goal = states[-1]
    frame = equinoctial.own_frame(goal)
    jacobian = equinoctial.jacobian(goal, frame)
    effects = jacobian @ arcs[:, :, 3:]
    seen = first + 1 if blind else first
    tracked = int(np.searchsorted(times, tracked_s - CLOSE_S))
    known = first if ends.origin or tracked <= first else seen
    radius = float(np.linalg.norm(goal[:3]))
    gains = [
        _gain(effects[at:], impulses[at:], radius) if at >= known else None
        for at in range(times.size)
    ]
    return LegPart(
        gravity,
        start,
        goal,
        times,
        end_s,
        impulses,
        angle,
        jacobian @ arcs[0],
        effects,
        tuple(gains),
        seen,
        max(tracked, first),
        np.linalg.inv(equinoctial.jacobian(start, equinoctial.own_frame(start))),
        np.linalg.inv(jacobian),
    )


def fly(
    part: LegPart, begun: Array, drawn: Array, errors: FlightErrors, off: BodiesOff | None = None
) -> Parted:
    """Fly a part many times.

    Parameters
    ----------
    part : LegPart
    begun : (6, n) float64
        By how much each flight is off at the beginning [m, m/s].
    drawn : (burns, 3, n) float64
        Standard normal numbers.
    errors : FlightErrors
    off : BodiesOff, optional
        Of the bodies; the miss is then that of the stand-off where the destination is.
    """
    miss = part.beginning @ begun
    spent = np.zeros(begun.shape[1])
    brought = np.zeros_like(miss)
    if off is not None:
        brought = part.beginning @ (part.starts @ off.origin)
        miss = miss + brought
    for at, (impulse, effect, gain, normal) in enumerate(
        zip(part.impulses, part.effects, part.gains, drawn, strict=True)
    ):
        wanted = impulse[:, None]
        if gain is not None:
            known = miss if at >= part.seen else brought
            if off is not None and at >= part.tracked:
                known = known - off.target
            wanted = wanted + gain[0] @ known
        burns = errors.of_burns(np.broadcast_to(wanted, normal.shape), normal)
        spent += np.sqrt(np.sum(burns * burns, axis=0))
        miss = miss + effect @ (burns - impulse[:, None])
    if off is not None:
        miss = miss - off.target
    return Parted(spent, part.states @ miss)


def _with_corrections(
    start: Array, start_s: float, burns: list[tuple[float, Vector]], end_s: float, corrections: int
) -> tuple[Array, Array, int]:
    """Times and impulses with corrections inserted as zeros, and the index of the first burn."""
    revolution = math.tau * math.sqrt(float(np.linalg.norm(start[:3])) ** 3 / MU_M3_S2)
    times = [start_s] if burns[0][0] > start_s else []
    impulses = [(0.0, 0.0, 0.0)] * len(times)
    first = len(times)
    for at, (time_s, delta_v_m_s) in enumerate(burns):
        times.append(time_s)
        impulses.append(delta_v_m_s)
        arc = (burns[at + 1][0] if at + 1 < len(burns) else end_s) - time_s
        if arc >= SHORTEST_ARC * revolution:
            step = min(arc, revolution) / (corrections + 1)
            times += [time_s + step * (number + 1) for number in range(corrections)]
            impulses += [(0.0, 0.0, 0.0)] * corrections
    return np.array(times), np.array(impulses), first


def _gain(effects: Array, impulses: Array, radius: float) -> Array:
    """Gain from predicted misses in elements to corrections at burns, shape (burns, 3, 6)."""
    metres = np.array([1.0, *([radius] * 5)])
    sizes = np.sqrt(np.sum(impulses**2, axis=1))
    weights = np.maximum(sizes / max(float(sizes.max()), 1e-300), LEAST_WEIGHT)
    weights = np.repeat(WORTH_M_S_PER_M * weights, 3)
    wide = effects.transpose(1, 0, 2).reshape(6, -1) * metres[:, None] * weights
    u, s, v = np.linalg.svd(wide, full_matrices=False)
    found: Array = -(weights[:, None] * (v.T * (s / (s * s + 1.0))) @ u.T) * metres
    return found.reshape(-1, 3, 6)
