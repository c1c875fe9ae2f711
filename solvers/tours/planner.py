"""Tours from scratch: a population that is annealed, crossed and annealed again.

Where annealing ends depends on which missions fly when, which it no longer changes once it has
cooled a little, and far less on how slowly it cools. So many short runs make a population, and
crossing two of it gives other missions at other times, which a shorter run settles.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass

import numpy as np

from .annealing import RuinRules, TourTimes, anneal
from .costs import Costs, TimeGrid, Tour, TourCosts, TourExpense, blocks, nearby
from .crossing import NoPlace, crossed, first_tour

Share = Callable[[], float]
"""Share of the time that is over; the search ends at 1."""


@dataclass(frozen=True)
class Annealing:
    """Parameters of the search.

    Attributes
    ----------
    hot, cold : float
        First and last temperature of a beginning, in units of expense.
    warm : float
        First temperature of a tour that was crossed.
    most : int
        Targets that are taken out at once.
    wide, near : int
        Half of the windows of times in a tour, and in which a target is put back [steps].
    blinks : float
        Share of places that are overlooked.
    noise : float
        Largest random error of the costs of places, in temperatures.
    chunk : int
        Iterations at one temperature.
    population, children : int
        Tours that are kept, and made in each generation.
    iterations : int
        Of a beginning; of a tour that was crossed half of them.
    missions : int
        About how many missions a beginning has.
    """

    hot: float = 40.0
    cold: float = 0.5
    warm: float = 6.0
    most: int = 15
    wide: int = 48
    near: int = 24
    blinks: float = 0.01
    noise: float = 0.5
    chunk: int = 250
    population: int = 8
    children: int = 4
    iterations: int = 4000
    missions: int = 10

    @property
    def ruin(self) -> RuinRules:
        """The part for :func:`~.annealing.anneal`."""
        return RuinRules(self.most, self.wide, self.near, self.blinks, self.noise)


class Population:
    """Tours that are annealed and crossed, generation by generation.

    Parameters
    ----------
    cost : (targets, targets, gaps, times) uint16
        By the two targets, the gap from arrival to arrival, and the earlier arrival.
    grid : TimeGrid
    expense : TourExpense
    settings : Annealing
    share : callable
        No annealing goes on once it says that the time is over.
    seed : int
    cores : int
        Threads; the tours do not depend on it.

    Attributes
    ----------
    tours : list of Tour
        Best first.
    generations : int
    """

    def __init__(
        self,
        cost: Costs,
        grid: TimeGrid,
        expense: TourExpense,
        settings: Annealing,
        share: Share,
        *,
        seed: int = 0,
        cores: int = 2,
    ) -> None:
        least = np.zeros((*cost.shape[:2], blocks(cost.shape[3])), np.uint16)
        nearby(cost, least)
        self._costs, self._grid, self._expense = TourCosts(cost, least), grid, expense
        self._settings, self._share, self._seed, self._cores = settings, share, seed, cores
        self.tours: list[Tour] = []
        self.generations = 0

    def advance(self) -> None:
        """Make the next generation; the first ones are beginnings."""
        settings, number = self._settings, self.generations
        self.generations += 1
        seeds = [(self._seed * 1009 + number) * 64 + k for k in range(settings.children)]
        with ThreadPoolExecutor(self._cores) as threads:
            made = list(threads.map(self._child, seeds, range(settings.children)))
        for tour in made:
            if tour is not None and not any(_alike(tour, other) for other in self.tours):
                self.tours.append(tour)
        self.tours.sort(key=lambda tour: tour.expense)
        del self.tours[settings.population :]

    def _child(self, seed: int, number: int) -> Tour | None:
        """A new tour; None if there was no time or room for it."""
        settings = self._settings
        beginnings = max(1, settings.population // settings.children)
        iterations, hot = settings.iterations, settings.hot
        try:
            if self.generations <= beginnings or len(self.tours) < 2:
                missions = settings.missions + number % 3 - 1
                tour = first_tour(self._costs, self._grid, self._expense, seed, missions)
            else:
                one, other = np.random.default_rng(seed).permutation(len(self.tours))[:2]
                parents = self.tours[one], self.tours[other]
                tour = crossed(self._costs, self._grid, self._expense, parents, seed)
                iterations, hot = max(1, iterations // 2), settings.warm
        except NoPlace:
            return None
        return self._annealed(tour, seed, iterations, hot)

    def _annealed(self, tour: Tour, seed: int, iterations: int, hot: float) -> Tour | None:
        settings, best = self._settings, None
        here = TourTimes(tour.order.copy(), tour.begins.copy(), tour.at.copy())
        for made in range(0, iterations, settings.chunk):
            heat = hot * (settings.cold / hot) ** (made / iterations)
            cost, better = anneal(
                self._costs,
                here,
                self._grid,
                self._expense,
                min(settings.chunk, iterations - made),
                seed * 100_003 + made,
                heat,
                settings.ruin,
            )
            if math.isfinite(cost) and (best is None or cost < best.expense):
                best = Tour(better.order, better.begins, better.at, cost)
            if self._share() >= 1.0:
                break
        return best


def _alike(one: Tour, other: Tour) -> bool:
    """Whether two tours are the same but for their times."""
    return bool(np.array_equal(one.order, other.order) and np.array_equal(one.begins, other.begins))
