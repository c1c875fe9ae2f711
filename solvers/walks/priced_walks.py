"""Longest walks that pay for their ΔV, so that tanks need no slots (docs/model.md section 8).

The walks of :mod:`.walks` know how much is left of a tank, in slots; that is what takes memory.
Here a unit of ΔV has a price λ ≥ 0 instead: a walk begins with the price of a tank, pays for each
leg, and gets the price of another tank at every refuelling. Every plan is such a walk, and since it
uses no more than its tanks hold, what it has got for them is no less than what it has paid:

    prizes collected ≤ Σ (prize_j − π_j) + λ Σ over tanks (budget − ΔV used) + Σ π_j
                     ≤ value of the best walk + Σ over all targets π_j .

The value depends on body and time alone. As there a walk never goes straight back to the target
that it came from, by best and second-best values. The legs are those of
:mod:`solvers.networks.packed_legs`, rounded so that more is allowed; all values are whole numbers,
so that sums are exact. Where a service changes what is left of a tank (``rules.loads``) ΔV is not
looked at, but that no leg takes more than the most.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from functools import partial
from typing import NamedTuple

import numpy as np

from adr_opt.kernels.core.compile import kernel
from adr_opt.mission.mission import Mission

from ..networks.packed_legs import AHEAD, DEPARTURE, DESTINATION, FIELD, Stream, first_leg
from .packed_bound import BestWalks, StreamBound

NEVER = -(2**60)
"""Value of infeasible states, far enough from −2⁶³ that additions cannot wrap around."""

LARGEST = 2.0**58
"""Upper limit of sums of values, next body included."""

TANK = 0.5
"""Tanks of ΔV that scale the last multiplier, so that it moves as far as the others."""

MOST_WORTH = 100.0
"""Upper limit of a tank's worth, in largest prizes."""


class Worths(NamedTuple):
    """Gains and costs of walks as integers, with values and next bodies packed in one.

    Attributes
    ----------
    gain : (bodies,) int64
        Of a service, ``value << bits | body``.
    toll : int
        Of a unit of ΔV, ``value << bits``.
    is_station : (bodies,) bool
    bits : int
    """

    gain: np.ndarray
    toll: np.int64
    is_station: np.ndarray
    bits: np.int64


@kernel
def _sweep(stream, worths, values, pointer, begin, stride, high, low):
    """Values of the steps ``low`` to ``high`` − 1 of every stride-th body, backwards.

    Parameters
    ----------
    values : BestWalks
        From each step and body, shape (steps + 1, bodies), int64.
    pointer : (bodies,) int64
        Behind the last leg that departs before ``high``; moved.
    """
    legs, gain, toll = stream.legs, worths.gain, worths.toll
    best, second = values
    mask = (np.int64(1) << worths.bits) - 1
    for i in range(begin, best.shape[1], stride):
        came_from = mask if worths.is_station[i] else np.int64(i)
        at, first = pointer[i], stream.first[i]
        for step in range(high - 1, low - 1, -1):
            # to wait
            found, other = best[step + 1, i], second[step + 1, i]
            while at > first and legs[at - 1] >> DEPARTURE >= step:
                at -= 1
                leg = legs[at]
                j, landing = (leg >> DESTINATION) & FIELD, step + ((leg >> AHEAD) & FIELD)
                value = best[landing, j]
                if value & mask == came_from:
                    value = second[landing, j]
                value = (value & ~mask) + gain[j] - (leg & FIELD) * toll
                if value > found:
                    if (value ^ found) & mask != 0:
                        other = found
                    found = value
                elif value > other and (value ^ found) & mask != 0:
                    other = value
            best[step, i], second[step, i] = found, other
        pointer[i] = at


@kernel
def _trace(stream, worths, values, step, body, walk, costs):
    """Follow the best walk from a step and a body: bodies and ΔV units; returns its length."""
    best, second = values
    mask = (np.int64(1) << worths.bits) - 1
    came_from, length = mask, 0
    while True:
        packed = best[step, body]
        if packed & mask == came_from:
            packed = second[step, body]
        j = packed & mask
        if j == body:
            return length
        low = first_leg(stream, body, step)
        came_from = mask if worths.is_station[body] else np.int64(body)
        # The first leg that yields this value: waiting for it costs nothing.
        while True:
            leg = stream.legs[low]
            landing = (leg >> DEPARTURE) + ((leg >> AHEAD) & FIELD)
            if (leg >> DESTINATION) & FIELD == j:
                value = best[landing, j]
                if value & mask == came_from:
                    value = second[landing, j]
                if (value & ~mask) + worths.gain[j] - (leg & FIELD) * worths.toll == packed:
                    break
            low += 1
        walk[length], costs[length] = j, leg & FIELD
        length += 1
        step, body = landing, j


class PooledBound(StreamBound):
    """Repeated evaluation of a mission's best walks, for given multipliers and a price of ΔV.

    Parameters
    ----------
    mission, stream, jobs, over
        See :class:`.packed_bound.StreamBound`.

    Attributes
    ----------
    prize : (dimensions,) float64
        Multipliers that leave services worth nothing.
    """

    def __init__(
        self,
        mission: Mission,
        stream: Stream,
        *,
        jobs: int = 1,
        over: Callable[[], bool] = lambda: False,
    ) -> None:
        # Each leg changes a value by a prize and what a multiplier may be above it, or by a tank.
        super().__init__(mission, stream, LARGEST, 3.0 + MOST_WORTH / TANK, jobs, over)
        self.prize = np.append(self.worth, 0.0)
        self._best = np.empty((stream.steps + 1, self.worth.size), dtype=np.int64)
        self._second = np.empty_like(self._best)
        self._walk, self._costs = np.empty((2, self._most_legs + 1), dtype=np.int64)

    @property
    def dimensions(self) -> int:
        """Number of multipliers: one for each body, and the price of ΔV."""
        return int(self.prize.size)

    def first_point(self) -> np.ndarray:
        """Initial multipliers: bonuses, as walks have them, and no price."""
        return np.append(self._bonuses, 0.0)

    def allowed(self, point: np.ndarray) -> np.ndarray:
        """Nearest multipliers at which the bound can be evaluated."""
        price = min(max(float(point[-1]), 0.0), MOST_WORTH * self._greatest)
        return np.append(self._within(point[:-1]), price)

    def at(self, point: np.ndarray) -> tuple[float, np.ndarray, np.ndarray]:
        """Bound near a point, with its exact multipliers and its subgradient.

        −inf if there is no plan at all.
        """
        tank = TANK * max(self._units, 1)
        gain, multipliers = self._rounded(point[:-1])
        toll = math.floor(point[-1] / tank / self._unit) if self._units else 0
        gain[self._is_station] = toll * self._units
        rounded = np.append(multipliers, toll * self._unit * tank)
        value = self._evaluate(gain, toll)
        tanks = 1 + np.count_nonzero(self._is_station[self.walk])
        unused = tanks * self._units - self._costs[: self.walk.size].sum()
        slope = np.append(self._missing(), unused / tank)
        return value + float(multipliers.sum()), rounded, slope

    def per_m_s(self, multipliers: np.ndarray) -> float:
        """Price of ΔV at an evaluated point [worth per m/s]."""
        if not self._units:
            return 0.0
        return float(multipliers[-1]) / (TANK * self._units) / self._stream.unit

    def _evaluate(self, gain: np.ndarray, toll: int) -> float:
        """Value of the best walk, the price of its first tank included."""
        bodies, stream = np.arange(self.worth.size), self._stream
        worths = Worths(
            (gain << self._bits) + bodies,
            np.int64(toll << self._bits),
            self._is_station,
            np.int64(self._bits),
        )
        best, second, pointer = self._best, self._second, stream.last.copy()
        # In the last step a walk can only stop, where it may, and has itself as next.
        best[stream.steps] = np.where(self._may_end, bodies, NEVER)
        second[stream.steps] = NEVER
        values = BestWalks(best, second)
        self._sweep(partial(_sweep, stream, worths, values, pointer))
        root = int(best[stream.root, self._start])
        if root < NEVER // 2:
            self.walk = self._walk[:0]
            return -math.inf
        start = stream.root, self._start
        length = _trace(stream, worths, values, *start, self._walk, self._costs)
        self.walk = self._walk[:length].copy()
        return ((root >> self._bits) + toll * self._units) * self._unit
