"""Longest walks over packed legs that track the tank.

See docs/model.md section 8.

Where ΔV has a price (:mod:`.priced_walks`), what one tank has left another one may spend. Here a
walk has whole units left, the slots of :mod:`.walks`, and a station fills them up. Values
depend on body, step and units: some hundred bytes for each body and step, and as much to read for
each leg, so that one set of multipliers takes about as many times longer as there are units. The
bound it leads to is far lower where missions refuel often.

As in all walks here, none goes straight back to the target that it came from, by best and
second-best values; and everything is rounded so that more is allowed, see
:mod:`solvers.networks.packed_legs`.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from functools import partial
from typing import NamedTuple

import numpy as np

from adr_opt.kernels.core.compile import kernel
from adr_opt.mission.mission import Mission

from ..networks import simd
from ..networks.packed_legs import AHEAD, DEPARTURE, DESTINATION, FIELD, Stream, first_leg, units_of
from .packed_bound import BestWalks, StreamBound
from .sweeps import NEVER
from .walks import LARGEST

BYTES = 8
"""Memory per unit of ΔV at each body and step [bytes]."""


def width_of(budget: float, unit: float) -> int:
    """Size of a body's entry at a step: one number per units left, padded to whole vectors."""
    return (units_of(budget, unit) // simd.LANES + 1) * simd.LANES


class TankTerms(NamedTuple):
    """Gains of walks, with the packing and layout of their values.

    Attributes
    ----------
    gain : (bodies,) int32
        Of a service, ``value << bits | body``.
    is_station : (bodies,) bool
    bits : int
    width : int
        Numbers of a body and step.
    top : int
        Units of a full tank.
    """

    gain: np.ndarray
    is_station: np.ndarray
    bits: np.int64
    width: int
    top: int


@kernel
def _sweep(stream, terms, values, pointer, begin, stride, high, low):
    """Values of the steps ``low`` to ``high`` − 1 of every stride-th body, backwards.

    Parameters
    ----------
    values : BestWalks
        From each body and step with each number of units left, shape
        (width + bodies (steps + 1) width,), int32.
    pointer : (bodies,) int64
        Behind the last leg that departs before ``high``; moved.
    """
    legs, bodies, steps = stream.legs, stream.first.size, stream.steps
    gain, is_station, bits, width, top = terms
    best, second = values
    mask = (1 << bits) - 1
    keep_value, keep_next, never = simd.spread(~mask), simd.spread(mask), simd.spread(NEVER)
    # As in :mod:`.sweeps`: legs lead to later steps, of which all values are there already, also of
    # other threads' bodies, since no leg is shorter than what is swept at once; and best and second
    # hold, for each body that one may not go straight back to, the best of all others.
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
def _trace(stream, terms, values, step, body, walk):
    """Follow the best walk from a step and a body with a full tank; returns its length."""
    gain, is_station, bits, width, top = terms
    best, second = values
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
        low = first_leg(stream, body, step)
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


class TankBound(StreamBound):
    """Repeated evaluation of a mission's best walks for given multipliers.

    Parameters
    ----------
    mission, stream, jobs, over
        See :class:`.packed_bound.StreamBound`; no service of the mission changes what is left of
        its tank.
    start : (bodies,) float64, optional
        Multipliers to begin with; bonuses, as walks have them, by default.

    Attributes
    ----------
    prize : (bodies,) float64
        Multipliers that leave services worth nothing.
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
        assert mission.rules.loads is None
        # Each leg changes a value by a prize and what a multiplier may be above it.
        super().__init__(mission, stream, LARGEST, 3.0, jobs, over)
        self.prize = self.worth
        self._first_point = self._bonuses if start is None else start
        self._width = width_of(mission.rules.budget, stream.unit)
        size = self._width * (1 + self.worth.size * (stream.steps + 1))
        self._best, self._second = np.empty(size, dtype=np.int32), np.empty(size, dtype=np.int32)
        self._walk = np.empty(self._most_legs + 1, dtype=np.int64)

    @property
    def dimensions(self) -> int:
        """Number of multipliers: one for each body."""
        return int(self.prize.size)

    def first_point(self) -> np.ndarray:
        """Initial multipliers."""
        return self._first_point.copy()

    def allowed(self, point: np.ndarray) -> np.ndarray:
        """Nearest multipliers at which the bound can be evaluated."""
        return self._within(point)

    def at(self, point: np.ndarray) -> tuple[float, np.ndarray, np.ndarray]:
        """Bound near a point, with its exact multipliers and its subgradient.

        −inf if there is no plan at all.
        """
        gain, multipliers = self._rounded(point)
        value = self._evaluate(gain)
        return value + float(multipliers.sum()), multipliers, self._missing()

    def _evaluate(self, gain: np.ndarray) -> float:
        """Value of the best walk."""
        bodies, stream, width = np.arange(self.worth.size), self._stream, self._width
        worth = ((gain << self._bits) + bodies).astype(np.int32)
        best, second, pointer = self._best, self._second, stream.last.copy()
        # In the last step a walk can only stop, where it may, and has itself as next.
        shape = bodies.size, stream.steps + 1, width
        best[width:].reshape(shape)[:, -1] = np.where(self._may_end, bodies, NEVER)[:, None]
        second[width:].reshape(shape)[:, -1] = NEVER
        best[:width], second[:width] = NEVER, NEVER
        terms = TankTerms(worth, self._is_station, np.int64(self._bits), width, self._units)
        values = BestWalks(best, second)
        self._sweep(partial(_sweep, stream, terms, values, pointer))
        root = self._start * (stream.steps + 1) + stream.root + 1
        found = int(best[root * width + self._units])
        if found < NEVER // 2:
            self.walk = self._walk[:0]
            return -math.inf
        length = _trace(stream, terms, values, stream.root, self._start, self._walk)
        self.walk = self._walk[:length].copy()
        return (found >> self._bits) * self._unit
