"""The cheapest walk through cells of time, with a price for every target: a bound on all tours.

Missions one after another are a walk through time. That every target is done exactly once is
replaced by prices π for doing it, and by ng-neighbourhoods (R. Baldacci, A. Mingozzi and
R. Roberti, Operations Research 59, 2011, 1269–1283): a walk remembers of its mission only those
targets that are neighbours of all that followed, and does none of them again. Whatever the prices,

    Σ π + least cost of a walk

is at most the expense of any tour, because each tour is a walk of no greater cost.
"""

import numpy as np

from adr_opt.kernels.compile import inlined, kernel

from .costs import FAR, FORBIDDEN


@inlined
def is_hidden(masks, values, count, mask, value):
    """Whether a label is no better than one of some others, whose values are no greater."""
    hidden = False
    for c in range(count):
        hidden = hidden or (masks[c] & ~mask == 0 and values[c] <= value)
    return hidden


@inlined
def labels_at(walks, t, i, masks, values):
    """Labels of a target in a cell that no other one hides, in order of value.

    Parameters
    ----------
    walks : (targets, memories, times)
    t, i : int
    masks, values : (memories,) int64, float
        Are filled.

    Returns
    -------
    int
        How many there are.
    """
    count = 0
    for mask in range(walks.shape[1]):
        value = walks[i, mask, t]
        if value >= FAR:
            continue
        place = count
        while place > 0 and values[place - 1] > value:
            values[place], masks[place] = values[place - 1], masks[place - 1]
            place -= 1
        values[place], masks[place] = value, mask
        count += 1
    kept = 0
    for c in range(count):
        if not is_hidden(masks, values, kept, masks[c], values[c]):
            masks[kept], values[kept] = masks[c], values[c]
            kept += 1
    return kept


@kernel
def sweep(cost, slope, fixed, kit, price, apart, least_gap, bit, carried, walks, ended):
    """The least cost of a walk, less the prices of what it does.

    Parameters
    ----------
    cost : (times, targets, targets, gaps) uint16
        At most the cost of any leg between arrivals in two cells, by the first and the gap.
    slope, fixed, kit : float
        The expense of a mission is at least ``fixed + kit targets + slope units``.
    price : (targets,)
    apart, least_gap : int
        Least cells from the last arrival of a mission to the next launch; of the first gap.
    bit : (targets, targets) int64
        [i, j] is the bit that j has in the memory of i, −1 if i does not remember j.
    carried : (targets, targets, memories) uint16
        [i, j, m] is the memory at j after memory m at i.
    walks : (targets, memories, times)
        Is filled.
    ended : (times + 1,)
        Is filled: the least cost of walks whose last arrival is no later; after the last cell the
        least of all.
    """
    times, targets, _, gaps = cost.shape
    memories = walks.shape[1]
    masks, values = np.empty(memories, np.int64), np.empty(memories, walks.dtype)
    taken, sums = np.empty(memories, np.int64), np.empty(memories, walks.dtype)
    for i in range(targets):
        for mask in range(memories):
            row = walks[i, mask]
            for t in range(times):
                row[t] = FAR
    best = walks[0, 0, 0] * 0.0
    for t in range(times):
        base = best * 0.0 + fixed + kit
        if t >= apart:
            base += ended[t - apart]
        for i in range(targets):
            launched = base - price[i]
            if launched < walks[i, 0, t]:
                walks[i, 0, t] = launched
            count = labels_at(walks, t, i, masks, values)
            best = min(best, values[0])
            span = min(gaps, times - t - least_gap)
            if span <= 0:
                continue
            for j in range(targets):
                if j == i:
                    continue
                # Legs beyond a full tank are marked, and most are.
                begin = 0
                while begin < span and cost[t, i, j, begin] == FORBIDDEN:
                    begin += 1
                if begin == span:
                    continue
                place, kept = bit[i, j], 0
                for c in range(count):
                    if place >= 0 and masks[c] >> place & 1:
                        continue
                    memory = np.int64(carried[i, j, masks[c]])
                    if is_hidden(taken, sums, kept, memory, values[c]):
                        continue
                    taken[kept], sums[kept] = memory, values[c]
                    kept += 1
                ahead, one, other, now = (
                    np.uint64(t + least_gap),
                    np.uint64(i),
                    np.uint64(j),
                    np.uint64(t),
                )
                for c in range(kept):
                    added = sums[c] + kit - price[j]
                    m = np.uint64(taken[c])
                    for g in range(np.uint64(begin), np.uint64(span)):
                        found = added + slope * cost[now, one, other, g]
                        old = walks[other, m, ahead + g]
                        walks[other, m, ahead + g] = found if found < old else old
        ended[t] = best
    ended[times] = best


@kernel
def trace(cost, slope, fixed, kit, price, apart, least_gap, bit, carried, walks, ended, done):
    """How often the cheapest walk does each target.

    Parameters
    ----------
    done : (targets,) int64
        Is filled. Other parameters are those of :func:`sweep`, which filled some.

    Returns
    -------
    spent : float
        Units of its legs.
    missions : int
    """
    times, targets, _, gaps = cost.shape
    memories = walks.shape[1]
    for i in range(targets):
        done[i] = 0
    t, units, missions = times - 1, 0.0, 0
    if ended[t] >= 0.0:
        return units, missions
    i, memory, value = -1, 0, ended[t]
    while True:
        if i < 0:
            # The end of a mission: the first cell in which so little is spent.
            while t > 0 and ended[t - 1] <= value:
                t -= 1
            least = FAR
            for target in range(targets):
                for mask in range(memories):
                    if walks[target, mask, t] < least:
                        least, i, memory = walks[target, mask, t], target, mask
            missions += 1
        done[i] += 1
        value = walks[i, memory, t]
        base = value * 0.0 + fixed + kit
        if t >= apart:
            base += ended[t - apart]
        # A launch, or the leg that comes nearest to the value.
        off, before, mask_before, gap = abs(base - price[i] - value), -1, 0, 0
        if memory != 0:
            off = FAR
        for g in range(gaps):
            s = t - least_gap - g
            if s < 0:
                break
            for j in range(targets):
                if j == i:
                    continue
                place = bit[j, i]
                step = kit - price[i] + slope * cost[s, j, i, g]
                for mask in range(memories):
                    came = walks[j, mask, s]
                    if came >= FAR or carried[j, i, mask] != memory:
                        continue
                    if place >= 0 and mask >> place & 1:
                        continue
                    if abs(came + step - value) < off:
                        off, before, mask_before, gap = abs(came + step - value), j, mask, g
        if before < 0:
            if t < apart or ended[t - apart] >= 0.0:
                return units, missions
            t -= apart
            i, value = -1, ended[t]
            continue
        units += cost[t - least_gap - gap, before, i, gap]
        i, memory, t = before, mask_before, t - least_gap - gap
