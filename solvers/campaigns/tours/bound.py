r"""A bound on the expense of all tours: prices of targets, raised until walks do each about once.

A mission of N targets whose legs come to X = Σ ΔV / exhaust speed carries at launch

    c  =  dry (e^X − 1) + kit Σ e^{X up to each target}  ≥  dry (e^X − 1) + kit N ,

which is convex in (X, N), and so is the expense of it, convex and growing in c. The tangent of
that expense at any X and N never exceeds it: every tangent makes a bound, with a launch, a target
and a unit of ΔV at fixed costs. Where the number of missions is given, one more price, a fee for
each launch that is given back for so many of them, makes walks launch about as often, and a tangent
that touches where so many missions share all targets loses least. Prices follow subgradients
(M. Held, P. Wolfe and H. Crowder, Mathematical Programming 6, 1974, 62–88), smoothed over rounds.
The value that counts is swept once more in double precision at the best prices.
"""

from __future__ import annotations

import math
import time
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from .costs import FORBIDDEN, Costs, Expense, Grid
from .walks import sweep, trace

FloatArray = npt.NDArray[np.float64]
Integers = npt.NDArray[np.int64]

SAFETY = 1e-6
"""Share by which a bound is lowered for rounding: sums of some thousand numbers lose far less."""

FEE = 3.0
"""What a fee is counted in, as a multiple of prices: launches are few, and dear."""

NEAR_M_S = 100.0
"""Scale of ΔV on which neighbours are told from others."""


@dataclass(frozen=True)
class Linear:
    """At most the expense of a mission: fixed + kit · targets + slope · units of ΔV."""

    fixed: float
    kit: float
    slope: float

    @classmethod
    def tangent(cls, expense: Expense, unit_m_s: float, carried_kg: float, legs: float) -> Linear:
        """The tangent where so much is carried and legs come to so much.

        Parameters
        ----------
        expense : Expense
        unit_m_s : float
        carried_kg : float
            c at the point of contact; its N need be no whole number, nor positive.
        legs : float
            X at the point of contact.
        """
        marginal = expense.per_kg + 2.0 * expense.per_kg_squared * carried_kg
        total = expense.fixed + expense.per_kg * carried_kg + expense.per_kg_squared * carried_kg**2
        # marginal · (dry (e^X − 1) + kit N − c), and e^X at least its own tangent.
        growth = math.exp(legs)
        slope = marginal * expense.dry_kg * growth
        fixed = total + marginal * (expense.dry_kg * (growth - 1.0) - carried_kg) - slope * legs
        return cls(fixed, marginal * expense.kit_kg, slope * unit_m_s / expense.exhaust_m_s)


@dataclass(frozen=True)
class Bounding:
    """How prices are raised.

    Attributes
    ----------
    rounds : int
        0: the given prices are only valued.
    time_limit_s : float
        Processor time of this thread [s].
    target : float
        What steps aim at; below the best bound it is taken to be a tenth above it.
    share : float
        Of the way there that the first steps go.
    patience : int
        Rounds without a better bound after which steps shorten.
    smoothing : float
        Weight of the directions before.
    most_step : float
        That a price changes by for each time that a target is done too often.
    """

    rounds: int = 100
    time_limit_s: float = math.inf
    target: float = 0.0
    share: float = 0.4
    patience: int = 5
    smoothing: float = 0.6
    most_step: float = 0.5


@dataclass(frozen=True)
class Bound:
    """A bound, and what proves it.

    Attributes
    ----------
    value : float
    prices : (targets,) float64
    rounds : int
    fee : float
        For each launch, where the number of missions is given.
    units : float
        ΔV of the legs of the last walk [units of the costs].
    """

    value: float
    prices: FloatArray
    rounds: int
    fee: float = 0.0
    units: float = 0.0


def neighbourhoods(cells: Costs, count: int) -> Integers:
    """The targets that each one has the most and the cheapest legs with, shape (targets, count).

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


def memories(neighbours: Integers) -> tuple[Integers, npt.NDArray[np.uint16]]:
    """What walks remember, for :func:`~.walks.sweep`.

    Returns
    -------
    bit : (targets, targets) int64
    carried : (targets, targets, memories) uint16
    """
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
    return bit, carried


class _Walks:
    """The cheapest walk at any prices, in a precision of its own."""

    def __init__(
        self,
        cells: Costs,
        grid: Grid,
        linear: Linear,
        bit: Integers,
        carried: npt.NDArray[np.uint16],
        kind: type[np.floating],
    ) -> None:
        times, targets = cells.shape[:2]
        self._kind = kind
        self._cells, self._linear = cells, linear
        self._rules = grid.apart, grid.least_gap, bit, carried
        self._walks = np.empty((targets, carried.shape[2], times), kind)
        self._ended = np.empty(times + 1, kind)
        self._done = np.zeros(targets, np.int64)

    def _asked(self, prices: FloatArray, fee: float) -> tuple[Any, ...]:
        kind, linear = self._kind, self._linear
        costs = kind(linear.slope), kind(linear.fixed + fee), kind(linear.kit)
        return (self._cells, *costs, prices.astype(kind), *self._rules, self._walks, self._ended)

    def value(self, prices: FloatArray, fee: float) -> float:
        """The least of all walks at some prices and a fee for launches, and all prices."""
        sweep(*self._asked(prices, fee))
        # No mission at all is a walk too.
        total = float(prices.astype(self._kind).sum(dtype=np.float64))
        return total + min(float(self._ended[-1]), 0.0)

    def missing(self, prices: FloatArray, fee: float) -> tuple[FloatArray, float, int]:
        """One less how often the cheapest walk does each target, its units and its missions.

        After :meth:`value` at the same prices.
        """
        units, missions = trace(*self._asked(prices, fee), self._done)
        return 1.0 - self._done.astype(np.float64), float(units), int(missions)


def bound(
    cells: Costs,
    grid: Grid,
    linear: Linear,
    bit: Integers,
    carried: npt.NDArray[np.uint16],
    settings: Bounding,
    prices: FloatArray | None = None,
    missions: int | None = None,
    fee: float = 0.0,
    tell: Callable[[int, float], None] | None = None,
) -> Bound:
    """The best bound that rounds of prices find.

    Parameters
    ----------
    cells : (times, targets, targets, gaps) uint16
        At most what a leg costs between arrivals in two cells, by the first of them.
    grid : Grid
        Of the cells: least gap, and cells between a last arrival and a launch.
    linear : Linear
    bit, carried : int64, uint16
        See :func:`memories`.
    settings : Bounding
    prices : (targets,) float64, optional
        To begin with; all the same, and no mission worth it, without.
    missions : int, optional
        The bound is on tours of so many missions; on all by default.
    fee : float
        To begin with, where it is given.
    tell : callable, optional
        Is called with the round and the best bound so far.
    """
    count = cells.shape[1]
    now = np.full(count, linear.kit) if prices is None else prices.astype(float)
    best, made = -math.inf, 0
    # The fee stands behind the prices; where it is none, nothing ever moves it.
    now = best_prices = np.append(now, fee / FEE if missions else 0.0)
    units, given = 0.0, missions or 0
    if settings.rounds > 0:
        walks = _Walks(cells, grid, linear, bit, carried, np.float32)
        share, stalled, direction = settings.share, 0, np.zeros(count + 1)
        since = time.thread_time()
        while made < settings.rounds and time.thread_time() - since < settings.time_limit_s:
            fee = FEE * now[-1]
            found = walks.value(now[:-1], fee) - fee * given
            short, units, launched = walks.missing(now[:-1], fee)
            missing = np.append(short, FEE * (launched - given) if missions else 0.0)
            weight = settings.smoothing if made else 0.0
            direction = weight * direction + (1.0 - weight) * missing
            made += 1
            if found > best:
                best, best_prices, stalled = found, now.copy(), 0
                if tell is not None:
                    tell(made, best)
            else:
                stalled += 1
                if stalled >= settings.patience:
                    share, stalled, now = 0.66 * share, 0, best_prices.copy()
                    direction = 0.3 * missing
            aim = max(settings.target, best + 0.1 * abs(best)) - found
            square = max(float(direction @ direction), 1e-9)
            now = now + min(share * max(aim, 1.0) / square, settings.most_step) * direction
        now = best_prices
    exact = _Walks(cells, grid, linear, bit, carried, np.float64)
    fee = FEE * float(now[-1])
    value = exact.value(now[:-1], fee) - fee * given
    # Sums lose a share of what they run through: prices on one side, costs on the other.
    value -= SAFETY * (
        abs(value) + float(np.abs(now[:-1]).sum()) + 2.0 * abs(fee) * (given + count)
    )
    return Bound(value, now[:-1], made, fee, units)
