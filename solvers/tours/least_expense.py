"""Lower bound on the expense of campaigns that are tours through time, at any times.

Time is cut into cells. For whole k, arrivals at least k cell lengths apart lie at least k cells
apart, and those at most k lengths apart at most k cells. So every campaign is a walk through the
cells, and what its legs cost is no less than :mod:`.cells` says of theirs, whatever the grid of
connections.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from adr_opt.mission.problem import Problem

from .bound import Bounding, FirstPrices, Tangent, bound, memories, neighbourhoods
from .campaign import Campaign
from .cells import CellTimes, cells_of
from .costs import TimeGrid
from .grid_costs import UNIT_M_S

FloatArray = npt.NDArray[np.float64]

REMEMBERED = 6
"""Neighbours of each target that walks remember."""

LEGS, MOST_LEGS = 0.024, 1.25
"""ΔV over exhaust speed of legs: for each target, and of one mission at most, as a first guess:
where the tangent of the expense touches it first."""

STAGES = (3, 30.0), (6, 60.0), (12, 240.0)
"""Masses between which costs are linear, and time [s]: in the first stages of a number of missions,
and in all that follow. Prices are found with few masses, and bounds with many. After each stage the
tangent touches where the last walks were."""

ROUNDS = 40
"""Rounds of prices in a stage where no time is set."""


@dataclass
class _Campaigns:
    """What is known of campaigns with a given number of missions.

    Attributes
    ----------
    missions : int
    carried_kg : float
        By each of them, in the mean.
    value : float
        A bound.
    prices : (targets,) float64, optional
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


class LeastExpense:
    """A bound on the expense of all campaigns of a problem, raised for as long as there is time.

    What K missions cost is convex in what each of them carries. So it is bounded for each K apart,
    by the tangent that touches where K missions share all of that: for few missions legs are dear,
    for many launches are. It is gone on with where the bound is least.

    Parameters
    ----------
    problem : Problem
        With the expense by mass as its cost, and a longest leg.
    step_s : float, optional
        Of the cells; by default that of the coarse grid of tours [s].
    cores : int

    Attributes
    ----------
    rounds : int
        Of prices.
    """

    def __init__(self, problem: Problem, step_s: float | None = None, *, cores: int = 1) -> None:
        campaign = Campaign(problem)
        steps, limit = campaign.layout.steps, problem.instance.transfer.max_leg_s
        if not campaign.weighs or limit is None:
            raise ValueError("bounds are of an expense by mass, and of legs of limited time")
        self._expense = campaign.expense
        self._count = len(problem.instance.targets)
        step = steps.step if step_s is None else step_s
        rules = problem.missions[0].rules
        stay = float(rules.service[problem.instance.first_target :].min())
        tank = problem.missions[0].chaser.tank
        apart_s = problem.instance.mission.mission_separation_s
        since, until = problem.instance.available_s[0]
        last = min(problem.instance.mission.duration_s, math.inf if until is None else until)
        least = max(math.floor(stay / step + 1e-9), 1)
        most = math.ceil(limit / step - 1e-9)
        size = math.floor((last - stay - since) / step + 1e-9) + 1, most - least + 1
        times = CellTimes(since, step, stay, steps.longest, least, tank.full_m_s(0.0) + 1.0)
        apart = 1 - size[0]
        if apart_s is not None:
            apart = math.floor((stay + apart_s) / step + 1e-9)
        self._cells = cells_of(problem, times, size, cores)
        self._grid = TimeGrid(least, apart, UNIT_M_S)
        self._memory = memories(neighbourhoods(self._cells, REMEMBERED))
        self._known = [self._begun(k + 1) for k in range(min(len(problem.missions), self._count))]
        self.rounds = 0

    def _begun(self, missions: int) -> _Campaigns:
        """A number of missions, and the least cost of their launches and kits.

        Kits are best shared evenly, since squares are convex.
        """
        spent = self._expense
        kits_kg = spent.kit_kg * self._count / missions
        value = missions * (spent.fixed + (spent.per_kg + spent.per_kg_squared * kits_kg) * kits_kg)
        legs = min(LEGS * self._count / missions, MOST_LEGS)
        carried_kg = spent.dry_kg * math.expm1(legs) + kits_kg * math.expm1(legs) / legs
        return _Campaigns(missions, carried_kg, value)

    @property
    def value(self) -> float:
        """The bound: the least of those of all numbers of missions."""
        return min(each.value for each in self._known)

    @property
    def by_missions(self) -> tuple[float, ...]:
        """Bounds on campaigns of one mission, of two, and so on."""
        return tuple(each.value for each in self._known)

    def advance(self, most_s: float) -> None:
        """Raise prices for the number of missions with the least bound.

        Parameters
        ----------
        most_s : float
            Longest time, infinite for a number of rounds [s].
        """
        now = min(self._known, key=lambda each: each.value)
        tangent = Tangent.at(self._expense, now.carried_kg)
        levels, stage_s = STAGES[min(now.stages, len(STAGES) - 1)]
        settings = Bounding(10**9, min(stage_s, most_s), levels=levels)
        if math.isinf(most_s):
            settings = Bounding(ROUNDS, levels=levels)
        # A launch of so much goes on to cost walks what it did, whatever the tangent.
        mass_kg = self._expense.dry_kg + now.carried_kg
        fee = 0.0 if now.launch is None else now.launch - tangent.fixed - tangent.per_kg * mass_kg
        first = FirstPrices(now.prices, now.missions, fee)
        found = bound(
            self._cells, self._grid, self._expense, tangent, self._memory, settings, first
        )
        self.rounds += found.rounds
        now.stages, now.value = now.stages + 1, max(now.value, found.value)
        now.carried_kg = 0.5 * (now.carried_kg + found.carried_kg)
        mass_kg = self._expense.dry_kg + now.carried_kg
        now.launch = tangent.fixed + found.fee + tangent.per_kg * mass_kg
        for each in self._known:
            if each is now or each.prices is None:
                each.prices = found.prices
