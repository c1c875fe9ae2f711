"""A bound on J of all campaigns by the estimate, at any times: none was published.

Time is cut into cells of a step that stay, longest leg, and the gap between missions are whole
numbers of. Arrivals t < t' with t' − t between two such numbers of steps lie as many cells apart,
exactly: ⌊(t' + k h) / h⌋ = ⌊t' / h⌋ + k. So every campaign is a walk through the cells, and what
its legs cost is no less than :mod:`.cells` says of theirs.
"""

from __future__ import annotations

import math
import time
from dataclasses import dataclass

from solvers.tours.bound import (
    Bounding,
    FirstPrices,
    Tangent,
    bound,
    memories,
    neighbourhoods,
)
from solvers.tours.costs import TimeGrid

from ..reading import FloatArray
from .cells import UNIT_M_S, cells
from .expense import EXPENSE
from .scoring import APART_D, STAY_D

STEP_D = 2.5
"""Length of the cells."""

REMEMBERED = 6
"""Neighbours of each debris that walks remember."""

LEGS = 0.024
"""ΔV over exhaust speed of legs, for each debris, as a first guess: where the tangent of the
expense touches it first."""

MOST_LEGS = 1.25
"""Largest such sum of one mission: a full tank."""

DEAR_MEUR = 340.0
"""Excess of launches and kits alone beyond which a number of missions is not considered."""

TARGET_MEUR = 2.7
"""Target value per debris in the steps of prices."""

STAGES = (3, 30.0), (6, 60.0), (12, 240.0)
"""Masses between which costs are linear, and processor time [s]: in the first stages of a number of
missions, and in all that follow. Prices are found with few masses, and bounds with many. After each
stage the tangent touches where the last walks were."""


@dataclass(frozen=True)
class Proven:
    """A bound on J.

    Attributes
    ----------
    value : float
    rounds : int
        Of prices.
    processor_s : float
        Of everything [s].
    by_missions : tuple of float
        Bounds on J of campaigns of one mission, of two, and so on; the last one is on those of so
        many missions or more.
    """

    value: float
    rounds: int
    processor_s: float
    by_missions: tuple[float, ...]


@dataclass
class _Campaigns:
    """Results for campaigns with a given number of missions.

    Attributes
    ----------
    missions : int
    carried_kg : float
        By each of them, in the mean.
    value : float
        A bound.
    prices : (debris,) float64, optional
    launch : float, optional
        What walks pay for one of a mission that carries so much.
    stages : int
        Of rounds so far.
    """

    missions: int
    carried_kg: float
    value: float
    prices: FloatArray | None = None
    launch: float | None = None
    stages: int = 0


def launches_and_kits_meur(missions: int, count: int) -> float:
    """Least cost of a number of missions that share all debris, without legs.

    Kits are best shared evenly, since squares are convex.
    """
    carried_kg = EXPENSE.kit_kg * count / missions
    return missions * (EXPENSE.fixed + EXPENSE.per_kg_squared * carried_kg**2)


def proven(rows: FloatArray, time_limit_s: float, step_d: float = STEP_D) -> Proven:
    """Prove a bound on J of every campaign that removes these debris by the estimate.

    What K missions cost is convex in what each of them carries. So it is bounded for each K apart,
    by the tangent that touches where K missions share all of that: for few missions legs are dear,
    for many launches are. It is gone on with where the bound is least.

    Parameters
    ----------
    rows : (debris, columns) float64
    time_limit_s : float
        Of the rounds [s of this thread].
    step_d : float
        Of the cells: a whole part of 2.5 [d].
    """
    since = time.thread_time()
    table, count = cells(rows, step_d), len(rows)
    grid = TimeGrid(round(STAY_D / step_d), round((STAY_D + APART_D) / step_d), UNIT_M_S)
    memory_of = memories(neighbourhoods(table, REMEMBERED))
    few = []
    while len(few) < count and launches_and_kits_meur(len(few) + 1, count) < DEAR_MEUR:
        missions = len(few) + 1
        legs = min(LEGS * count / missions, MOST_LEGS)
        kits_kg = EXPENSE.kit_kg * count / missions * math.expm1(legs) / legs
        carried_kg = EXPENSE.dry_kg * math.expm1(legs) + kits_kg
        few.append(_Campaigns(missions, carried_kg, launches_and_kits_meur(missions, count)))
    more = (launches_and_kits_meur(each, count) for each in range(len(few) + 1, count + 1))
    rest = min(more, default=math.inf)
    rounds, left = 0, time_limit_s
    while few and left > 0.0:
        now = min(few, key=lambda each: each.value)
        if now.value >= rest:
            break
        begun = time.thread_time()
        tangent = Tangent.at(EXPENSE, now.carried_kg)
        levels, stage_s = STAGES[min(now.stages, len(STAGES) - 1)]
        settings = Bounding(10**9, min(stage_s, left), TARGET_MEUR * count, levels=levels)
        # A launch of so much goes on to cost walks what it did, whatever the tangent.
        mass_kg = EXPENSE.dry_kg + now.carried_kg
        fee = 0.0 if now.launch is None else now.launch - tangent.fixed - tangent.per_kg * mass_kg
        first = FirstPrices(now.prices, now.missions, fee)
        found = bound(table, grid, EXPENSE, tangent, memory_of, settings, first)
        rounds += found.rounds
        now.stages, now.value = now.stages + 1, max(now.value, found.value)
        now.carried_kg = 0.5 * (now.carried_kg + found.carried_kg)
        mass_kg = EXPENSE.dry_kg + now.carried_kg
        now.launch = tangent.fixed + found.fee + tangent.per_kg * mass_kg
        for each in few:
            if each is now or each.prices is None:
                each.prices = found.prices
        left -= time.thread_time() - begun
    by_missions = (*(each.value for each in few), rest)
    return Proven(min(by_missions), rounds, time.thread_time() - since, by_missions)
