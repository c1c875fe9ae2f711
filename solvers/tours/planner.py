"""Tours from scratch: concurrent chains of annealing.

Where a chain ends depends on what it began with far more than on how slowly it was cooled. So each
chain begins several times, from missions drawn by lot, and spends the rest of its time on warming
up and cooling the best of its beginnings once more.
"""

from __future__ import annotations

import math
import time
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from .annealing import RuinRules, TourTimes, anneal
from .costs import FAR, Costs, TimeGrid, TourCosts, TourExpense, TourRows, blocks, nearby
from .inserting import CostRows, PuttingRules, put_back

Integers = npt.NDArray[np.int64]


@dataclass(frozen=True)
class Tour:
    """All missions of a campaign.

    Attributes
    ----------
    order : (targets,) int64
    begins : (targets,) bool
        Whether a mission begins with a target.
    at : (targets,) int64
        When each is reached [steps of the grid].
    expense : float
        On the grid; infinite where there is no way through.
    """

    order: Integers
    begins: npt.NDArray[np.bool_]
    at: Integers
    expense: float


@dataclass(frozen=True)
class Annealing:
    """Parameters of a chain.

    Attributes
    ----------
    hot, cold : float
        First and last temperature, in units of expense.
    most : int
        Targets that are taken out at once.
    wide, near : int
        Half of the windows of times in a tour, and in which a target is put back [steps].
    blinks : float
        Share of places that are overlooked.
    noise : float
        Largest random error of the costs of places, in temperatures.
    starts : int
        How often a chain begins.
    starting : float
        Share of its time that all beginnings take; the last of them ends at ``warm``.
    warm : float
        Temperature down to which beginnings are cooled, and from which the best of them goes on
        after ``rewarmed`` times as much.
    rewarmed : float
    chunk : int
        Iterations at one temperature; a multiple of them is made.
    missions : int
        Number of missions drawn at the beginning.
    iterations : int, optional
        Of a chain; the same number gives the same tour.
    time_limit_s : float
        Processor time of a chain's thread; what is cooled by without iterations.
    """

    hot: float = 8.0
    cold: float = 0.3
    most: int = 15
    wide: int = 48
    near: int = 24
    blinks: float = 0.01
    noise: float = 0.0
    starts: int = 5
    starting: float = 0.4
    warm: float = 1.0
    rewarmed: float = 3.0
    chunk: int = 500
    missions: int = 10
    iterations: int | None = None
    time_limit_s: float = math.inf

    @property
    def ruin(self) -> RuinRules:
        """The chain's part for :func:`~.annealing.anneal`."""
        return RuinRules(self.most, self.wide, self.near, self.blinks, self.noise)


def first_tour(
    costs: TourCosts, grid: TimeGrid, expense: TourExpense, seed: int, missions: int
) -> Tour:
    """Missions of one target each, spread over time, into which all others are inserted."""
    count, times = costs.legs.shape[1], costs.legs.shape[3]
    missions = max(1, min(missions, count, times // grid.apart))
    drawn = np.random.default_rng(seed).permutation(count)
    order, begins = np.zeros(count + 1, np.int64), np.zeros(count + 1, np.bool_)
    at = np.full(count + 1, times // 2)
    order[:missions], begins[:missions] = drawn[:missions], True
    at[:missions] = (np.arange(missions) + 0.5) * times / missions
    usual = np.float32(0.012 * grid.unit_m_s)
    slope, kit = np.full(count + 1, usual), np.full(count + 1, 0.37)
    rows = [np.full((count, times), FAR, np.float32) for _ in range(2)]
    helpers = [np.full((1, times), FAR, np.float32) for _ in range(2)]
    rules = PuttingRules(
        grid, times, min(times // 2, 40), expense.fixed, usual, 0.25, blinks=0.0, noise=0.0
    )
    _, complete = put_back(
        costs, TourRows(order, begins, at, slope, kit), missions, drawn[missions:].copy(),
        count - missions, CostRows(*rows, *helpers), rules,
    )  # fmt: skip
    if not complete:
        raise ValueError("the horizon has no room for all targets in the first missions")
    return Tour(order[:-1].copy(), begins[:-1].copy(), at[:-1].copy(), math.inf)


def chain(
    costs: TourCosts,
    grid: TimeGrid,
    expense: TourExpense,
    seed: int,
    settings: Annealing,
    tell: Callable[[float, Tour], None] | None = None,
) -> Tour:
    """One chain of annealing.

    Parameters
    ----------
    tell : callable, optional
        Is called with the share that is done, and each better tour.
    """
    since, made = time.thread_time(), 0
    best: Tour | None = None
    for place in range(settings.starts + 1):
        if place < settings.starts:
            tour = first_tour(
                costs, grid, expense, seed * 1009 + place, settings.missions + place % 3 - 1
            )
            begin = settings.starting * place / settings.starts
            end = settings.starting * (place + 1) / settings.starts
            hot, cold = settings.hot, settings.warm
        else:
            assert best is not None
            tour, begin, end = best, settings.starting, 1.0
            hot, cold = settings.warm * settings.rewarmed, settings.cold
        here = TourTimes(tour.order.copy(), tour.begins.copy(), tour.at.copy())
        while True:
            spent = (time.thread_time() - since) / settings.time_limit_s
            share = spent if settings.iterations is None else max(spent, made / settings.iterations)
            if share >= end:
                break
            heat = hot * (cold / hot) ** max((share - begin) / (end - begin), 0.0)
            found, better = anneal(
                costs, here, grid, expense, settings.chunk, seed * 100_003 + made, heat,
                settings.ruin,
            )  # fmt: skip
            made += settings.chunk
            if best is None or found < best.expense:
                best = Tour(better.order, better.begins, better.at, found)
                if tell is not None:
                    tell(share, best)
    assert best is not None
    return best


def plan(
    cost: Costs,
    grid: TimeGrid,
    expense: TourExpense,
    settings: Annealing,
    seed: int = 0,
    chains: int = 2,
    tell: Callable[[float, Tour], None] | None = None,
) -> list[Tour]:
    """Tours of several chains, each in its own thread, best first.

    Parameters
    ----------
    cost : (targets, targets, gaps, times) uint16
        By the two targets, the gap from arrival to arrival, and the earlier arrival.
    settings : Annealing
        Of each chain, with a number of iterations or a time limit.
    seed : int
        Of the first chain; the others count on.
    chains : int
    """
    if settings.iterations is None and math.isinf(settings.time_limit_s):
        raise ValueError("a chain needs a number of iterations or a time limit")
    least = np.zeros((*cost.shape[:2], blocks(cost.shape[3])), np.uint16)
    nearby(cost, least)
    with ThreadPoolExecutor(chains) as threads:
        running = [
            threads.submit(
                chain, TourCosts(cost, least), grid, expense, seed + place, settings, tell
            )
            for place in range(chains)
        ]
        tours = [one.result() for one in running]
    return sorted(tours, key=lambda tour: tour.expense)
