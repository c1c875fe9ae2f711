"""Tours from scratch: a population, annealed and recombined.

Where annealing ends depends on which missions fly when, which it no longer changes once it has
cooled a little, and far less on how slowly it cools. So many short runs make a population, and
crossing two of it gives other missions at other times, which a shorter run settles.

Crossing takes missions of one tour within a span of time, and those of the other around it. What a
mission costs depends on its own time alone, so a good part of a tour stays good in another one,
where the same time is free. Targets that both parts service leave the longer mission, and what
neither services is inserted where it costs least.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from itertools import pairwise
from typing import NamedTuple

import numpy as np

from .annealing import RuinRules, TourTimes, anneal
from .costs import FAR, Costs, TimeGrid, Tour, TourCosts, TourExpense, TourRows, blocks, nearby
from .inserting import CostRows, PuttingRules, put_back

USUAL_SLOPE = 0.012
"""Initial cost of another m/s in a mission."""

USUAL_KIT = 0.37
"""Initial cost of another target in a mission, besides its legs."""


class NoPlace(Exception):
    """No tour was found with time for all targets."""


class Piece(NamedTuple):
    """A mission of a tour: its targets in order, with their arrivals [steps]."""

    order: list[int]
    at: list[int]


def pieces_of(tour: Tour) -> list[Piece]:
    """Missions of a tour."""
    firsts = [*np.flatnonzero(tour.begins).tolist(), tour.order.size]
    return [Piece(tour.order[a:b].tolist(), tour.at[a:b].tolist()) for a, b in pairwise(firsts)]


def completed(
    costs: TourCosts, grid: TimeGrid, expense: TourExpense, pieces: list[Piece], lacking: np.ndarray
) -> Tour:
    """Missions with all other targets inserted, each where it costs least.

    Parameters
    ----------
    costs : TourCosts
    grid : TimeGrid
    expense : TourExpense
    pieces : list of Piece
        In order of time, with no target twice.
    lacking : (lacking,) int64
        The other targets, in the order of insertion.

    Raises
    ------
    NoPlace
        One has no place.
    """
    count, times = costs.legs.shape[1], costs.legs.shape[3]
    order, begins = np.zeros(count + 1, np.int64), np.zeros(count + 1, np.bool_)
    at, size = np.full(count + 1, times // 2), 0
    for piece in pieces:
        there = slice(size, size + len(piece.order))
        order[there], at[there], begins[size] = piece.order, piece.at, True
        size = there.stop
    usual = np.float32(USUAL_SLOPE * grid.unit_m_s)
    slope, kit = np.full(count + 1, usual), np.full(count + 1, USUAL_KIT)
    rows = [np.full((count, times), FAR, np.float32) for _ in range(2)]
    helpers = [np.full((1, times), FAR, np.float32) for _ in range(2)]
    rules = PuttingRules(
        grid,
        times,
        min(times // 2, 40),
        expense.fixed,
        usual,
        0.25,
        blinks=0.0,
        noise=0.0,
        most_missions=expense.most_missions,
    )
    if lacking.size:
        _, complete = put_back(
            costs,
            TourRows(order, begins, at, slope, kit),
            size,
            lacking,
            lacking.size,
            CostRows(*rows, *helpers),
            rules,
        )
        if not complete:
            raise NoPlace("the horizon is too short for all targets in these missions")
    return Tour(order[:-1].copy(), begins[:-1].copy(), at[:-1].copy(), float("inf"))


def first_tour(
    costs: TourCosts, grid: TimeGrid, expense: TourExpense, seed: int, missions: int
) -> Tour:
    """Missions of one target each, spread over time, into which all others are inserted.

    Raises
    ------
    NoPlace
        One has no place.
    """
    count, times = costs.legs.shape[1], costs.legs.shape[3]
    most = times // grid.apart if grid.apart > 0 else count
    missions = max(1, min(missions, count, most, expense.most_missions))
    drawn = np.random.default_rng(seed).permutation(count)
    when = ((np.arange(missions) + 0.5) * times / missions).astype(np.int64)
    pieces = [
        Piece([one], [at]) for one, at in zip(drawn[:missions].tolist(), when.tolist(), strict=True)
    ]
    return completed(costs, grid, expense, pieces, drawn[missions:].copy())


def crossed(
    costs: TourCosts, grid: TimeGrid, expense: TourExpense, parents: tuple[Tour, Tour], seed: int
) -> Tour:
    """A tour of some missions of the first parent, and of the second around them.

    Raises
    ------
    NoPlace
        A target has no place.
    """
    random = np.random.default_rng(seed)
    one, other = (sorted(pieces_of(each), key=lambda piece: piece.at[0]) for each in parents)
    length = int(random.integers(1, max(2, len(one) // 2 + 1)))
    begin = int(random.integers(0, len(one) - length + 1))
    chosen = one[begin : begin + length]
    taken = {target for piece in chosen for target in piece.order}
    low, high = chosen[0].at[0], max(piece.at[-1] for piece in chosen)
    kept = []
    for piece in other:
        left = [
            (target, at)
            for target, at in zip(piece.order, piece.at, strict=True)
            if target not in taken and (at <= low - grid.apart or at >= high + grid.apart)
        ]
        # A mission about the span of time keeps its longer end.
        before = [each for each in left if each[1] <= low]
        after = [each for each in left if each[1] > low]
        left = max(before, after, key=len) if grid.apart > 0 else left
        if left:
            kept.append(Piece([target for target, _ in left], [at for _, at in left]))
    pieces = sorted([*chosen, *kept], key=lambda piece: piece.at[0])
    while len(pieces) > expense.most_missions:
        pieces.remove(min(pieces, key=lambda piece: len(piece.order)))
    there = {target for piece in pieces for target in piece.order}
    lacking = [target for target in range(costs.legs.shape[0]) if target not in there]
    return completed(costs, grid, expense, pieces, random.permutation(np.array(lacking, np.int64)))


Share = Callable[[], float]
"""Elapsed share of the time; the search ends at 1."""


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
        """The parameters of :func:`~.annealing.anneal`."""
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
        """Make the next generation; the first ones are initial tours."""
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
    """Whether two tours are equal apart from their times."""
    return bool(np.array_equal(one.order, other.order) and np.array_equal(one.begins, other.begins))
