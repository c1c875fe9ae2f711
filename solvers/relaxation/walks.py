"""Longest walks backwards in time, for given multipliers (MODEL section 8).

The relaxation. A *walk* may service a target again and again, but never two legs after leaving it
(i → j → i is forbidden, also when j is a station); each service of target j is worth its prize
less a multiplier π_j ≥ 0. The best walk from every (body, time, ΔV left) comes out of one sweep
backwards in time. Every plan is a walk: its moves are the walk's moves, and each step below only
widens what is allowed. So for every plan, and for every completion of a partial plan,

    prizes collected = Σ over its targets (prize_j − π_j) + Σ over its targets π_j
                     ≤ value of the best walk + Σ over the targets not yet visited π_j .

What is exact and what is relaxed:

- Walks move on the network of :mod:`.buckets`: who arrives within a bucket of time arrives at its
  beginning, and one arc leads from each bucket of a body to the next one, to wait. That is one
  comparison a leg and a slot. Services that would end too late are left out exactly. With buckets
  of no length time is exact.
- ΔV is counted in slots. The slots of a leg are rounded down and so is the budget: if the legs fit
  into the budget, then Σ ⌊ΔV/u⌋ ≤ ⌊Σ ΔV/u⌋ ≤ ⌊budget/u⌋. A relaxation, the better the finer.
- Values are whole numbers of units, so sums are exact and there is no rounding error to guard
  against: the multipliers are those for which prize_j − π_j is a whole number of units.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from typing import NamedTuple

import numpy as np

from adr_opt.kernels.compile import kernel
from adr_opt.kernels.timetable import earliest_taken
from adr_opt.mission import Mission

from . import simd
from .buckets import SLACK, assign
from .buckets import build as fill
from .network import Network, build

NEVER = -(2**30)
"""Value of what is not possible; far enough from −2³¹ that adding to it cannot wrap around."""

LARGEST = 2**29
"""No sum of values exceeds it in size, code included."""


BUCKET_SHARE = 1.0 / 60.0
"""Usual length of a bucket of time, as a share of the shortest leg."""

ROOM_BYTES = 0.6e9
"""Memory that the values of all states may take."""


class Values(NamedTuple):
    """Values of all states.

    A value is packed with the next body of the walk, ``value << bits | next``, so that comparing
    compares values and the better next body comes along. A walk that stops has itself as next.

    Attributes
    ----------
    best : (slots before + buckets·width,) int32
        Best walk of (bucket, ΔV slots left); ``width`` numbers before the first one keep reads in
        bounds.
    second : the same shape
        Best walk with another next body: what a chaser that just left the best's next may take.
    """

    best: np.ndarray
    second: np.ndarray


@kernel
def _sweep_buckets(buckets, best, second, code, toll, bits, width, top, i, high, low):
    """Values of the buckets ``low`` to ``high`` − 1 (counted within body i), backwards."""
    mask = (1 << bits) - 1
    keep_value = simd.spread(~mask)
    keep_next = simd.spread(mask)
    never = simd.spread(NEVER)
    # From a station nothing is forbidden; no code has all bits set.
    came_from = simd.spread(mask if buckets.is_station[i] else i)
    base = buckets.start[i]
    priced = toll.size > 0
    for bucket in range(base + high - 1, base + low - 1, -1):
        begin, end = buckets.first[bucket], buckets.first[bucket + 1]
        for c in range(0, width, simd.LANES):
            # to wait
            found = simd.load(best, (bucket + 2) * width + c)
            other = simd.load(second, (bucket + 2) * width + c)
            left = simd.plus(simd.count_up(), simd.spread(c))
            for leg in range(begin, end):
                cost = buckets.cost[leg]
                if c + simd.LANES <= cost:
                    continue
                j = buckets.destination[leg]
                landing = (buckets.landing[leg] + 1) * width
                if buckets.is_station[j]:
                    full = best[landing + top]
                    if full & mask == i:
                        full = second[landing + top]
                    value = simd.both(simd.spread(full), keep_value)
                else:
                    value = simd.load(best, landing + c - cost)
                    instead = simd.load(second, landing + c - cost)
                    value = simd.where_equal(simd.both(value, keep_next), came_from, instead, value)
                    value = simd.both(value, keep_value)
                gain = code[j]
                if priced:
                    gain -= toll[leg] << bits
                value = simd.plus(value, simd.spread(gain))
                value = simd.where_less(left, simd.spread(cost), never, value)
                loser = simd.smaller(found, value)
                found = simd.larger(found, value)
                loser = simd.where_same(found, loser, keep_next, never)
                other = simd.larger(other, loser)
            simd.store(best, (bucket + 1) * width + c, found)
            simd.store(second, (bucket + 1) * width + c, other)


@kernel
def _begin(buckets, best, second, width, begun):
    """In closing buckets a walk can only stop, where it may; what lies before all is NEVER."""
    best[:width] = NEVER
    second[:width] = NEVER
    for i in range(buckets.start.size - 1):
        closing = buckets.start[i + 1] * width
        best[closing : closing + width] = i if buckets.may_end[i] else NEVER
        second[closing : closing + width] = NEVER
        begun[i] = buckets.start[i + 1] - 1 - buckets.start[i]


@kernel
def _sweep_until(
    buckets, best, second, code, toll, bits, width, top, begun, begin, step, time
):  # fmt: skip
    """Values of all buckets that open at a time or after, of every step-th body from ``begin``."""
    earliest = earliest_taken(time)
    for i in range(begin, buckets.start.size - 1, step):
        high = begun[i]
        low = high
        while low > 0 and buckets.opens[buckets.start[i] + low - 1] >= earliest:
            low -= 1
        _sweep_buckets(buckets, best, second, code, toll, bits, width, top, i, high, low)
        begun[i] = low


@kernel
def _trace(buckets, best, second, code, toll, bits, width, top, bucket, body, left, walk):
    """Follow the best walk from a state; returns its length."""
    mask = (1 << bits) - 1
    came_from = mask
    length = 0
    while True:
        packed = best[(bucket + 1) * width + left]
        if packed & mask == came_from:
            packed = second[(bucket + 1) * width + left]
        j = packed & mask
        if j == body:
            return length
        # The first leg that yields this value: waiting for it costs nothing.
        onward, leg = -1, buckets.first[bucket]
        while onward < 0:
            if buckets.destination[leg] == j and buckets.cost[leg] <= left:
                rest = top if buckets.is_station[j] else left - buckets.cost[leg]
                landing = buckets.landing[leg]
                ahead = best[(landing + 1) * width + rest]
                if not buckets.is_station[body] and ahead & mask == body:
                    ahead = second[(landing + 1) * width + rest]
                paid = toll[leg] if toll.size > 0 else 0
                if (ahead >> bits) + (code[j] >> bits) - paid == packed >> bits:
                    onward = landing
            leg += 1
        walk[length] = j
        length += 1
        left = rest
        came_from = mask if buckets.is_station[body] else body
        bucket, body = onward, j


def affordable(buckets: int, budget: float, slot: float) -> float:
    """The slot asked for, widened until the values of all states fit into memory [m/s]."""
    while slot < budget and 8.0 * buckets * (budget / slot + simd.LANES) > ROOM_BYTES:
        slot *= 2.0
    return slot


class TimeIsOver(Exception):
    """An evaluation was broken off."""


class WalkBound:
    """Best walks of a mission for given multipliers, again and again.

    Parameters
    ----------
    mission : Mission
    delta_v_slot_m_s : float
        Slot of the ΔV axis, widened where values would not fit into memory [m/s].
    bucket_share : float
        Length of a bucket of time as a share of the shortest leg; 0 for exact times.
    jobs : int
        Threads.
    over : callable
        Asked now and then whether the time is over.
    network : Network, optional
        That of the mission, where it is known.
    parts : int
        Steps of ΔV in a slot that legs are told apart by, for walks that pay for it.

    Attributes
    ----------
    network : Network
    buckets : Buckets
        What walks move on.
    values : Values
    slot : float
        Slot in use [m/s].
    most_legs : int
        No walk has more.
    unit : float
        Prize that one unit of value is worth.
    price : float
        What a m/s takes off the value of a walk; 0 for nothing.
    worths : (bodies,) float64
        What targets are worth in the mission.
    toll : (legs kept,) int32
        What a leg takes off a walk's value [units]; empty for nothing.
    walk : (legs,) int64
        Best walk of the last evaluation: bodies in order.
    """

    def __init__(
        self,
        mission: Mission,
        delta_v_slot_m_s: float,
        bucket_share: float = BUCKET_SHARE,
        jobs: int = 1,
        over: Callable[[], bool] = lambda: False,
        network: Network | None = None,
        parts: int = 1,
    ) -> None:
        rules = mission.rules
        self._over = over
        self.prize = np.array(rules.prize)
        self.is_target = np.arange(self.prize.size) >= rules.first_target
        self.start = rules.start
        self.most_targets = rules.most_targets
        bodies = self.prize.size
        self.network = network or build(mission, jobs=jobs)
        assignment = assign(self.network, bucket_share)
        self.slot = affordable(int(assignment.start[-1]), rules.budget, delta_v_slot_m_s)
        self.top = math.floor(rules.budget / self.slot + SLACK)
        self.width = (self.top // simd.LANES + 1) * simd.LANES
        self._jobs = jobs
        self.buckets = fill(
            self.network, assignment, rules.budget, self.slot, parts=parts, jobs=jobs
        )
        size = (int(self.buckets.start[-1]) + 1) * self.width
        self.values = Values(np.empty(size, dtype=np.int32), np.empty(size, dtype=np.int32))
        # Buckets of one stage do not land in it, so their bodies are independent.
        self._stage = earliest_taken(self.buckets.shortest) * (1.0 - 1e-9)
        self._stages = int(rules.duration / self._stage) + 1 if self._stage > 0.0 else 1
        self.bits = int(bodies).bit_length()
        self.most_legs = self._stages + 1
        self.budget = rules.budget
        self.greatest_prize = float(self.prize.max(initial=0.0)) or 1.0
        room = LARGEST / (1 << self.bits) / self.most_legs / self.greatest_prize
        # A power of two, so that units are exact numbers.
        self.unit = 2.0 ** -math.floor(math.log2(room))
        self.toll = np.empty(0, dtype=np.int32)
        self.price, self.worths = 0.0, self.prize
        self._begun = np.empty(bodies, dtype=np.int64)
        self._walk = np.empty(self.most_legs + 1, dtype=np.int64)
        self.walk = self._walk[:0]
        self._pool = ThreadPoolExecutor(jobs) if jobs > 1 else None

    @property
    def dimensions(self) -> int:
        """Number of multipliers: one for each body."""
        return int(self.prize.size)

    @property
    def total(self) -> float:
        """The sum of all prizes: the bound of multipliers as large as they are."""
        return float(self.prize[self.is_target].sum())

    @property
    def radius(self) -> float:
        """How far from the best multipliers the next ones are looked for."""
        return self.greatest_prize

    def first_point(self) -> np.ndarray:
        """Multipliers to begin with: none."""
        return np.zeros(self.prize.size)

    def allowed(self, point: np.ndarray) -> np.ndarray:
        """The nearest multipliers at which the bound can be evaluated."""
        point = np.clip(point, 0.0, self.prize + self.greatest_prize)
        point[~self.is_target] = 0.0
        return point

    def at(self, point: np.ndarray) -> tuple[float, np.ndarray, np.ndarray]:
        """The bound near a point, the multipliers for which it holds, and its slope there."""
        value, rounded = self.evaluate(point)
        slope = 1.0 - np.bincount(self.walk, minlength=self.prize.size)
        slope[~self.is_target] = 0.0
        return value, rounded, slope

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
            No plan has a larger objective; −inf if there is none at all.
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
        gain[~self.is_target], rounded[~self.is_target] = 0.0, 0.0
        code = (gain.astype(np.int64) << self.bits) + np.arange(gain.size)
        code = code.astype(np.int32)
        value = self._longest(code)
        if value is None:
            return -math.inf, rounded
        return value * self.unit + float(rounded.sum()), rounded

    def _longest(self, code: np.ndarray) -> int | None:
        """Value of the best walk in units; ``code`` holds what each service is worth, packed.

        None if there is no walk: the mission cannot end where it must.
        """
        buckets, (best, second) = self.buckets, self.values
        _begin(buckets, best, second, self.width, self._begun)
        common = (buckets, best, second, code, self.toll, self.bits, self.width, self.top)
        self._sweep(_sweep_until, *common, self._begun)
        value = int(best[(buckets.root + 1) * self.width + self.top]) >> self.bits
        if value < -LARGEST >> self.bits:
            self.walk = self._walk[:0]
            return None
        length = _trace(*common, buckets.root, self.start, self.top, self._walk)
        self.walk = self._walk[:length].copy()
        return value
