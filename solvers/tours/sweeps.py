"""Least costs of a tour before and after each target, over a window of times.

A mission's expense is taken as linear: each leg has a slope, what another unit of ΔV there costs.
Rows of costs lie along time, so that loops over them use all lanes of the processor.
"""

from typing import NamedTuple

import numpy as np

from adr_opt.kernels.core.compile import inlined, kernel
from adr_opt.kernels.core.memory import borrowed

from .costs import FAR


class TourLeg(NamedTuple):
    """A leg of a tour: its two targets, cost per unit (float32), and the first gap."""

    one: int
    other: int
    slope: np.float32
    least_gap: int


class LegWindows(NamedTuple):
    """Arrival windows of a leg: first ``low`` to ``high``, then ``first`` to ``last``."""

    low: int
    high: int
    first: int
    last: int


@inlined
def along(source, i, cost, leg, windows, target, o):
    """Lower costs of arrivals where legs from earlier arrivals are cheaper.

    Numbers of places are unsigned: for others each look asks whether it counts from the end, and
    loops do not use all lanes of the processor.

    Parameters
    ----------
    source : (…, times) float32
        Row ``i`` holds the costs up to the earlier arrival.
    i, o : int
    cost : (targets, targets, gaps, times) uint16
    leg : TourLeg
    windows : LegWindows
    target : (…, times) float32
        Row ``o`` is lowered.
    """
    j, k, slope, least_gap = leg
    low, high, first, last = windows
    i, j, k, o = np.uint64(i), np.uint64(j), np.uint64(k), np.uint64(o)
    for g in range(np.uint64(cost.shape[2])):
        step = least_gap + np.int64(g)
        begin, end = max(low, first - step), min(high, last - step)
        ahead = np.uint64(step)
        for t in range(np.uint64(begin), np.uint64(max(begin, end))):
            found = source[i, t] + slope * np.float32(cost[j, k, g, t])
            kept = target[o, t + ahead]
            target[o, t + ahead] = found if found < kept else kept


@inlined
def against(source, i, cost, leg, windows, target, o):
    """Lower costs after arrivals where legs to later arrivals are cheaper.

    As :func:`along`, with row ``i`` of the source the costs from the later arrival on, and row
    ``o`` of the target those from the earlier one on.
    """
    j, k, slope, least_gap = leg
    low, high, first, last = windows
    i, j, k, o = np.uint64(i), np.uint64(j), np.uint64(k), np.uint64(o)
    for g in range(np.uint64(cost.shape[2])):
        step = least_gap + np.int64(g)
        begin, end = max(low, first - step), min(high, last - step)
        ahead = np.uint64(step)
        for t in range(np.uint64(begin), np.uint64(max(begin, end))):
            found = source[i, t + ahead] + slope * np.float32(cost[j, k, g, t])
            kept = target[o, t]
            target[o, t] = found if found < kept else kept


@inlined
def launched(source, apart, low, high, first, last, target):
    """Costs of launches, from the last arrivals of the previous mission."""
    least, s = FAR, low
    for t in range(first, last):
        while s < high and s <= t - apart:
            if source[s] < least:
                least = source[s]
            s += 1
        target[t] = least


@inlined
def ended(source, apart, low, high, first, last, target):
    """Costs after the last arrivals of a mission, from those after the next launch."""
    least, s = FAR, last - 1
    for t in range(high - 1, low - 1, -1):
        while s >= first and s >= t + apart:
            if source[s] < least:
                least = source[s]
            s -= 1
        target[t] = least


@inlined
def wiped(row):
    """Mark a row as impossible everywhere."""
    for t in range(row.size):
        row[t] = FAR


@kernel
def forwards(cost, tour, grid, wide, start, size, ahead):
    """Costs up to the targets of a tour, from one of them on.

    Parameters
    ----------
    cost : (targets, targets, gaps, times) uint16
    tour : TourRows
        Windows lie about its times.
    grid : TimeGrid
    wide : int
        Half of a window.
    start, size : int
    ahead : (targets, times) float32
        Rows of its order from ``start`` to ``size`` are filled, far outside of windows.
    """
    order, begins, at, slope, _ = borrowed(tour)
    times = cost.shape[3]
    for k in range(start, size):
        first, last = max(0, at[k] - wide), min(times, at[k] + wide)
        now = ahead[order[k]]
        wiped(now)
        if k == 0:
            for t in range(first, last):
                now[t] = np.float32(0.0)
            continue
        low, high = max(0, at[k - 1] - wide), min(times, at[k - 1] + wide)
        before = ahead[order[k - 1]]
        if begins[k]:
            launched(before, grid.apart, low, high, first, last, now)
        else:
            one, other = order[k - 1], order[k]
            leg = TourLeg(one, other, slope[k], grid.least_gap)
            along(ahead, one, cost, leg, LegWindows(low, high, first, last), ahead, other)


@kernel
def backwards(cost, tour, grid, wide, start, size, behind):
    """Costs after the targets of a tour, from ``start`` back to the first (:func:`forwards`)."""
    order, begins, at, slope, _ = borrowed(tour)
    times = cost.shape[3]
    for k in range(start, -1, -1):
        low, high = max(0, at[k] - wide), min(times, at[k] + wide)
        now = behind[order[k]]
        wiped(now)
        if k == size - 1:
            for t in range(low, high):
                now[t] = np.float32(0.0)
            continue
        first, last = max(0, at[k + 1] - wide), min(times, at[k + 1] + wide)
        after = behind[order[k + 1]]
        if begins[k + 1]:
            ended(after, grid.apart, low, high, first, last, now)
        else:
            one, other = order[k], order[k + 1]
            leg = TourLeg(one, other, slope[k + 1], grid.least_gap)
            against(behind, other, cost, leg, LegWindows(low, high, first, last), behind, one)


@kernel
def settle(ahead, behind, order, at, wide, first, last):
    """Move the windows of some targets to their best times."""
    times = ahead.shape[1]
    for k in range(first, last):
        best, place = FAR, at[k]
        up, down = ahead[order[k]], behind[order[k]]
        for t in range(max(0, at[k] - wide), min(times, at[k] + wide)):
            found = up[t] + down[t]
            if found < best:
                best, place = found, t
        at[k] = place
