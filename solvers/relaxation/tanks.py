"""Longest walks over a stream of legs that know how much is left of a tank (MODEL section 8).

Where ΔV has a price (:mod:`.pooled`), what one tank has left another one may spend. Here a walk
has so many whole units left, the slots of :mod:`.walks`, and a station fills them up. Values
depend on body, step and units: some hundred bytes for each body and step, and as much to read for
each leg, so that one set of multipliers takes about as many times longer as there are units. The
bound it leads to is far lower where missions refuel often.

As in all walks here nobody goes straight back to the target that he came from, by best and
second-best values; and everything is rounded so that more is allowed, see :mod:`.stream`.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor

import numpy as np

from adr_opt.kernels.compile import kernel
from adr_opt.mission import Mission

from . import simd
from .stream import AHEAD, DEPARTURE, DESTINATION, FIELD, Stream, units_of
from .sweeps import NEVER
from .walks import LARGEST, TimeIsOver, bonuses

BYTES = 8
"""Memory of each unit of ΔV at each body and step."""


def width_of(budget: float, unit: float) -> int:
    """Numbers that a body takes at a step: one for each number of units left, in whole vectors."""
    return (units_of(budget, unit) // simd.LANES + 1) * simd.LANES


@kernel
def _sweep(stream, gain, is_station, bits, width, top, best, second, pointer, begin, stride, high,
           low):  # fmt: skip
    """Values of the steps ``low`` to ``high`` − 1 of every stride-th body, backwards.

    Parameters
    ----------
    gain : (bodies,) int32
        Of a service, ``value << bits | body``.
    best, second : (width + bodies (steps + 1) width,) int32
        Of the best walk from there with so many units left, and of the best one with another next
        body; packed with the next body.
    pointer : (bodies,) int64
        Behind the last leg that departs before ``high``; moved.
    """
    legs, bodies, steps = stream.legs, stream.first.size, stream.steps
    mask = (1 << bits) - 1
    keep_value, keep_next, never = simd.spread(~mask), simd.spread(mask), simd.spread(NEVER)
    for i in range(begin, bodies, stride):
        # From a station nothing is forbidden; no body has all bits set.
        back = mask if is_station[i] else i
        came_from = simd.spread(back)
        at, first = pointer[i], stream.first[i]
        for step in range(high - 1, low - 1, -1):
            end = at
            while at > first and legs[at - 1] >> DEPARTURE >= step:
                at -= 1
            here = (i * (steps + 1) + step + 1) * width
            for c in range(0, width, simd.LANES):
                # to wait
                found = simd.load(best, here + width + c)
                other = simd.load(second, here + width + c)
                left = simd.plus(simd.count_up(), simd.spread(c))
                for number in range(at, end):
                    leg = legs[number]
                    cost = leg & FIELD
                    if c + simd.LANES <= cost:
                        continue
                    j = (leg >> DESTINATION) & FIELD
                    there = (j * (steps + 1) + step + ((leg >> AHEAD) & FIELD) + 1) * width
                    if is_station[j]:
                        full = best[there + top]
                        if full & mask == back:
                            full = second[there + top]
                        value = simd.both(simd.spread(full), keep_value)
                    else:
                        value = simd.load(best, there + c - cost)
                        instead = simd.load(second, there + c - cost)
                        value = simd.where_equal(
                            simd.both(value, keep_next), came_from, instead, value
                        )
                        value = simd.both(value, keep_value)
                    value = simd.plus(value, simd.spread(gain[j]))
                    value = simd.where_less(left, simd.spread(cost), never, value)
                    loser = simd.smaller(found, value)
                    found = simd.larger(found, value)
                    loser = simd.where_same(found, loser, keep_next, never)
                    other = simd.larger(other, loser)
                simd.store(best, here + c, found)
                simd.store(second, here + c, other)
        pointer[i] = at


@kernel
def _trace(stream, gain, is_station, bits, width, top, best, second, step, body, walk):
    """Follow the best walk from a step and a body with a full tank; returns its length."""
    mask, steps = (1 << bits) - 1, stream.steps
    came_from, length, left = mask, 0, top
    while True:
        place = (body * (steps + 1) + step + 1) * width + left
        packed = best[place]
        if packed & mask == came_from:
            packed = second[place]
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
        came_from = mask if is_station[body] else np.int64(body)
        # The first leg that yields this value: waiting for it costs nothing.
        while True:
            leg = stream.legs[low]
            low += 1
            rest = left - (leg & FIELD)
            if (leg >> DESTINATION) & FIELD != j or rest < 0:
                continue
            if is_station[j]:
                rest = np.int64(top)
            landing = (leg >> DEPARTURE) + ((leg >> AHEAD) & FIELD)
            there = (j * (steps + 1) + landing + 1) * width + rest
            value = best[there]
            if value & mask == came_from:
                value = second[there]
            if (value & ~mask) + gain[j] == packed:
                break
        walk[length] = j
        length += 1
        step, body, left = landing, j, rest


class TankBound:
    """Best walks of a mission for given multipliers, again and again.

    Parameters
    ----------
    mission : Mission
        Without loads: no service changes what is left of its tank.
    stream : Stream
        Its legs; none of them may land where it departed.
    start : (bodies,) float64, optional
        Multipliers to begin with.
    jobs : int
        Threads.
    over : callable
        Asked now and then whether the time is over.

    Attributes
    ----------
    prize : (bodies,) float64
        Multipliers that leave services worth nothing.
    walk : (legs,) int64
        Best walk of the last evaluation: bodies in order.
    """

    def __init__(
        self,
        mission: Mission,
        stream: Stream,
        *,
        start: np.ndarray | None = None,
        jobs: int = 1,
        over: Callable[[], bool] = lambda: False,
    ) -> None:
        rules = mission.rules
        assert rules.loads is None
        self._stream, self._jobs, self._over = stream, jobs, over
        self.prize = np.array(rules.prize)
        self._first_point = bonuses(mission) if start is None else start
        bodies = self.prize.size
        self._is_target = np.arange(bodies) >= rules.first_target
        self._is_station, self._may_end, self._start = rules.is_station, rules.may_end, rules.start
        self._top = units_of(rules.budget, stream.unit)
        self._width = width_of(rules.budget, stream.unit)
        self._bits = int(bodies).bit_length()
        self._greatest = float(self.prize.max(initial=0.0)) or 1.0
        most_legs = stream.steps // max(1, stream.least) + 2
        # Each leg changes a value by a prize and what a multiplier may be above it.
        room = LARGEST / (1 << self._bits) / most_legs / 3.0 / self._greatest
        self._unit = 2.0 ** -math.floor(math.log2(room))
        size = self._width * (1 + bodies * (stream.steps + 1))
        self._best, self._second = np.empty(size, dtype=np.int32), np.empty(size, dtype=np.int32)
        self._walk = np.empty(most_legs + 1, dtype=np.int64)
        self.walk = self._walk[:0]
        self._pool = ThreadPoolExecutor(jobs) if jobs > 1 else None

    @property
    def dimensions(self) -> int:
        """Number of multipliers: one for each body."""
        return int(self.prize.size)

    @property
    def total(self) -> float:
        """The sum of all prizes."""
        return float(self.prize[self._is_target].sum())

    @property
    def radius(self) -> float:
        """How far from the best multipliers the next ones are looked for."""
        return 10.0 * self._greatest

    def first_point(self) -> np.ndarray:
        """Multipliers to begin with: those given, or bonuses, as walks have them."""
        return self._first_point.copy()

    def allowed(self, point: np.ndarray) -> np.ndarray:
        """The nearest multipliers at which the bound can be evaluated."""
        allowed: np.ndarray = np.clip(point, 0.0, self.prize + self._greatest)
        allowed[~self._is_target] = 0.0
        return allowed

    def at(self, point: np.ndarray) -> tuple[float, np.ndarray, np.ndarray]:
        """The bound near a point, the multipliers for which it holds, and its slope there.

        −inf if there is no plan at all.
        """
        # Multipliers are rounded down so that what a service is worth beside them is a whole number
        # of units; where none is left that number is rounded up.
        gain = np.ceil((self.prize - point) / self._unit)
        multipliers = np.maximum(0.0, self.prize - gain * self._unit)
        gain = np.where(multipliers > 0.0, gain, np.ceil(self.prize / self._unit))
        gain[~self._is_target], multipliers[~self._is_target] = 0.0, 0.0
        value = self._evaluate(gain.astype(np.int64))
        slope = 1.0 - np.bincount(self.walk, minlength=self.prize.size).astype(float)
        slope[~self._is_target] = 0.0
        return value + float(multipliers.sum()), multipliers, slope

    def _evaluate(self, gain: np.ndarray) -> float:
        """Value of the best walk."""
        bodies, steps, width = np.arange(self.prize.size), self._stream.steps, self._width
        worth = ((gain << self._bits) + bodies).astype(np.int32)
        best, second = self._best, self._second
        # In the last step a walk can only stop, where it may, and has itself as next.
        last = best[width:].reshape(bodies.size, steps + 1, width)[:, steps]
        last[:] = np.where(self._may_end, bodies, NEVER)[:, None]
        second[width:].reshape(bodies.size, steps + 1, width)[:, steps] = NEVER
        best[:width], second[:width] = NEVER, NEVER
        pointer, high = self._stream.last.copy(), steps
        rules = worth, self._is_station, np.int64(self._bits), width, self._top
        while high > 0:
            if self._over():
                raise TimeIsOver
            # No leg that departs in these steps lands in one of them.
            low = max(0, high - self._stream.least)
            common = self._stream, *rules, best, second, pointer
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
        root = self._start * (steps + 1) + self._stream.root + 1
        found = int(best[root * width + self._top])
        if found < NEVER // 2:
            self.walk = self._walk[:0]
            return -math.inf
        length = _trace(
            self._stream, *rules, best, second, self._stream.root, self._start, self._walk
        )
        self.walk = self._walk[:length].copy()
        return (found >> self._bits) * self._unit

    def close(self) -> None:
        """End the threads."""
        if self._pool is not None:
            self._pool.shutdown()
