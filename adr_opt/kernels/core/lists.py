"""Growing, selecting and sorting as loops: NumPy's functions take a second each to compile."""

import numpy as np

from .compile import inlined, kernel

RUN = 16
"""Length of the runs that are sorted by insertion before merging."""

GUESSED = 12
"""Length above which :func:`first_at` interpolates: each halving would load a cache line."""


@inlined
def first_at(numbers, low, high, least):
    """First index between two, in ascending numbers, of at least a value, or ``high``.

    Guessed as if numbers were evenly spaced, then enclosed in steps that double, then halved.
    """
    if high - low > GUESSED and numbers[low] < least <= numbers[high - 1]:
        share = (least - numbers[low]) / (numbers[high - 1] - numbers[low])
        guess, step = low + np.int64(share * (high - 1 - low)), 1
        if numbers[guess] < least:
            low, place = guess + 1, guess + 1
            while place < high and numbers[place] < least:
                low, step = place + 1, 2 * step
                place = low + step
            high = min(high, place)
        else:
            high, place = guess, guess - 1
            while place >= low and numbers[place] >= least:
                high, step = place, 2 * step
                place = high - step
            low = max(low, place + 1)
    while low < high:
        middle = (low + high) // 2
        if numbers[middle] < least:
            low = middle + 1
        else:
            high = middle
    return low


@kernel
def wider(numbers, size):
    """A copy in twice the storage, of which the first ``size`` numbers are written."""
    copy = np.empty(2 * size + 16, numbers.dtype)
    for place in range(size):
        copy[place] = numbers[place]
    return copy


@kernel
def ending(numbers, first):
    """A copy of the numbers from an index on."""
    copy = np.empty(numbers.size - first, numbers.dtype)
    for place in range(copy.size):
        copy[place] = numbers[first + place]
    return copy


@kernel
def chosen(numbers, order, size):
    """A copy of the numbers at the first ``size`` indices of an order."""
    copy = np.empty(size, numbers.dtype)
    for place in range(size):
        copy[place] = numbers[order[place]]
    return copy


@kernel
def filled(size, number):
    """Small integers, all equal, shape (size,) int8."""
    copies = np.empty(size, np.int8)
    for place in range(size):
        copies[place] = number
    return copies


@inlined
def with_stair(places, costs, size, low, place, cost):
    """Insert a stair into a staircase whose later stairs are cheaper, and drop those it dominates.

    Parameters
    ----------
    places, costs : (room,)
        The first ``size`` are the stairs; updated, with room for one more.
    size, low : int
        Number of stairs, and of those that lie before the new one.
    place, cost
        The new one.

    Returns
    -------
    size : int
        Number of stairs now.
    """
    high = low
    while high < size and costs[high] >= cost:
        high += 1
    shift = 1 - (high - low)
    if shift > 0:
        for stair in range(size, low, -1):
            places[stair], costs[stair] = places[stair - 1], costs[stair - 1]
    elif shift < 0:
        for stair in range(high, size):
            places[stair + shift], costs[stair + shift] = places[stair], costs[stair]
    places[low], costs[low] = place, cost
    return size + shift


@inlined
def kept_least(keys, items, kept, key, item):
    """Insert an item into an ascending list of the least so far; returns the list's length.

    As many as there is room for are kept; of equal keys the earlier one stays before.
    """
    if kept == keys.size and not key < keys[kept - 1]:
        return kept
    kept = min(kept + 1, keys.size)
    at = kept - 1
    while at > 0 and keys[at - 1] > key:
        keys[at], items[at] = keys[at - 1], items[at - 1]
        at -= 1
    keys[at], items[at] = key, item
    return kept


@kernel
def nearest(points, body, is_asked, is_first, found):
    """Write the bodies nearest to one, the first ones before all; returns their number.

    Parameters
    ----------
    points : (bodies, axes) float64
    body : int
    is_asked, is_first : (bodies,) bool
        Which are looked at, and which stand before all others.
    found : (most,) int64
        Written.
    """
    away, kept = np.empty(found.size), 0
    for j in range(len(points)):
        if not is_asked[j]:
            continue
        total = -np.inf if is_first[j] else 0.0
        for axis in range(points.shape[1]):
            total += (points[j, axis] - points[body, axis]) ** 2
        kept = kept_least(away, found, kept, total, j)
    return kept


@kernel
def rising(numbers, size):
    """Order of the first ``size`` numbers, ascending; stable for equal ones.

    Returns
    -------
    (size,) int64
    """
    order, merged = np.empty(size, np.int64), np.empty(size, np.int64)
    for begin in range(0, size, RUN):
        for new in range(begin, min(begin + RUN, size)):
            place = new
            while place > begin and numbers[order[place - 1]] > numbers[new]:
                order[place] = order[place - 1]
                place -= 1
            order[place] = new
    run = RUN
    while run < size:
        for low in range(0, size, 2 * run):
            middle, high = min(low + run, size), min(low + 2 * run, size)
            left, right = low, middle
            for place in range(low, high):
                if left < middle and (
                    right >= high or numbers[order[left]] <= numbers[order[right]]
                ):
                    merged[place] = order[left]
                    left += 1
                else:
                    merged[place] = order[right]
                    right += 1
        order, merged = merged, order
        run *= 2
    return order


@kernel
def ranks(numbers):
    """Rank of each number among all, from 0, the same for equal ones: (size,) int32."""
    order = rising(numbers, numbers.size)
    rank = np.empty(numbers.size, np.int32)
    place = -1
    for at in range(order.size):
        if at == 0 or numbers[order[at]] > numbers[order[at - 1]]:
            place += 1
        rank[order[at]] = place
    return rank
