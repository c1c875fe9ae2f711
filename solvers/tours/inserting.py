"""Where one more target costs a tour least."""

import numpy as np

from adr_opt.kernels.core.compile import inlined, kernel

from .costs import BLOCK, FAR
from .sweeps import against, along, backwards, ended, forwards, launched, settle, wiped

BETWEEN, LAST, FIRST, ALONE = 0, 1, 2, 3
"""How a target is put in: between two of a mission, at an end of one, as a mission of its own."""

HOPE = 2
"""A place is looked at if legs about then may cost so many times what the best one costs."""

SETTLED = 16
"""So many places before and after a new target get their windows anew."""


@inlined
def least_sum(one, other, low, high):
    """Least sum of two rows in a window."""
    least = FAR
    for t in range(low, high):
        if one[t] + other[t] < least:
            least = one[t] + other[t]
    return least


@kernel
def at_place(
    cost, order, begins, slope, kit, at, size, ahead, behind, target, k, fixed, least_gap, apart,
    wide, near, into, on,
):  # fmt: skip
    """Cost of a tour with one more target before place k, and how that is put in.

    Parameters
    ----------
    kit : (targets + 1,) float64
        What one more target costs in the mission of each, besides legs.
    target, k : int
    fixed : float
        What a mission of one target costs.
    near : int
        Half of the window in which times of the target are looked for.
    into, on : (1, times) float32
        For use here.
    """
    times = cost.shape[3]
    first = at[k - 1] if k > 0 else at[0] - near
    last = at[k] if k < size else at[size - 1] + near
    first, last = max(0, min(first, last) - near), min(times, max(first, last) + near)
    alone = k == 0 or k == size or begins[k]
    best, how = FAR, -1
    wiped(on[0])
    if k < size:
        low, high = max(0, at[k] - wide), min(times, at[k] + wide)
        after, other = behind[order[k]], order[k]
        against(
            behind, other, cost, target, other, slope[k], least_gap, first, last, low, high, on, 0
        )
    if k > 0:
        low, high = max(0, at[k - 1] - wide), min(times, at[k - 1] + wide)
        before, one = ahead[order[k - 1]], order[k - 1]
        wiped(into[0])
        along(
            ahead, one, cost, one, target, slope[k - 1], least_gap, low, high, first, last, into, 0
        )
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
    found = least_sum(launch, rest, first, last) + fixed
    if found < best:
        best, how = found, ALONE
    return best, how


@inlined
def least_legs(least, order, begins, slope, at, size, target, k):
    """What the legs to and from a target at a place would cost at least, near the usual times."""
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
def put_in(order, begins, slope, kit, at, size, target, k, how, slope_alone, kit_alone):
    """Put a target into a tour before place k."""
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
        begins[k], slope[k], kit[k] = True, slope_alone, kit_alone
        if k < size:
            begins[k + 1] = True
    begins[0] = True


@kernel
def put_back(
    cost, least, order, begins, slope, kit, at, size, bag, count, ahead, behind, fixed,
    slope_alone, kit_alone, least_gap, apart, wide, near, blinks, noise, into, on,
):  # fmt: skip
    """Put targets into a tour one by one, each where it costs least.

    Parameters
    ----------
    bag : (targets,) int64
        The first ``count`` of them are put in, in that order.
    slope_alone, kit_alone : float
        Of a new mission.
    blinks : float
        Share of places that are overlooked.
    noise : float
        Costs of places are up to so much off.

    Returns
    -------
    size : int
    complete : bool
    """
    times = cost.shape[3]
    forwards(cost, order, begins, slope, at, least_gap, apart, wide, 0, size, ahead)
    backwards(cost, order, begins, slope, at, least_gap, apart, wide, size - 1, size, behind)
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
        for turn in range(-1, size + 1):
            k = promising if turn < 0 else turn
            if turn == promising:
                continue
            if turn >= 0:
                if lower[k] > HOPE * (best - base):
                    continue
                if np.random.random() < blinks:
                    continue
            found, way = at_place(
                cost, order, begins, slope, kit, at, size, ahead, behind, target, k, fixed,
                least_gap, apart, wide, near, into, on,
            )  # fmt: skip
            found += noise * np.random.random()
            if way >= 0 and found < best:
                best, place, how = found, k, way
        if place < 0 or best >= FAR:
            return size, False
        put_in(order, begins, slope, kit, at, size, target, place, how, slope_alone, kit_alone)
        at[place] = min(max(at[place], 0), times - 1)
        size += 1
        backwards(cost, order, begins, slope, at, least_gap, apart, wide, place, size, behind)
        if item + 1 == count:
            break
        forwards(cost, order, begins, slope, at, least_gap, apart, wide, place, size, ahead)
        first, last = max(0, place - SETTLED), min(size, place + SETTLED)
        settle(ahead, behind, order, at, wide, first, last)
    return size, True
