"""Cheapest insertions of a target into a tour."""

from typing import NamedTuple

import numpy as np

from adr_opt.kernels.core.compile import inlined, kernel
from adr_opt.kernels.core.memory import borrowed

from .costs import BLOCK, FAR, TimeGrid
from .sweeps import (
    LegWindows,
    TourLeg,
    against,
    along,
    backwards,
    ended,
    forwards,
    launched,
    settle,
    wiped,
)

BETWEEN, LAST, FIRST, ALONE = 0, 1, 2, 3
"""Kinds of insertion: between targets, at either end of a mission, or as a mission of its own."""

HOPE = 2
"""A position is examined if legs near that time may cost up to this multiple of the best."""

SETTLED = 16
"""Number of positions before and after a new target whose windows are updated."""


class CostRows(NamedTuple):
    """Costs of a tour over time.

    Attributes
    ----------
    ahead, behind : (targets, times) float32
        Up to each target, and from it on.
    into, on : (1, times) float32
        To work in.
    """

    ahead: np.ndarray
    behind: np.ndarray
    into: np.ndarray
    on: np.ndarray


class PuttingRules(NamedTuple):
    """Parameters of insertion.

    Attributes
    ----------
    grid : TimeGrid
    wide, near : int
        Half of the windows of the tour, and of that in which times of a target are looked for.
    fixed, slope, kit : float
        Of a mission of one target: what it costs, slope of the leg to it, and what one more target
        costs it, besides legs.
    blinks : float
        Share of places that are overlooked.
    noise : float
        Largest random error of the costs of places.
    most_missions : int
    """

    grid: TimeGrid
    wide: int
    near: int
    fixed: float
    slope: np.float32
    kit: float
    blinks: float
    noise: float
    most_missions: int


@inlined
def least_sum(one, other, low, high):
    """Least sum of two rows within a window."""
    least = FAR
    for t in range(low, high):
        if one[t] + other[t] < least:
            least = one[t] + other[t]
    return least


@kernel
def at_place(cost, tour, size, rows, target, k, rules, may_launch):
    """Cost of a tour with another target before position k, and the kind of insertion.

    Parameters
    ----------
    cost : (targets, targets, gaps, times) uint16
    tour : TourRows
    size : int
    rows : CostRows
    target, k : int
    rules : PuttingRules
    may_launch : bool
        Whether there may be another mission.
    """
    order, begins, at, slope, kit = borrowed(tour)
    ahead, behind, into, on = borrowed(rows)
    least_gap, apart, wide, near = rules.grid.least_gap, rules.grid.apart, rules.wide, rules.near
    times = cost.shape[3]
    # ``ahead`` holds the least cost of all that comes before, by the time of its last target, and
    # ``behind`` that of all that comes after. A target in between needs a time for itself alone:
    # the least sum, over its times, of the best way in and the best way on is the cost of the whole
    # tour with it, all other times chosen anew.
    first = at[k - 1] if k > 0 else at[0] - near
    last = at[k] if k < size else at[size - 1] + near
    first, last = max(0, min(first, last) - near), min(times, max(first, last) + near)
    alone = k == 0 or k == size or begins[k]
    best, how = FAR, -1
    wiped(on[0])
    if k < size:
        low, high = max(0, at[k] - wide), min(times, at[k] + wide)
        after, other = behind[order[k]], order[k]
        leg = TourLeg(target, other, slope[k], least_gap)
        against(behind, other, cost, leg, LegWindows(first, last, low, high), on, 0)
    if k > 0:
        low, high = max(0, at[k - 1] - wide), min(times, at[k - 1] + wide)
        before, one = ahead[order[k - 1]], order[k - 1]
        wiped(into[0])
        leg = TourLeg(one, target, slope[k - 1], least_gap)
        along(ahead, one, cost, leg, LegWindows(low, high, first, last), into, 0)
        if not alone:
            return least_sum(into[0], on[0], first, last) + kit[k - 1], BETWEEN
    if not alone:
        return best, how
    # First of the mission that follows.
    launch = np.empty_like(into[0])
    if k == 0:
        for t in range(first, last):
            launch[t] = np.float32(0.0)
    else:
        launched(before, apart, low, high, first, last, launch)
    if k < size:
        found = least_sum(launch, on[0], first, last) + kit[k]
        if found < best:
            best, how = found, FIRST
    # Last of the mission before, or alone.
    rest = np.empty_like(into[0])
    if k == size:
        for t in range(first, last):
            rest[t] = np.float32(0.0)
    else:
        low, high = max(0, at[k] - wide), min(times, at[k] + wide)
        ended(after, apart, first, last, low, high, rest)
    if k > 0:
        found = least_sum(into[0], rest, first, last) + kit[k - 1]
        if found < best:
            best, how = found, LAST
    found = least_sum(launch, rest, first, last) + rules.fixed
    if may_launch and found < best:
        best, how = found, ALONE
    return best, how


@inlined
def least_legs(least, order, begins, slope, at, size, target, k):
    """Lower bound on the legs to and from a target at a position, near the usual times."""
    last_block = least.shape[2] - 1
    found = np.float32(0.0)
    if k > 0:
        block = min(at[k - 1] // BLOCK, last_block)
        found += slope[k - 1] * np.float32(least[order[k - 1], target, block])
        if k == size or begins[k]:
            # At either end of a mission one leg is enough.
            if k < size:
                block = min(at[k] // BLOCK, last_block)
                other = slope[k] * np.float32(least[target, order[k], block])
                found = min(found, other)
            return found
    block = min(at[k] // BLOCK, last_block)
    return found + slope[k] * np.float32(least[target, order[k], block])


@kernel
def put_in(tour, size, target, k, how, rules):
    """Insert a target into a tour before position k."""
    order, begins, at, slope, kit = borrowed(tour)
    for place in range(size, k, -1):
        order[place], begins[place] = order[place - 1], begins[place - 1]
        slope[place], kit[place] = slope[place - 1], kit[place - 1]
        at[place] = at[place - 1]
    order[k] = target
    if k == 0:
        at[k] = max(0, at[1] - 6)
    elif k == size:
        at[k] = at[k - 1] + 6
    else:
        at[k] = (at[k - 1] + at[k + 1]) // 2
    if how in (BETWEEN, LAST):
        begins[k], slope[k], kit[k] = False, slope[k - 1], kit[k - 1]
    elif how == FIRST:
        begins[k], begins[k + 1] = True, False
        slope[k], kit[k] = slope[k + 1], kit[k + 1]
    else:
        begins[k], slope[k], kit[k] = True, rules.slope, rules.kit
        if k < size:
            begins[k + 1] = True
    begins[0] = True


@kernel
def put_back(costs, tour, size, bag, count, rows, rules):
    """Insert targets into a tour one by one, each where it costs least.

    Parameters
    ----------
    costs : TourCosts
    tour : TourRows
        Its first ``size`` targets are there.
    bag : (targets,) int64
        The first ``count`` of them are put in, in that order.
    rows : CostRows
        Written.
    rules : PuttingRules

    Returns
    -------
    size : int
    complete : bool
    """
    cost, least = borrowed(costs)
    tour, rows = borrowed(tour), borrowed(rows)
    order, begins, at, slope, _ = tour
    ahead, behind = rows.ahead, rows.behind
    grid, wide, times = rules.grid, rules.wide, cost.shape[3]
    forwards(cost, tour, grid, wide, 0, size, ahead)
    backwards(cost, tour, grid, wide, size - 1, size, behind)
    # From one target to the next these rows stay true: those behind of all places up to the new
    # one, those ahead of all places from it on, are computed anew; the others did not change, but
    # for windows of times, which are settled nearby.
    lower = np.empty(order.size, np.float32)
    for item in range(count):
        target = bag[item]
        best, place, how = FAR, -1, -1
        for k in range(size + 1):
            lower[k] = least_legs(least, order, begins, slope, at, size, target, k)
        # The most promising place first, so that the others are measured by it.
        promising = 0
        for k in range(1, size + 1):
            if lower[k] < lower[promising]:
                promising = k
        base = least_sum(ahead[order[0]], behind[order[0]], 0, times)
        may_launch = begins[:size].sum() < rules.most_missions
        for turn in range(-1, size + 1):
            k = promising if turn < 0 else turn
            if turn == promising:
                continue
            if turn >= 0:
                if lower[k] > HOPE * (best - base):
                    continue
                if np.random.random() < rules.blinks:
                    continue
            found, way = at_place(cost, tour, size, rows, target, k, rules, may_launch)
            found += rules.noise * np.random.random()
            if way >= 0 and found < best:
                best, place, how = found, k, way
        if place < 0 or best >= FAR:
            return size, False
        put_in(tour, size, target, place, how, rules)
        at[place] = min(max(at[place], 0), times - 1)
        size += 1
        backwards(cost, tour, grid, wide, place, size, behind)
        if item + 1 == count:
            break
        forwards(cost, tour, grid, wide, place, size, ahead)
        first, last = max(0, place - SETTLED), min(size, place + SETTLED)
        settle(ahead, behind, order, at, wide, first, last)
    return size, True
