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
def line_at(value, level, b, per_kg):
    """The cost as a line in the mass between two levels: intercept, and slope per kg.

    Beyond the last level a kilogram costs what it costs to launch, ``per_kg``, at least.
    """
    slope = per_kg
    if b + 1 < level.size:
        slope = (value[b + 1] - value[b]) / (level[b + 1] - level[b])
    return value[b] - slope * level[b], slope


@inlined
def launch(walks, t, i, masses, base, price):
    """Begin missions with a target at every level, with empty memory, added to a cost."""
    for b in range(masses.level.size):
        cost = base + masses.per_kg * (masses.level[b] + masses.kit) - price[i]
        if cost < walks[i, 0, b, t]:
            walks[i, 0, b, t] = cost


@inlined
def growths_of(cost, growth, t, i, j, span, grown):
    """Growth of mass by the legs of two targets from a cell, for each gap.

    Returns
    -------
    first : int
        Gap of the first leg that there is; ``span`` if there is none. Legs beyond a full tank are
        marked, and most are.
    most : float
        The largest growth of all that there are.
    """
    first = 0
    while first < span and cost[t, i, j, first] == FORBIDDEN:
        first += 1
    most = 0.0
    for g in range(first, span):
        grown[g] = growth[cost[t, i, j, g]]
        if cost[t, i, j, g] != FORBIDDEN:
            most = max(most, grown[g])
    return first, most


@inlined
def labels_onward(masks, values, count, memory_of, i, j, onward_masks, onward_values):
    """Labels of a target that may continue to another, with their memory there.

    Returns
    -------
    int
        How many there are; those that others dominate with their new memory are left out.
    """
    place, kept = memory_of.bit[i, j], 0
    for c in range(count):
        if place >= 0 and masks[c] >> place & 1:
            continue
        memory = np.int64(memory_of.carried[i, j, masks[c]])
        if is_hidden(onward_masks, onward_values, kept, memory, values[c]):
            continue
        onward_masks[kept] = memory
        for b in range(values.shape[1]):
            onward_values[kept, b] = values[c, b]
        kept += 1
    return kept


@inlined
def go_on(row, value, b, masses, price, grown, most, found):
    """Lower the costs of arriving at the next target with the mass of a level, for each gap.

    Whoever is to go on from there with that mass has left the present target with mass · growth, so
    the cost is that of the present target at this larger mass. It is concave in the mass: each line
    lies above it but where it is its own, so it is the least of all lines. None of a level below b
    can be its own, as mass only grows, and none of a level that ``most`` does not reach.

    Parameters
    ----------
    row : (gaps,)
        Costs at the next target, with the memory there and level b; lowered.
    value : (levels,)
        Costs at the present target.
    grown : (gaps,)
        Growth of mass by the leg of each gap.
    most : float
        The largest growth of a leg that there is.
    found : (gaps,)
        Scratch.
    """
    level, mass = masses.level, masses.level[b] + masses.kit
    at, per = line_at(value, level, b, masses.per_kg)
    at, per = at - price, per * mass
    for g in range(grown.size):
        found[g] = at + per * grown[g]
    k = b + 1
    while k < level.size and level[k] < mass * most:
        at, per = line_at(value, level, k, masses.per_kg)
        at, per = at - price, per * mass
        for g in range(grown.size):
            found[g] = min(found[g], at + per * grown[g])
        k += 1
    for g in range(grown.size):
        row[g] = min(row[g], found[g])


@kernel
def sweep(cost, masses, price, grid, memory_of, least):
    """Least cost of a walk, less the prices of its targets.

    Cells are done in order of time, and legs lead to later cells only: when a cell is done, all
    that arrives in it is there. Walks are in
    single precision where prices are sought, which is twice as fast, and in double where the bound
    is stated; ends of missions, which sum up over all time, are added to launches in double.

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
    walks, ended = least
    times, targets, _, gaps = cost.shape
    memories, levels = walks.shape[1:3]
    masks, values = np.empty(memories, np.int64), np.empty((memories, levels), walks.dtype)
    onward_masks, onward = np.empty(memories, np.int64), np.empty((memories, levels), walks.dtype)
    grown, found = np.empty(gaps, walks.dtype), np.empty(gaps, walks.dtype)
    for i in range(targets):
        for mask in range(memories):
            for b in range(levels):
                row = walks[i, mask, b]
                for t in range(times):
                    row[t] = FAR
    best = 0.0
    for t in range(times):
        base = np.float64(masses.fixed)
        if t >= grid.apart:
            base += ended[t - grid.apart]
        span = min(gaps, times - t - grid.least_gap)
        for i in range(targets):
            launch(walks, t, i, masses, base, price)
            count = labels_at(walks, t, i, masks, values)
            best = min(best, values[0, 0])
            for j in range(targets):
                if j == i:
                    continue
                first, most = growths_of(cost, masses.growth, t, i, j, span, grown)
                if first >= span:
                    continue
                kept = labels_onward(masks, values, count, memory_of, i, j, onward_masks, onward)
                legs, ahead = grown[first:span], t + grid.least_gap
                for c in range(kept):
                    for b in range(levels):
                        row = walks[j, onward_masks[c], b, ahead + first : ahead + span]
                        go_on(row, onward[c], b, masses, price[j], legs, most, found)
        ended[t] = best
    ended[times] = best
