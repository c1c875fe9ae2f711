"""Lower bound on the expense of campaigns that are tours through time, at any times.

Time is cut into cells. For whole k, arrivals at least k cell lengths apart lie at least k cells
apart, and those at most k lengths apart at most k cells. So every campaign is a walk through the
cells, and what its legs cost is no less than :mod:`.cells` says of theirs, whatever the grid of
connections.
"""

from __future__ import annotations

import math
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from adr_opt.common.memory import available_bytes
from adr_opt.mission.problem import Problem

from .bound import Bound, Bounding, FirstPrices, Tangent, bound, memories, neighbourhoods
from .campaign import Campaign
from .cells import CellTimes, cells_of
from .costs import FORBIDDEN, Costs, TimeGrid
from .grid_costs import MOST_BYTES, UNIT_M_S, layout_of

FloatArray = npt.NDArray[np.float64]

REMEMBERED, LEAST_REMEMBERED = 8, 4
"""Number of neighbours of each target that walks remember, also if memory is short."""

FOR_WALKS = 0.25
"""Share of the available memory for the walks of one number of missions."""

LIKELY, MOST_HOPED = 0.02, 0.003
"""Share of the cells, the cheapest, on which prices are found, and the relative excess of a bound
there over that on all cells beyond which the share is doubled."""

COUNTED = 10_000_000
"""Maximum number of cells examined to find the cheapest ones."""

LEGS, MOST_LEGS = 0.024, 1.25
"""ΔV over exhaust speed of legs: for each target, and of one mission at most, as a first guess:
where the tangent of the expense touches it first."""

STAGES = (3, 10.0), (6, 30.0), (12, 60.0), (12, 120.0)
"""Masses between which costs are linear, and time [s]: in the first stages of a number of missions,
the last for all that follow. After each stage the tangent touches where the last walks were."""

ROUNDS = 40
"""Rounds of prices in a stage where no time is set."""


@dataclass
class _Campaigns:
    """Prices and bounds of campaigns with a given number of missions.

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
        Of the cells, no longer than a stay; by default :func:`cell_length_s` [s].
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
            raise ValueError("bounds need an expense by mass, and legs of limited duration")
        self._expense = campaign.expense
        self._count = len(problem.instance.targets)
        step = cell_length_s(problem) if step_s is None else step_s
        stay = _shortest_stay_s(problem)
        if step is None or stay < step:
            raise ValueError("cells are no longer than a stay: walks do one target in each")
        tank = problem.missions[0].chaser.usable
        apart_s = problem.instance.mission.mission_separation_s
        since, until = problem.instance.available_s[0]
        last = min(problem.instance.mission.duration_s, math.inf if until is None else until)
        least = math.floor(stay / step + 1e-9)
        most = math.ceil(limit / step - 1e-9)
        size = math.floor((last - stay - since) / step + 1e-9) + 1, most - least + 1
        times = CellTimes(since, step, stay, steps.longest, least, tank.full_m_s(0.0) + 1.0)
        apart = 1 - size[0]
        if apart_s is not None:
            apart = math.floor((stay + apart_s) / step + 1e-9)
        self._cells = cells_of(problem, times, size, cores)
        self._grid = TimeGrid(least, apart, UNIT_M_S)
        self._memory = memories(neighbourhoods(self._cells, self._remembered()))
        self._share = LIKELY
        self._likely = cheapest(self._cells, self._share)
        self._cores = cores
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

    def _remembered(self) -> int:
        """Number of neighbours that walks can remember in the available memory."""
        each = self._cells[..., 0, 0].size * STAGES[-1][0] * np.dtype(np.float64).itemsize
        room = FOR_WALKS * available_bytes() / each
        most = math.floor(math.log2(max(room, 1.0))) if math.isfinite(room) else REMEMBERED
        return max(min(REMEMBERED, most), LEAST_REMEMBERED)

    def advance(self, most_s: float) -> None:
        """Raise prices for the numbers of missions with the least bounds, as many as cores.

        Parameters
        ----------
        most_s : float
            Longest time, infinite for a number of rounds [s].
        """
        chosen = sorted(self._known, key=lambda each: each.value)[: self._cores]
        with ThreadPoolExecutor(len(chosen)) as threads:
            found = list(threads.map(lambda each: self._raised(each, most_s), chosen))
        for each, raised in zip(chosen, found, strict=True):
            self._keep(each, raised)
        if any(each.hoped > each.value + MOST_HOPED * abs(each.value) for each in found):
            self._share = min(2.0 * self._share, 1.0)
            self._likely = cheapest(self._cells, self._share)

    def _raised(self, now: _Campaigns, most_s: float) -> Bound:
        """The bound of a stage for a number of missions."""
        tangent = Tangent.at(self._expense, now.carried_kg)
        levels, stage_s = STAGES[min(now.stages, len(STAGES) - 1)]
        settings = Bounding(10**9, min(stage_s, most_s), levels=levels)
        if math.isinf(most_s):
            settings = Bounding(ROUNDS, levels=levels)
        # A launch of so much goes on to cost walks what it did, whatever the tangent.
        mass_kg = self._expense.dry_kg + now.carried_kg
        fee = 0.0 if now.launch is None else now.launch - tangent.fixed - tangent.per_kg * mass_kg
        prices = now.prices
        if prices is None:
            prices = np.full(self._count, now.value / self._count)
        first = FirstPrices(prices, now.missions, fee)
        return bound(
            self._cells,
            self._grid,
            self._expense,
            tangent,
            self._memory,
            settings,
            first,
            self._likely,
        )

    def _keep(self, now: _Campaigns, found: Bound) -> None:
        """Take over the result of a stage; other numbers of missions start from its prices."""
        tangent = Tangent.at(self._expense, now.carried_kg)
        self.rounds += found.rounds
        now.stages, now.value = now.stages + 1, max(now.value, found.value)
        if found.carried_kg > 0.0:
            now.carried_kg = 0.5 * (now.carried_kg + found.carried_kg)
        mass_kg = self._expense.dry_kg + now.carried_kg
        now.launch = tangent.fixed + found.fee + tangent.per_kg * mass_kg
        for each in self._known:
            if each is now or each.prices is None:
                each.prices = found.prices


def cell_length_s(problem: Problem) -> float | None:
    """Length of cells: that of the coarse grid of tours, or a stay if that is shorter.

    None where cells that short would be too many.
    """
    stay, limit = _shortest_stay_s(problem), problem.instance.transfer.max_leg_s
    step = layout_of(problem).steps.step
    if stay >= step:
        return step
    if limit is None or stay <= 0.0:
        return None
    gaps, times = limit / stay + 1.0, problem.instance.mission.duration_s / stay + 1.0
    size = 2.0 * len(problem.instance.targets) ** 2 * gaps * times
    return stay if size <= MOST_BYTES else None


def _shortest_stay_s(problem: Problem) -> float:
    """The shortest service [s]."""
    service = problem.missions[0].rules.service
    return float(service[problem.instance.first_target :].min())


def cheapest(cells: Costs, share: float) -> Costs:
    """The cheapest share of the cells; others are forbidden.

    Parameters
    ----------
    cells : (times, targets, targets, gaps) uint16
    share : float
    """
    some = cells.ravel()[:: max(cells.size // COUNTED, 1)]
    counts = np.bincount(some, minlength=FORBIDDEN + 1)[:FORBIDDEN]
    most = np.searchsorted(np.cumsum(counts), share * counts.sum())
    return np.where(cells <= most, cells, FORBIDDEN)
