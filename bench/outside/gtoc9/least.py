"""A bound on J of all campaigns by the estimate, at any times: none was published.

Time is cut into cells of a step that stay, longest leg, and the gap between missions are whole
numbers of. Arrivals t < t' with t' − t between two such numbers of steps lie as many cells apart,
exactly: ⌊(t' + k h) / h⌋ = ⌊t' / h⌋ + k. So every campaign is a walk through the cells, and what
its legs cost is no less than :mod:`.cells` says of theirs.
"""

from __future__ import annotations

import time
from dataclasses import dataclass

from solvers.campaigns.tours.bound import Bounding, Linear, bound, memories, neighbourhoods
from solvers.campaigns.tours.costs import Grid

from ..reading import FloatArray
from .cells import cells
from .ours import EXPENSE
from .scoring import APART_D, STAY_D
from .tables import UNIT_M_S

STEPS_D, FIRST_SHARE = (2.5, 1.25), 0.25
"""Of the cells, at first and at last; the share of the time that prices are raised on the first
ones, on which a round takes a quarter of the time. Finer cells widen crossings of planes less."""

REMEMBERED = 6
"""Neighbours of each debris that walks remember."""

CARRIED_KG, LEGS = 4300.0, 0.42
"""Where the expense is made linear: kits and propellant, and ΔV over exhaust speed. Of those that
were tried, from 3100 kg and 0.35 to 5000 kg and 0.7, what gave the best bound."""

TARGET_MEUR = 300.0
"""What the steps of prices aim at."""


@dataclass(frozen=True)
class Proven:
    """A bound on J, the rounds of prices, and the processor time of everything [s]."""

    value: float
    rounds: int
    processor_s: float


def proven(rows: FloatArray, time_limit_s: float, steps_d: tuple[float, ...] = STEPS_D) -> Proven:
    """Prove a bound on J of every campaign that removes these debris by the estimate.

    Parameters
    ----------
    rows : (debris, columns) float64
    time_limit_s : float
        Of the rounds [s of this thread].
    steps_d : tuple of float
        Of the cells: whole parts of 2.5, ever finer [d].
    """
    since = time.thread_time()
    linear = Linear.tangent(EXPENSE, UNIT_M_S, CARRIED_KG, LEGS)
    best, rounds, prices, left_s = 0.0, 0, None, time_limit_s
    for step_d in steps_d:
        table = cells(rows, step_d)
        grid = Grid(round(STAY_D / step_d), round((STAY_D + APART_D) / step_d), UNIT_M_S)
        bit, carried = memories(neighbourhoods(table, REMEMBERED))
        limit_s = left_s if step_d == steps_d[-1] else FIRST_SHARE * left_s
        left_s -= limit_s
        settings = Bounding(10**9, limit_s, TARGET_MEUR)
        found = bound(table, grid, linear, bit, carried, settings, prices)
        best, prices, rounds = max(best, found.value), found.prices, rounds + found.rounds
        del table
    return Proven(best, rounds, time.thread_time() - since)
