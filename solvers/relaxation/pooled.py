"""Longest walks that pay for their ΔV, so that tanks need no slots (MODEL section 8).

The walks of :mod:`.walks` know how much is left of a tank, in slots; that is what takes memory.
Here a unit of ΔV has a price λ ≥ 0 instead: a walk begins with the price of a tank, pays for each
leg, and gets the price of another tank at every refuelling. Every plan is such a walk, and since it
uses no more than its tanks hold, what it has got for them is no less than what it has paid:

    prizes collected ≤ Σ (prize_j − π_j) + λ Σ over tanks (budget − ΔV used) + Σ π_j
                     ≤ value of the best walk + Σ over all targets π_j .

The value depends on body and time alone. As there a walk never goes straight back to the target
that it came from, by best and second-best values. The legs are those of :mod:`.stream`, rounded so
that more is allowed; all values are whole numbers, so that sums are exact. Where a service changes
what is left of a tank (``rules.loads``) ΔV is not looked at, but that no leg takes more than the
most.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from typing import NamedTuple

import numpy as np

from adr_opt.kernels.compile import kernel
from adr_opt.mission import Mission

from .stream import AHEAD, DEPARTURE, DESTINATION, FIELD, Stream, units_of
from .walks import TimeIsOver, bonuses

NEVER = -(2**60)
"""Value of what is not possible; far enough from −2⁶³ that adding to it cannot wrap around."""

LARGEST = 2.0**58
"""No sum of values exceeds it in size, the next body included."""

TANK = 0.5
"""The last multiplier is what so many tanks of ΔV are worth: so it moves as far as the others."""

MOST_WORTH = 100.0
"""That is worth so many of the largest prizes at most."""


class Worths(NamedTuple):
    """What walks get and pay, in whole numbers, values and next bodies packed in one.

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
def _sweep(stream, worths, best, second, pointer, begin, stride, high, low):
    """Values of the steps ``low`` to ``high`` − 1 of every stride-th body, backwards.

    Parameters
    ----------
    best, second : (steps + 1, bodies) int64
        Of the best walk from there, and of the best one with another next body.
    pointer : (bodies,) int64
        Behind the last leg that departs before ``high``; moved.
    """
    legs, gain, toll = stream.legs, worths.gain, worths.toll
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
def _trace(stream, worths, best, second, step, body, walk, costs):
    """Follow the best walk from a step and a body: bodies and units of ΔV; returns its length."""
    mask = (np.int64(1) << worths.bits) - 1
    came_from, length = mask, 0
    while True:
        packed = best[step, body]
        if packed & mask == came_from:
            packed = second[step, body]
        j = packed & mask
        if j == body:
            return length
        low, high = stream.first[body], stream.last[body]
        while low < high:
            middle = (low + high) // 2
            if stream.legs[middle] >> DEPARTURE < step:
                low = middle + 1
            else:
                high = middle
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


class PooledBound:
    """Best walks of a mission for given multipliers and a price of ΔV, again and again.

    Parameters
    ----------
    mission : Mission
    stream : Stream
        Its legs; none of them may land where it departed.
    jobs : int
        Threads.
    over : callable
        Asked now and then whether the time is over.

    Attributes
    ----------
    prize : (dimensions,) float64
        Multipliers that leave services worth nothing.
    walk : (legs,) int64
        Best walk of the last evaluation: bodies in order.
    """

    def __init__(
        self,
        mission: Mission,
        stream: Stream,
        *,
        jobs: int = 1,
        over: Callable[[], bool] = lambda: False,
    ) -> None:
        rules = mission.rules
        self._stream, self._jobs, self._over = stream, jobs, over
        self._worth = np.array(rules.prize)
        self.prize = np.append(self._worth, 0.0)
        self._bonuses = bonuses(mission)
        bodies = self._worth.size
        self._is_target = np.arange(bodies) >= rules.first_target
        self._is_station, self._may_end = rules.is_station, rules.may_end
        self._start = rules.start
        self._units = units_of(rules.budget, stream.unit)
        self._bits = int(bodies).bit_length()
        self._greatest = float(self._worth.max(initial=0.0)) or 1.0
        most_legs = stream.steps // max(1, stream.least) + 2
        # Each leg changes a value by a prize and what a multiplier may be above it, or by a tank.
        room = LARGEST / (1 << self._bits) / most_legs / (3.0 + MOST_WORTH / TANK) / self._greatest
        self._unit = 2.0 ** -math.floor(math.log2(room))
        self._best = np.empty((stream.steps + 1, bodies), dtype=np.int64)
        self._second = np.empty_like(self._best)
        self._walk, self._costs = np.empty((2, most_legs + 1), dtype=np.int64)
        self.walk = self._walk[:0]
        self._pool = ThreadPoolExecutor(jobs) if jobs > 1 else None

    @property
    def dimensions(self) -> int:
        """Number of multipliers: one for each body, and the price of ΔV."""
        return int(self._worth.size) + 1

    @property
    def total(self) -> float:
        """The sum of all prizes."""
        return float(self._worth[self._is_target].sum())

    @property
    def radius(self) -> float:
        """How far from the best multipliers the next ones are looked for."""
        return 10.0 * self._greatest

    def first_point(self) -> np.ndarray:
        """Multipliers to begin with: bonuses, as walks have them, and no price."""
        return np.append(self._bonuses, 0.0)

    def allowed(self, point: np.ndarray) -> np.ndarray:
        """The nearest multipliers at which the bound can be evaluated."""
        allowed: np.ndarray = np.clip(point, 0.0, self.prize + self._greatest)
        allowed[:-1][~self._is_target] = 0.0
        allowed[-1] = min(max(float(point[-1]), 0.0), MOST_WORTH * self._greatest)
        return allowed

    def at(self, point: np.ndarray) -> tuple[float, np.ndarray, np.ndarray]:
        """The bound near a point, the multipliers for which it holds, and its slope there.

        −inf if there is no plan at all.
        """
        targets, tank = self._is_target, TANK * max(self._units, 1)
        # Multipliers are rounded down so that what a service is worth beside them is a whole number
        # of units; where none is left that number is rounded up.
        gain = np.ceil((self._worth - point[:-1]) / self._unit)
        multipliers = np.maximum(0.0, self._worth - gain * self._unit)
        gain = np.where(multipliers > 0.0, gain, np.ceil(self._worth / self._unit))
        gain = gain.astype(np.int64)
        toll = math.floor(point[-1] / tank / self._unit) if self._units else 0
        gain[~targets], multipliers[~targets] = 0, 0.0
        gain[self._is_station] = toll * self._units
        rounded = np.append(multipliers, toll * self._unit * tank)
        value = self._evaluate(gain, toll)
        tanks = 1 + np.count_nonzero(self._is_station[self.walk])
        slope = 1.0 - np.bincount(self.walk, minlength=self._worth.size).astype(float)
        slope[~targets] = 0.0
        unused = tanks * self._units - self._costs[: self.walk.size].sum()
        return value + float(multipliers.sum()), rounded, np.append(slope, unused / tank)

    def _evaluate(self, gain: np.ndarray, toll: int) -> float:
        """Value of the best walk, the price of its first tank included."""
        bodies, steps = np.arange(self._worth.size), self._stream.steps
        worths = Worths(
            (gain << self._bits) + bodies, np.int64(toll << self._bits), self._is_station,
            np.int64(self._bits),
        )  # fmt: skip
        best, second = self._best, self._second
        # In the last step a walk can only stop, where it may, and has itself as next.
        best[steps] = np.where(self._may_end, bodies, NEVER)
        second[steps] = NEVER
        pointer, high = self._stream.last.copy(), steps
        while high > 0:
            if self._over():
                raise TimeIsOver
            # No leg that departs in these steps lands in one of them.
            low = max(0, high - self._stream.least)
            common = self._stream, worths, best, second, pointer
            if self._pool is None:
                _sweep(*common, 0, 1, high, low)
            else:
                parts = [
                    self._pool.submit(_sweep, *common, first, self._jobs, high, low)
                    for first in range(self._jobs)
                ]
                for part in parts:
                    part.result()
            high = low
        root = int(best[self._stream.root, self._start])
        if root < NEVER // 2:
            self.walk = self._walk[:0]
            return -math.inf
        length = _trace(
            self._stream,
            worths,
            best,
            second,
            self._stream.root,
            self._start,
            self._walk,
            self._costs,
        )  # fmt: skip
        self.walk = self._walk[:length].copy()
        return ((root >> self._bits) + toll * self._units) * self._unit

    def close(self) -> None:
        """End the threads."""
        if self._pool is not None:
            self._pool.shutdown()
