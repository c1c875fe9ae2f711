"""Longest walks backwards in time, for given multipliers (MODEL section 7).

The relaxation. A *walk* may service a target again and again, but never two legs after leaving it
(i → j → i is forbidden, also when j is the station); each service of target j is worth its prize
less a multiplier π_j ≥ 0. The best walk from every (body, time, ΔV left) comes out of one sweep
backwards in time. Every plan is a walk: its moves are the walk's moves, and each step below only
widens what is allowed. So for every plan, and for every completion of a partial plan,

    prizes collected = Σ over its targets (prize_j − π_j) + Σ over its targets π_j
                     ≤ value of the best walk + Σ over the targets not yet visited π_j .

What is exact and what is relaxed:

- Time is exact. All that matters of a time is which departure events lie ahead, so a *row* of
  the table stands for the times between one event of a body and the next one, and the moves from
  a row are exactly the next events of all destinations: no waiting past an event. Services that
  would end after the mission are left out exactly.
- ΔV is counted in slots. The slots of a leg are rounded down and so is the budget: if the legs fit
  into the budget, then Σ ⌊ΔV/u⌋ ≤ ⌊Σ ΔV/u⌋ ≤ ⌊budget/u⌋. A relaxation, the better the finer.
- Values are whole numbers of units, so sums are exact and there is no rounding error to guard
  against: the multipliers are those for which prize_j − π_j is a whole number of units.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from typing import Any, NamedTuple

import numpy as np

from adr_opt.kernels.compile import kernel
from adr_opt.kernels.constants import STATION
from adr_opt.kernels.timetable import earliest_taken
from adr_opt.mission import Mission

from . import lanes
from .network import SLACK, build_network

NEVER = -(2**30)
"""Value of what is not possible; far enough from −2³¹ that adding to it cannot wrap around."""

LARGEST = 2**29
"""No sum of values exceeds it in size, code included."""


class Values(NamedTuple):
    """Values of all states, and the desk on which they are worked out.

    A value is packed with the next body of the walk, ``value << bits | next``, so that comparing
    compares values and the better next body comes along. A walk that stops has itself as next.

    Attributes
    ----------
    best : (slots before + rows·width,) int32
        Best walk of (row, ΔV slots left); ``width`` numbers before the first row keep reads in
        bounds.
    second : the same shape
        Best walk with another next body: what a chaser that just left the best's next may take.
    legs, ahead, ahead_second : (bodies·block·width,) int32
        Values by leg of the block of rows at work, and prefix maxima of the block after it.
    suffix, suffix_second : (bodies·width,) int32
        Maxima over the rows of the block at work that were done.
    """

    best: np.ndarray
    second: np.ndarray
    legs: np.ndarray
    ahead: np.ndarray
    ahead_second: np.ndarray
    suffix: np.ndarray
    suffix_second: np.ndarray


@kernel
def _sweep_rows(network, values, code, bits, width, top, i, high, low):
    """Values of the rows ``low`` to ``high`` − 1 (counted within body i), backwards.

    The moves from a row are a window of legs that slides, so its maximum is that of a suffix of
    one block and a prefix of the next one (van Herk 1992): three maxima a row for any number of
    destinations. Where events are not equally spaced a window may end within its own block; the
    whole suffix is taken then, which only adds moves.
    """
    base = network.start[i]
    block = network.block[i]
    stride = values.legs.size // (network.start.size - 1)
    desk = i * stride
    suffix = i * width
    mask = (1 << bits) - 1
    keep_value = lanes.spread(~mask)
    keep_next = lanes.spread(mask)
    never = lanes.spread(NEVER)
    stop = lanes.spread(i)
    # From the station nothing is forbidden; no code has all bits set.
    came_from = lanes.spread(i if i != STATION else mask)
    for r in range(high - 1, low - 1, -1):
        place = r % block
        row = base + r
        leg = desk + place * width
        landing = network.landing[row]
        if place == block - 1:
            for c in range(0, width, lanes.LANES):
                lanes.store(values.suffix, suffix + c, never)
                lanes.store(values.suffix_second, suffix + c, never)
        j = network.destination[row]
        cost = network.cost[row]
        gain = lanes.spread(code[j])
        least = lanes.spread(cost)
        refuelled = never
        if landing >= 0 and j == STATION:
            full = (landing + 1) * width + top
            packed = values.best[full]
            if packed & mask == i:
                packed = values.second[full]
            refuelled = lanes.plus(lanes.both(lanes.spread(packed), keep_value), gain)
        window_end = network.last[row] - base
        ahead = desk + (window_end % block) * width
        crosses = window_end // block != r // block
        source = (landing + 1) * width - cost
        target = (row + 1) * width
        for c in range(0, width, lanes.LANES):
            value = never
            if landing >= 0 and c + lanes.LANES > cost:
                if j == STATION:
                    value = refuelled
                else:
                    value = lanes.load(values.best, source + c)
                    other = lanes.load(values.second, source + c)
                    value = lanes.where_equal(lanes.both(value, keep_next), came_from, other, value)
                    value = lanes.plus(lanes.both(value, keep_value), gain)
                left = lanes.plus(lanes.count_up(), lanes.spread(c))
                value = lanes.where_less(left, least, never, value)
            lanes.store(values.legs, leg + c, value)
            # into the suffix of this block
            best = lanes.load(values.suffix, suffix + c)
            second = lanes.load(values.suffix_second, suffix + c)
            loser = lanes.smaller(best, value)
            best = lanes.larger(best, value)
            loser = lanes.where_same(best, loser, keep_next, never)
            second = lanes.larger(second, loser)
            lanes.store(values.suffix, suffix + c, best)
            lanes.store(values.suffix_second, suffix + c, second)
            # with the prefix of the next block
            if crosses:
                value = lanes.load(values.ahead, ahead + c)
                other = lanes.load(values.ahead_second, ahead + c)
                loser = lanes.smaller(best, value)
                best = lanes.larger(best, value)
                loser = lanes.where_same(best, loser, keep_next, never)
                second = lanes.larger(lanes.larger(second, other), loser)
            # a walk may stop
            second = lanes.larger(second, lanes.smaller(best, stop))
            best = lanes.larger(best, stop)
            lanes.store(values.best, target + c, best)
            lanes.store(values.second, target + c, second)
        if place == 0:
            for c in range(0, width, lanes.LANES):
                best = never
                second = never
                for q in range(block):
                    at = desk + q * width + c
                    value = lanes.load(values.legs, at)
                    loser = lanes.smaller(best, value)
                    best = lanes.larger(best, value)
                    loser = lanes.where_same(best, loser, keep_next, never)
                    second = lanes.larger(second, loser)
                    lanes.store(values.ahead, at, best)
                    lanes.store(values.ahead_second, at, second)


@kernel
def _begin(network, values, width):
    """Clear the desk, and the closing rows: there a walk can only stop."""
    values.best[:width] = NEVER
    values.second[:width] = NEVER
    values.legs[:] = NEVER
    values.suffix[:] = NEVER
    values.suffix_second[:] = NEVER
    for i in range(network.start.size - 1):
        closing = network.start[i + 1] * width
        values.best[closing : closing + width] = i
        values.second[closing : closing + width] = NEVER


@kernel
def _sweep_until(network, values, code, bits, width, top, begun, first, step, time):
    """Values of all rows that are taken at a time or after, of every step-th body from first."""
    earliest = earliest_taken(time)
    for i in range(first, network.start.size - 1, step):
        high = begun[i]
        low = high
        while low > 0 and network.departure[network.start[i] + low - 1] >= earliest:
            low -= 1
        _sweep_rows(network, values, code, bits, width, top, i, high, low)
        begun[i] = low


@kernel
def _trace(network, values, bits, width, top, row, body, left, walk):
    """Follow the best walk from a state; returns its length."""
    mask = (1 << bits) - 1
    came_from = mask
    length = 0
    while True:
        packed = values.best[(row + 1) * width + left]
        if packed & mask == came_from:
            packed = values.second[(row + 1) * width + left]
        j = packed & mask
        if j == body:
            return length
        walk[length] = j
        length += 1
        while network.destination[row] != j:
            row += 1
        left = top if j == STATION else left - network.cost[row]
        came_from = body if body != STATION else mask
        row = network.landing[row]
        body = j


class TimeIsOver(Exception):
    """An evaluation was broken off."""


class WalkBound:
    """Best walks of a mission for given multipliers, again and again.

    Parameters
    ----------
    mission : Mission
    delta_v_slot_m_s : float
        Slot of the ΔV axis [m/s].
    jobs : int
        Threads.
    over : callable
        Asked now and then whether the time is over.

    Attributes
    ----------
    network : Network
    delta_v : (rows,) float64
        Exact ΔV of its legs [m/s].
    slot : float
        Slot in use [m/s].
    most_legs : int
        No walk has more.
    unit : float
        Prize that one unit of value is worth.
    walk : (legs,) int64
        Best walk of the last evaluation: bodies in order.
    """

    def __init__(
        self,
        mission: Mission,
        delta_v_slot_m_s: float,
        jobs: int = 1,
        over: Callable[[], bool] = lambda: False,
    ) -> None:
        rules = mission.rules
        self._over = over
        self.prize = np.array(rules.prize)
        bodies = self.prize.size
        self.slot = delta_v_slot_m_s
        self.top = math.floor(rules.budget / self.slot + SLACK)
        self.width = (self.top // lanes.LANES + 1) * lanes.LANES
        self._jobs = jobs
        shortest = self._build(mission)
        # Rows within one stage do not land in it, so their bodies are independent.
        self._stage = earliest_taken(shortest) * (1.0 - 1e-9)
        self._stages = int(rules.duration / self._stage) + 1 if self._stage > 0.0 else 1
        self.bits = int(bodies).bit_length()
        self.most_legs = self._stages + 1
        self.budget = rules.budget
        self.greatest_prize = float(self.prize.max(initial=0.0)) or 1.0
        room = LARGEST / (1 << self.bits) / self.most_legs / self.greatest_prize
        # A power of two, so that units are exact numbers.
        self.unit = 2.0 ** -math.floor(math.log2(room))
        self._begun = np.empty(bodies, dtype=np.int64)
        self._walk = np.empty(self.most_legs + 1, dtype=np.int64)
        self.walk = self._walk[:0]
        self._pool = ThreadPoolExecutor(jobs) if jobs > 1 else None

    network: Any  # of another kind where chasers may wait
    values: Any

    def _build(self, mission: Mission) -> float:
        """Build the network and room for values; the shortest time of a leg and its service [s]."""
        self.network, self.delta_v, shortest = build_network(mission, self.slot)
        bodies = self.prize.size
        rows = int(self.network.start[-1])
        block = int(self.network.block.max())
        size = (rows + 1) * self.width
        desk = bodies * block * self.width
        self.values = Values(
            *(np.empty(size, dtype=np.int32) for _ in range(2)),
            *(np.empty(desk, dtype=np.int32) for _ in range(3)),
            *(np.empty(bodies * self.width, dtype=np.int32) for _ in range(2)),
        )
        return shortest

    def _sweep(self, sweep_until: Callable[..., None], *common: object) -> None:
        """Go backwards in time stage by stage, the bodies shared among the threads."""
        for number in range(self._stages - 1, -1, -1):
            if self._over():
                raise TimeIsOver
            time = number * self._stage
            if self._pool is None:
                sweep_until(*common, 0, 1, time)
                continue
            parts = [
                self._pool.submit(sweep_until, *common, first, self._jobs, time)
                for first in range(self._jobs)
            ]
            for part in parts:
                part.result()

    def close(self) -> None:
        """End the threads."""
        if self._pool is not None:
            self._pool.shutdown()

    def evaluate(self, multipliers: np.ndarray, *, keep: bool = False) -> tuple[float, np.ndarray]:
        """The bound of given multipliers.

        Parameters
        ----------
        multipliers : (bodies,) float64
            π of each target, at least 0 and at most its prize plus the largest prize.
        keep : bool
            Take the multipliers as they are, and round what services are worth up to units, which
            relaxes; otherwise round the multipliers so that there is nothing to round.

        Returns
        -------
        bound : float
            No plan has a larger objective.
        multipliers : (bodies,) float64
            Those for which the bound holds.

        Raises
        ------
        TimeIsOver
            It was broken off.
        """
        whole = np.floor(self.prize / self.unit)
        least = np.rint(-self.greatest_prize / self.unit)
        if keep:
            rounded = np.array(multipliers)
            gain = np.maximum(np.ceil((self.prize - rounded) / self.unit), least)
        else:
            gain = np.rint((self.prize - multipliers) / self.unit)
            gain = np.clip(gain, least, whole)
            rounded = self.prize - gain * self.unit
        gain[STATION] = 0.0
        rounded[STATION] = 0.0
        code = (gain.astype(np.int64) << self.bits) + np.arange(gain.size)
        code = code.astype(np.int32)
        code[STATION] = 0
        return self._longest(code) * self.unit + float(rounded[1:].sum()), rounded

    def _longest(self, code: np.ndarray) -> int:
        """Value of the best walk in units; ``code`` holds what each service is worth, packed."""
        network, width = self.network, self.width
        _begin(network, self.values, width)
        self._begun[:] = np.diff(network.start) - 1
        self._sweep(
            _sweep_until, network, self.values, code, self.bits, width, self.top, self._begun
        )
        row = int(network.start[STATION])
        length = _trace(
            network, self.values, self.bits, width, self.top, row, STATION, self.top, self._walk
        )
        self.walk = self._walk[:length].copy()
        return int(self.values.best[(row + 1) * width + self.top]) >> self.bits
