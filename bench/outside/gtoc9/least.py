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

STEP_D = 2.5
"""Of the cells."""

REMEMBERED = 6
"""Neighbours of each debris that walks remember."""

CARRIED_KG, LEGS = 4300.0, 0.6
"""Where the expense is made linear: kits and propellant, and ΔV over exhaust speed. Any point gives
a bound. The dearer a metre per second, the cheaper a launch: at 0.42 a launch costs as much as 890
m/s, and one mission lasts for ever; at 0.7 as much as 210 m/s, and missions are too many."""

TARGET_MEUR = 300.0
"""What the steps of prices aim at."""


@dataclass(frozen=True)
class Proven:
    """A bound on J, the rounds of prices, and the processor time of everything [s]."""

    value: float
    rounds: int
    processor_s: float


def proven(rows: FloatArray, time_limit_s: float, step_d: float = STEP_D) -> Proven:
    """Prove a bound on J of every campaign that removes these debris by the estimate.

    Parameters
    ----------
    rows : (debris, columns) float64
    time_limit_s : float
        Of the rounds [s of this thread].
    step_d : float
        Of the cells: a whole part of 2.5 [d].
    """
    since = time.thread_time()
    table = cells(rows, step_d)
    grid = Grid(round(STAY_D / step_d), round((STAY_D + APART_D) / step_d), UNIT_M_S)
    linear = Linear.tangent(EXPENSE, UNIT_M_S, CARRIED_KG, LEGS)
    bit, carried = memories(neighbourhoods(table, REMEMBERED))
    settings = Bounding(10**9, time_limit_s, TARGET_MEUR)
    found = bound(table, grid, linear, bit, carried, settings)
    return Proven(found.value, found.rounds, time.thread_time() - since)
