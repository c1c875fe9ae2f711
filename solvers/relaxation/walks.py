"""Longest walks backwards in time where chasers may wait, for given multipliers.

The relaxation is that of :mod:`solvers.walks`: a walk may service a target again, but not two legs
after leaving it; each service of target j is worth its prize less a multiplier; ΔV is counted in
slots, rounded down; time is exact. But walks move on the network of :mod:`.network`, where one may
wait and take any sequence. That is one comparison a leg and a slot, instead of one for each
destination that lies ahead.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from adr_opt.kernels.compile import kernel
from adr_opt.kernels.constants import STATION
from adr_opt.kernels.timetable import earliest_taken
from adr_opt.mission import Mission

from .. import lanes
from ..walks import NEVER, WalkBound
from .network import build


@kernel
def _sweep_rows(network, best, second, code, bits, width, top, i, high, low):
    """Values of the rows ``low`` to ``high`` − 1 (counted within body i), backwards."""
    mask = (1 << bits) - 1
    keep_value = lanes.spread(~mask)
    keep_next = lanes.spread(mask)
    never = lanes.spread(NEVER)
    # From the station nothing is forbidden; no code has all bits set.
    came_from = lanes.spread(i if i != STATION else mask)
    base = network.start[i]
    for row in range(base + high - 1, base + low - 1, -1):
        j = network.destination[row]
        gain = lanes.spread(code[j])
        begin, end = network.first_kept[row], network.first_kept[row + 1]
        for c in range(0, width, lanes.LANES):
            # to wait
            found = lanes.load(best, (row + 2) * width + c)
            other = lanes.load(second, (row + 2) * width + c)
            left = lanes.plus(lanes.count_up(), lanes.spread(c))
            for leg in range(begin, end):
                cost = network.cost[leg]
                if c + lanes.LANES <= cost:
                    continue
                landing = (network.landing_kept[leg] + 1) * width
                if j == STATION:
                    full = best[landing + top]
                    if full & mask == i:
                        full = second[landing + top]
                    value = lanes.plus(lanes.both(lanes.spread(full), keep_value), gain)
                else:
                    value = lanes.load(best, landing + c - cost)
                    instead = lanes.load(second, landing + c - cost)
                    value = lanes.where_equal(
                        lanes.both(value, keep_next), came_from, instead, value
                    )
                    value = lanes.plus(lanes.both(value, keep_value), gain)
                value = lanes.where_less(left, lanes.spread(cost), never, value)
                loser = lanes.smaller(found, value)
                found = lanes.larger(found, value)
                loser = lanes.where_same(found, loser, keep_next, never)
                other = lanes.larger(other, loser)
            lanes.store(best, (row + 1) * width + c, found)
            lanes.store(second, (row + 1) * width + c, other)


@kernel
def _begin(network, best, second, width, begun):
    """In closing rows a walk can only stop; ``width`` numbers before all rows keep reads inside."""
    best[:width] = NEVER
    second[:width] = NEVER
    for i in range(network.start.size - 1):
        closing = network.start[i + 1] * width
        best[closing : closing + width] = i
        second[closing : closing + width] = NEVER
        begun[i] = network.start[i + 1] - 1 - network.start[i]


@kernel
def _sweep_until(network, best, second, code, bits, width, top, begun, begin, step, time):
    """Values of all rows taken at a time or after, of every step-th body from ``begin``."""
    earliest = earliest_taken(time)
    for i in range(begin, network.start.size - 1, step):
        high = begun[i]
        low = high
        while low > 0 and network.departure[network.start[i] + low - 1] >= earliest:
            low -= 1
        _sweep_rows(network, best, second, code, bits, width, top, i, high, low)
        begun[i] = low


@kernel
def _trace(network, best, second, code, bits, width, top, row, body, left, walk):
    """Follow the best walk from a state; returns its length."""
    mask = (1 << bits) - 1
    came_from = mask
    length = 0
    while True:
        packed = best[(row + 1) * width + left]
        if packed & mask == came_from:
            packed = second[(row + 1) * width + left]
        j = packed & mask
        if j == body:
            return length
        # The first leg that yields this value: waiting for it costs nothing.
        onward = -1
        while onward < 0:
            if network.destination[row] == j:
                for leg in range(network.first_kept[row], network.first_kept[row + 1]):
                    if network.cost[leg] > left:
                        continue
                    rest = top if j == STATION else left - network.cost[leg]
                    landing = network.landing_kept[leg]
                    ahead = best[(landing + 1) * width + rest]
                    if body != STATION and ahead & mask == body:
                        ahead = second[(landing + 1) * width + rest]
                    if (ahead >> bits) + (code[j] >> bits) == packed >> bits:
                        onward = landing
                        break
            row += 1
        walk[length] = j
        length += 1
        left = rest
        came_from = body if body != STATION else mask
        row, body = onward, j


class Values(NamedTuple):
    """Values of all states: see :class:`solvers.walks.Values`."""

    best: np.ndarray
    second: np.ndarray


class WaitingBound(WalkBound):
    """Best walks of a mission in which chasers may wait, for given multipliers.

    As :class:`solvers.walks.WalkBound`; ``network`` is a :class:`.network.WaitingNetwork`.
    """

    def _build(self, mission: Mission) -> float:
        # At resolution 0 nothing is left out that some chaser could want.
        self.network = build(mission, self.slot, resolution_m_s=0.0, jobs=self._jobs)
        size = (int(self.network.start[-1]) + 1) * self.width
        self.values = Values(np.empty(size, dtype=np.int32), np.empty(size, dtype=np.int32))
        return float(self.network.shortest)

    def _longest(self, code: np.ndarray) -> int:
        network, (best, second) = self.network, self.values
        _begin(network, best, second, self.width, self._begun)
        common = (network, best, second, code, self.bits, self.width, self.top)
        self._sweep(_sweep_until, *common, self._begun)
        row = int(network.start[STATION])
        length = _trace(*common, row, STATION, self.top, self._walk)
        self.walk = self._walk[:length].copy()
        return int(best[(row + 1) * self.width + self.top]) >> self.bits
