"""The cheapest walk over time cells, with a price for every target: a bound on all tours.

Missions one after another are a walk through time. That every target is done exactly once is
replaced by prices π for doing it, and by ng-neighbourhoods (R. Baldacci, A. Mingozzi and
R. Roberti, Operations Research 59, 2011, 1269–1283): a walk remembers of its mission only those
targets that are neighbours of all that followed, and does none of them again. Whatever the prices,

    Σ π + least cost of a walk

is at most the cost of any tour, because each tour is a walk of no greater cost.

The cost of a mission grows by a fixed rate per kilogram at launch, kits that are carried along
included. If a mass s is to be left behind a target, s + kit arrived there, and (s + kit) e^u left
the target before, u the ΔV of the leg over the exhaust speed. So the cost of a walk so far is
linear in s, and the least of many, F(s), concave: chords between a few masses, the *levels*, lie
below it, and beyond the last one it grows by no less than the launch of a kilogram. A walk ends
with the mass of an empty chaser, the first level. In the place of walks there are then mixtures of
them, whose masses are right in the mean.
"""

from typing import Any, NamedTuple

import numpy as np

from adr_opt.kernels.core.compile import inlined, kernel

from .costs import FAR, FORBIDDEN

Real = np.floating[Any] | float


class MassCosts(NamedTuple):
    """Costs of missions by mass.

    Attributes
    ----------
    growth : (65536,)
        The share by which a leg makes mass grow, at most, by its cost.
    level : (levels,)
        Masses, the first one that of an empty chaser [kg].
    per_kg, fixed : float
        A mission costs ``fixed + per_kg mass`` at least, by its mass at launch.
    kit : float
        [kg].
    """

    growth: np.ndarray
    level: np.ndarray
    per_kg: Real
    fixed: Real
    kit: Real


class Memories(NamedTuple):
    """Memory of walks.

    Attributes
    ----------
    bit : (targets, targets) int64
        [i, j] is the bit that j has in the memory of i, −1 if i does not remember j.
    carried : (targets, targets, memories) uint16
        [i, j, m] is the memory at j after memory m at i.
    """

    bit: np.ndarray
    carried: np.ndarray


class LeastWalks(NamedTuple):
    """Least costs of walks.

    Attributes
    ----------
    walks : (targets, memories, levels, times)
        Of those that arrive in a cell, by the mass that goes on from the target.
    ended : (times + 1,)
        Of those whose last arrival is no later; after the last cell the least of all.
    """

    walks: np.ndarray
    ended: np.ndarray


@inlined
def is_hidden(masks, values, count, mask, value):
    """Whether a label is dominated by one of several others at every level.

    Parameters
    ----------
    masks, values : (labels,) int64, (labels, levels)
    count : int
        Of those others.
    mask : int
    value : (levels,)
    """
    hidden = False
    for c in range(count):
        if not hidden and masks[c] & ~mask == 0:
            hidden = True
            for b in range(value.size):
                hidden = hidden and values[c, b] <= value[b]
    return hidden


@inlined
def labels_at(walks, t, i, masks, values):
    """Undominated labels of a target in a cell, in order of value at the first level.

    Parameters
    ----------
    walks : (targets, memories, levels, times)
    t, i : int
    masks, values : (memories,) int64, (memories, levels)
        Are filled.

    Returns
    -------
    int
        How many there are.
    """
    count, levels = 0, walks.shape[2]
    for mask in range(walks.shape[1]):
        value = walks[i, mask, 0, t]
        if value >= FAR:
            continue
        place = count
        while place > 0 and values[place - 1, 0] > value:
            masks[place] = masks[place - 1]
            for b in range(levels):
                values[place, b] = values[place - 1, b]
            place -= 1
        masks[place] = mask
        for b in range(levels):
            values[place, b] = walks[i, mask, b, t]
        count += 1
    kept = 0
    for c in range(count):
        if not is_hidden(masks, values, kept, masks[c], values[c]):
            masks[kept] = masks[c]
            for b in range(levels):
                values[kept, b] = values[c, b]
            kept += 1
    return kept


@inlined
def slope_of(value, level, b, per_kg):
    """Cost of a kilogram from a level on.

    Parameters
    ----------
    value, level : (levels,)
    b : int
    per_kg : float
        The least increase beyond the last one.
    """
    if b + 1 < level.size:
        return (value[b + 1] - value[b]) / (level[b + 1] - level[b])
    return per_kg


@kernel
def sweep(cost, masses, price, grid, memory_of, least):
    """Least cost of a walk, less the prices of its targets.

    Parameters
    ----------
    cost : (times, targets, targets, gaps) uint16
        At most the cost of any leg between arrivals in two cells, by the first and the gap.
    masses : MassCosts
    price : (targets,)
    grid : TimeGrid
        Of the cells.
    memory_of : Memories
    least : LeastWalks
        Is filled.
    """
    growth, level, per_kg, fixed, kit = masses
    apart, least_gap = grid.apart, grid.least_gap
    bit, carried = memory_of
    walks, ended = least
    times, targets, _, gaps = cost.shape
    memories, levels = walks.shape[1:3]
    masks, values = np.empty(memories, np.int64), np.empty((memories, levels), walks.dtype)
    taken, sums = np.empty(memories, np.int64), np.empty((memories, levels), walks.dtype)
    grown, found = np.empty(gaps, walks.dtype), np.empty(gaps, walks.dtype)
    for i in range(targets):
        for mask in range(memories):
            for b in range(levels):
                row = walks[i, mask, b]
                for t in range(times):
                    row[t] = FAR
    best = walks[0, 0, 0, 0] * 0.0
    for t in range(times):
        base = best * 0.0 + fixed
        if t >= apart:
            base += ended[t - apart]
        for i in range(targets):
            for b in range(levels):
                launched = base + per_kg * (level[b] + kit) - price[i]
                if launched < walks[i, 0, b, t]:
                    walks[i, 0, b, t] = launched
            count = labels_at(walks, t, i, masks, values)
            best = min(best, values[0, 0])
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
                most = best * 0.0
                for g in range(begin, span):
                    grown[g] = growth[cost[t, i, j, g]]
                    if cost[t, i, j, g] != FORBIDDEN:
                        most = max(most, grown[g])
                place, kept = bit[i, j], 0
                for c in range(count):
                    if place >= 0 and masks[c] >> place & 1:
                        continue
                    memory = np.int64(carried[i, j, masks[c]])
                    if is_hidden(taken, sums, kept, memory, values[c]):
                        continue
                    taken[kept] = memory
                    for b in range(levels):
                        sums[kept, b] = values[c, b]
                    kept += 1
                ahead, other = np.uint64(t + least_gap), np.uint64(j)
                for c in range(kept):
                    value, m = sums[c], np.uint64(taken[c])
                    for b in range(levels):
                        mass = level[b] + kit
                        slope = slope_of(value, level, b, per_kg)
                        at, by = value[b] - slope * level[b] - price[j], slope * mass
                        for g in range(np.uint64(begin), np.uint64(span)):
                            found[g] = at + by * grown[g]
                        k = b + 1
                        while k < levels and level[k] < mass * most:
                            slope = slope_of(value, level, k, per_kg)
                            at, by = value[k] - slope * level[k] - price[j], slope * mass
                            for g in range(np.uint64(begin), np.uint64(span)):
                                found[g] = min(found[g], at + by * grown[g])
                            k += 1
                        row = walks[other, m, b]
                        for g in range(np.uint64(begin), np.uint64(span)):
                            old = row[ahead + g]
                            row[ahead + g] = found[g] if found[g] < old else old
        ended[t] = best
    ended[times] = best


@inlined
def at_mass(walks, i, memory, t, level, mass, per_kg):
    """Cost of walks that continue from a target with a mass, and the level below it."""
    b = 0
    while b + 1 < level.size and level[b + 1] <= mass:
        b += 1
    value = walks[i, memory, b, t]
    slope = per_kg
    if b + 1 < level.size:
        slope = (walks[i, memory, b + 1, t] - value) / (level[b + 1] - level[b])
    return value + slope * (mass - level[b]), b


@kernel
def trace(cost, masses, price, grid, memory_of, least_walks, draws, done):
    """Number of visits of each target by a random walk of the cheapest mixture.

    Parameters
    ----------
    draws : (draws,) float64
        From 0 to 1, one for each target of the walk, and over again: between two levels, which one
        it goes on with.
    done : (targets,) int64
        Is filled. Other parameters are those of :func:`sweep`, which filled some.

    Returns
    -------
    mass : float
        Of its missions at launch, together [kg].
    missions : int
    """
    growth, level, per_kg, fixed, kit = masses
    apart, least_gap = grid.apart, grid.least_gap
    bit, carried = memory_of
    walks, ended = least_walks
    times, targets, _, gaps = cost.shape
    memories = walks.shape[1]
    for i in range(targets):
        done[i] = 0
    t, total, missions, drawn = times - 1, 0.0, 0, 0
    if ended[t] >= 0.0:
        return total, missions
    i, memory, b, value = -1, 0, 0, ended[t]
    while True:
        if i < 0:
            # The end of a mission: the first cell in which so little is spent.
            while t > 0 and ended[t - 1] <= value:
                t -= 1
            least, b = FAR, 0
            for target in range(targets):
                for mask in range(memories):
                    if walks[target, mask, 0, t] < least:
                        least, i, memory = walks[target, mask, 0, t], target, mask
            missions += 1
        done[i] += 1
        value = walks[i, memory, b, t]
        base = value * 0.0 + fixed + per_kg * (level[b] + kit)
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
                if j == i or cost[s, j, i, g] == FORBIDDEN:
                    continue
                place = bit[j, i]
                mass = (level[b] + kit) * growth[cost[s, j, i, g]]
                for mask in range(memories):
                    if walks[j, mask, 0, s] >= FAR or carried[j, i, mask] != memory:
                        continue
                    if place >= 0 and mask >> place & 1:
                        continue
                    came = at_mass(walks, j, mask, s, level, mass, per_kg)[0] - price[i]
                    if abs(came - value) < off:
                        off, before, mask_before, gap = abs(came - value), j, mask, g
        if before < 0:
            total += level[b] + kit
            if t < apart or ended[t - apart] >= 0.0:
                return total, missions
            t -= apart
            i, value = -1, ended[t]
            continue
        s = t - least_gap - gap
        mass = (level[b] + kit) * growth[cost[s, before, i, gap]]
        b = at_mass(walks, before, mask_before, s, level, mass, per_kg)[1]
        if b + 1 < level.size:
            share = (mass - level[b]) / (level[b + 1] - level[b])
            if draws[drawn % draws.size] < share:
                b += 1
            drawn += 1
        i, memory, t = before, mask_before, s
