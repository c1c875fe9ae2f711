r"""Lower bound on the expense of all tours, by Lagrangian prices on visits to targets.

A mission whose legs come to X = Σ ΔV / exhaust speed carries at launch

    c  =  dry (e^X − 1) + kit Σ e^{X up to each target} ,

and its expense is convex and growing in c. The tangent at any c never exceeds it: every tangent
makes a bound, with a launch and a kilogram at launch at fixed costs. Where the number of missions
is given, one more price, a fee for each launch that is given back for this number, makes walks
launch about as often, and the tangent at the mean load of that many missions loses
least. Prices follow subgradients (M. Held, P. Wolfe and H. Crowder, Mathematical Programming 6,
1974, 62–88), smoothed over rounds; where walks are mixtures, of some that are drawn. The value that
counts is swept once more in double precision at the best prices.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from adr_opt.common.clock import now_s

from .cell_walks import LeastWalks, MassCosts, Memories, sweep
from .costs import FORBIDDEN, Costs, TimeGrid, TourExpense
from .traced_walks import trace

FloatArray = npt.NDArray[np.float64]
Integers = npt.NDArray[np.int64]

SAFETY = 1e-6
"""Relative reduction of a bound for rounding: sums of some thousand numbers lose far less."""

FEE = 3.0
"""Unit of a fee, as a multiple of prices: launches are few, and expensive."""

BEFORE = 1.25
"""Ratio of the highest level to the mass touched by a tangent: beyond it, the cost of a kilogram is
that at launch, without earlier legs."""

BEYOND = 1e35
"""Mass growth of a forbidden leg: beyond any cost, but finite."""

DRAWN = 8
"""Number of walks of a mixture whose mean gives a direction."""

NEAR_M_S = 100.0
"""Scale of ΔV that distinguishes neighbours."""


@dataclass(frozen=True)
class Tangent:
    """A tangent from below to the expense of a mission: fixed + per_kg · mass at launch.

    Attributes
    ----------
    fixed, per_kg : float
    touches_kg : float
        The mass at launch of which it is the expense.
    """

    fixed: float
    per_kg: float
    touches_kg: float

    @classmethod
    def at(cls, expense: TourExpense, carried_kg: float) -> Tangent:
        """The tangent at a carried mass.

        Parameters
        ----------
        expense : TourExpense
        carried_kg : float
            Kits and propellant.
        """
        per_kg = expense.per_kg + 2.0 * expense.per_kg_squared * carried_kg
        fixed = expense.fixed - expense.per_kg_squared * carried_kg**2
        return cls(fixed - per_kg * expense.dry_kg, per_kg, expense.dry_kg + carried_kg)


@dataclass(frozen=True)
class Bounding:
    """Schedule by which prices are raised.

    Attributes
    ----------
    rounds : int
        0: the given prices are only valued.
    time_limit_s : float
        [s].
    share : float
        Of the way there that the first steps go.
    patience : int
        Rounds without a better bound after which steps shorten.
    smoothing : float
        Weight of the directions before.
    most_step : float
        That a price changes by for each time that a target is done too often.
    levels : int
        Masses between which costs are linear, at least two.
    """

    rounds: int = 100
    time_limit_s: float = math.inf
    share: float = 0.4
    patience: int = 5
    smoothing: float = 0.6
    most_step: float = 0.5
    levels: int = 3


@dataclass(frozen=True)
class Bound:
    """A bound with its evidence.

    Attributes
    ----------
    value : float
    prices : (targets,) float64
    rounds : int
    fee : float
        For each launch, where the number of missions is given.
    carried_kg : float
        By a mission of the last walks in the mean; 0 where none was worth it.
    hoped : float
        The best value of the rounds, which used the likely cells alone.
    """

    value: float
    prices: FloatArray
    rounds: int
    fee: float = 0.0
    carried_kg: float = 0.0
    hoped: float = -math.inf


def neighbourhoods(cells: Costs, count: int) -> Integers:
    """Targets with the most and the cheapest legs to each one, shape (targets, count).

    Parameters
    ----------
    cells : (times, targets, targets, gaps) uint16
    count : int
    """
    targets = cells.shape[1]
    near = np.zeros((targets, targets))
    for now in cells:
        least = now.min(axis=2)
        near += np.where(least == FORBIDDEN, 0.0, np.exp(-0.1 * least / NEAR_M_S))
    near = near + near.T
    np.fill_diagonal(near, -1.0)
    return np.argsort(-near, axis=1, kind="stable")[:, :count]


def memories(neighbours: Integers) -> Memories:
    """Memory of walks, for :func:`~.cell_walks.sweep`."""
    targets, count = neighbours.shape
    bit = np.full((targets, targets), -1, np.int64)
    for i in range(targets):
        bit[i, neighbours[i]] = np.arange(count)
    memory = np.arange(1 << count)
    carried = np.zeros((targets, targets, memory.size), np.uint16)
    for i in range(targets):
        for j in range(targets):
            found = np.zeros(memory.size, np.int64)
            if bit[j, i] >= 0:
                found |= 1 << bit[j, i]
            for place, other in enumerate(neighbours[i]):
                if bit[j, other] >= 0:
                    found |= ((memory >> place) & 1) << bit[j, other]
            carried[i, j] = found
    return Memories(bit, carried)


def levels_of(expense: TourExpense, tangent: Tangent, count: int) -> FloatArray:
    """Masses in a geometric series from an empty chaser to beyond the tangent's [kg].

    Parameters
    ----------
    expense : TourExpense
    tangent : Tangent
    count : int
    """
    full_kg = expense.dry_kg + expense.most_propellant_kg
    top_kg = min(BEFORE * tangent.touches_kg, full_kg)
    return np.geomspace(expense.dry_kg, max(top_kg, BEFORE * expense.dry_kg), count)


def growths(expense: TourExpense, unit_m_s: float) -> FloatArray:
    """Relative mass growth by legs of each number of units, shape (65536,)."""
    growth: FloatArray = np.exp(np.arange(FORBIDDEN + 1) * (unit_m_s / expense.exhaust_m_s))
    growth[FORBIDDEN] = BEYOND
    return growth


class _Walks:
    """The cheapest walk at any prices, in its own precision."""

    def __init__(
        self,
        cells: Costs,
        grid: TimeGrid,
        expense: TourExpense,
        tangent: Tangent,
        memory_of: Memories,
        levels: int,
        kind: type[np.floating],
    ) -> None:
        times, targets = cells.shape[:2]
        self._kind = kind
        self._cells, self._expense, self._tangent = cells, expense, tangent
        self._growth = growths(expense, grid.unit_m_s).astype(kind)
        self._level = levels_of(expense, tangent, levels).astype(kind)
        self._rules = grid, memory_of
        self._least = LeastWalks(
            np.empty((targets, memory_of.carried.shape[2], levels, times), kind),
            np.empty(times + 1, kind),
        )
        self._done = np.zeros(targets, np.int64)

    def _arguments(self, prices: FloatArray, fee: float) -> tuple[Any, ...]:
        kind, tangent = self._kind, self._tangent
        costs = kind(tangent.per_kg), kind(tangent.fixed + fee), kind(self._expense.kit_kg)
        masses = MassCosts(self._growth, self._level, *costs)
        return self._cells, masses, prices.astype(kind), *self._rules, self._least

    def value(self, prices: FloatArray, fee: float) -> float:
        """Least cost of all walks at some prices and a fee for launches, plus all prices."""
        sweep(*self._arguments(prices, fee))
        # No mission at all is a walk too.
        total = float(prices.astype(self._kind).sum(dtype=np.float64))
        return total + min(float(self._least.ended[-1]), 0.0)

    def missing(
        self, prices: FloatArray, fee: float, random: np.random.Generator
    ) -> tuple[FloatArray, float, float]:
        """Subgradient (one minus the cheapest walks' visits to each target), missions, and load.

        After :meth:`value` at the same prices; means over some walks that are drawn.
        """
        done, mass, missions = np.zeros(self._done.size), 0.0, 0
        for _ in range(DRAWN):
            draws = random.random(4 * self._done.size)
            more_mass, more = trace(*self._arguments(prices, fee), draws, self._done)
            done, mass, missions = done + self._done, mass + float(more_mass), missions + int(more)
        carried_kg = mass / max(missions, 1) - self._expense.dry_kg
        return 1.0 - done / DRAWN, missions / DRAWN, carried_kg


@dataclass(frozen=True)
class FirstPrices:
    """Initial values of a bound.

    Attributes
    ----------
    prices : (targets,) float64, optional
        All the same, and no mission worth it, without.
    missions : int, optional
        Number of missions of the tours that the bound is on; on all tours by default.
    fee : float
        For each launch, where their number is given.
    """

    prices: FloatArray | None = None
    missions: int | None = None
    fee: float = 0.0


ALL_TOURS = FirstPrices()


def bound(
    cells: Costs,
    grid: TimeGrid,
    expense: TourExpense,
    tangent: Tangent,
    memory_of: Memories,
    settings: Bounding,
    first: FirstPrices = ALL_TOURS,
    likely: Costs | None = None,
) -> Bound:
    """The best bound found by rounds of prices.

    Parameters
    ----------
    cells : (times, targets, targets, gaps) uint16
        At most what a leg costs between arrivals in two cells, by the first of them.
    grid : TimeGrid
        Of the cells: least gap, and cells between a last arrival and a launch.
    expense : TourExpense
    tangent : Tangent
        Of that expense.
    memory_of : Memories
        See :func:`memories`.
    settings : Bounding
    first : FirstPrices
    likely : array, optional
        The same cells, less those that hardly any walk uses: prices are found on these, far faster,
        and valued on all of them.
    """
    prices, missions, fee = first.prices, first.missions, first.fee
    count = cells.shape[1]
    kit_price = tangent.per_kg * expense.kit_kg
    now = np.full(count, kit_price) if prices is None else prices.astype(float)
    best, made = -math.inf, 0
    # The fee stands behind the prices; where it is none, nothing ever moves it.
    now = best_prices = np.append(now, fee / FEE if missions else 0.0)
    carried_kg, given = 0.0, missions or 0
    arguments = cells, grid, expense, tangent, memory_of, settings.levels
    if settings.rounds > 0:
        of_rounds = cells if likely is None else likely, *arguments[1:]
        walks, random = _Walks(*of_rounds, np.float32), np.random.default_rng(0)
        share, stalled, direction = settings.share, 0, np.zeros(count + 1)
        since = now_s()
        while made < settings.rounds and now_s() - since < settings.time_limit_s:
            fee = FEE * now[-1]
            found = walks.value(now[:-1], fee) - fee * given
            short, launched, mean_kg = walks.missing(now[:-1], fee, random)
            carried_kg = mean_kg if launched else carried_kg
            missing = np.append(short, FEE * (launched - given) if missions else 0.0)
            weight = settings.smoothing if made else 0.0
            direction = weight * direction + (1.0 - weight) * missing
            made += 1
            if found > best:
                best, best_prices, stalled = found, now.copy(), 0
            else:
                stalled += 1
                if stalled >= settings.patience:
                    share, stalled, now = 0.66 * share, 0, best_prices.copy()
                    direction = 0.3 * missing
            aim = best + 0.1 * abs(best) - found
            square = max(float(direction @ direction), 1e-9)
            now = now + min(share * max(aim, 1.0) / square, settings.most_step) * direction
        now = best_prices
        del walks  # its walks take as much memory as half of those below
    exact = _Walks(*arguments, np.float64)
    fee = FEE * float(now[-1])
    value = exact.value(now[:-1], fee) - fee * given
    # Sums lose a share of what they run through: prices on one side, costs on the other.
    value -= SAFETY * (
        abs(value) + float(np.abs(now[:-1]).sum()) + 2.0 * abs(fee) * (given + count)
    )
    return Bound(value, now[:-1], made, fee, carried_kg, best)
