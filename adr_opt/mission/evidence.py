"""Evidence of a proof: the facts from which its bound can be recomputed."""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

USUAL_SLOT_M_S = 20.0
"""Slot of ΔV for completion bounds where a proof has none of its own [m/s]."""

WORD = 63
"""Number of targets per integer of a neighbourhood."""


@dataclass(frozen=True, eq=False)
class Walks:
    """Evidence on the walks of interchangeable chasers.

    A walk visits targets, again and again if it has forgotten them, and collects at each what the
    target is worth less its multiplier.

    Attributes
    ----------
    chasers : tuple of int
        Their numbers.
    most : float
        No walk of one of them collects as much.
    neighbourhoods : (bodies, bodies) bool
        Whether a walk that arrives at a body (row) still remembers another one (column). It
        remembers where it comes from in any case.
    per_m_s : float or None
        What a walk pays for ΔV, in place of keeping to its tanks, and gets for all that is in them
        at the start and after each refuelling [worth per m/s].
    """

    chasers: tuple[int, ...]
    most: float
    neighbourhoods: npt.NDArray[np.bool_]
    per_m_s: float | None = None


class Cut(NamedTuple):
    """A subset-row cut with its multiplier: of three targets one route at most services two.

    A walk pays at its second service of these targets, and again at its fourth. At a body outside
    the memory it forgets that it has serviced a first one, or a third.

    Attributes
    ----------
    rows : tuple of int
        Bodies of the three targets.
    memory : frozenset of int
        Bodies.
    multiplier : float
        At least 0.
    """

    rows: tuple[int, ...]
    memory: frozenset[int]
    multiplier: float


@dataclass(frozen=True)
class Floors:
    """Evidence from the least time and the least ΔV of every service.

    Attributes
    ----------
    per_s, per_m_s : float
        Prices of time [worth per s] and of ΔV [worth per m/s].
    most : float
        No plan is worth more.
    ballast_kg : float
        With which ΔV is counted where services change masses.
    alone : bool
        Whether each chaser is bounded by itself, in whole steps of the prizes.
    """

    per_s: float
    per_m_s: float
    most: float
    ballast_kg: float = 0.0
    alone: bool = False


@dataclass(frozen=True, eq=False)
class CostEvidence:
    """Evidence for the least ΔV of plans of at least some worth.

    With worth at a price and ΔV taken off, no walk of a single chaser that is worth enough counts
    more than the least worth at that price less the bound. Or, where there are ``walks``: with
    multipliers taken off as well, those of all chasers together, whatever they are worth, count no
    more than that less the multipliers and those of the cuts.

    Attributes
    ----------
    bound : float
        No plan that is worth as much costs less [m/s].
    worth : float
        What it is worth at least.
    per_worth : float
        Price of worth [m/s].
    neighbourhoods : (bodies, bodies) bool or None
        Whether a walk that is worth enough, and arrives at a body (row), still remembers another
        one (column).
    walks : tuple of Walks
        Of all chasers, each once [m/s].
    multipliers : (bodies,) float64 or None
        That they pay [m/s].
    cuts : tuple of Cut
        That they pay [m/s].
    """

    bound: float
    worth: float
    per_worth: float
    neighbourhoods: npt.NDArray[np.bool_] | None = None
    walks: tuple[Walks, ...] = ()
    multipliers: npt.NDArray[np.float64] | None = None
    cuts: tuple[Cut, ...] = ()


@dataclass(frozen=True, eq=False)
class Evidence:
    """Evidence for a bound (docs/model.md section 8).

    All plans together collect less than the sum of the multipliers, each as often as its body may
    be gone to, of those of the cuts, and, for each chaser, of the most of its walks.

    Attributes
    ----------
    multipliers : (bodies,) float64
        At least 0, and 0 but for targets and for stations with limited refuellings.
    walks : tuple of Walks
        Of all chasers, each once.
    delta_v_slot_m_s : float
        In which the proof has counted ΔV where it looks ahead [m/s].
    floors : Floors or None
        What the bound rests on in place of walks.
    time_step_s : float or None
        In which the proof has counted time, where it has gone through no walks one by one [s].
    cuts : tuple of Cut
        What walks pay for besides services.
    cost : CostEvidence or None
        For the least cost of plans at the best prize.
    """

    multipliers: npt.NDArray[np.float64]
    walks: tuple[Walks, ...]
    delta_v_slot_m_s: float
    floors: Floors | None = None
    time_step_s: float | None = None
    cuts: tuple[Cut, ...] = ()
    cost: CostEvidence | None = None
