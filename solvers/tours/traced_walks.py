"""A walk of the cheapest mixture, traced back through the records of :func:`.cell_walks.sweep`."""

import numpy as np

from adr_opt.kernels.core.compile import inlined, kernel

from .cell_walks import line_at
from .costs import FAR, FORBIDDEN


@inlined
def cost_with(walks, i, memory, t, masses, mass):
    """Cost of walks that continue from a target with some mass, and the level below it."""
    level, b = masses.level, 0
    while b + 1 < level.size and level[b + 1] <= mass:
        b += 1
    at, per = line_at(walks[i, memory, :, t], level, b, masses.per_kg)
    return at + per * mass, b


@inlined
def cheapest_leg(cost, masses, grid, memory_of, walks, here, below):
    """The cheapest leg to a target, at a time, with a memory and a mass.

    Parameters
    ----------
    here : (int, int, int, float)
        Target, memory, cell, and the mass that is to arrive.
    below : float
        What it has to cost less than, without the price of the target.

    Returns
    -------
    origin, memory, t : int
        Where it leaves; origin −1 if none costs less.
    """
    i, memory, t, mass = here
    bit, carried = memory_of
    targets, gaps = cost.shape[1], cost.shape[3]
    found = -1, 0, 0
    for g in range(min(gaps, t - grid.least_gap + 1)):
        s = t - grid.least_gap - g
        for j in range(targets):
            if j == i or cost[s, j, i, g] == FORBIDDEN:
                continue
            place, left = bit[j, i], mass * masses.growth[cost[s, j, i, g]]
            for mask in range(walks.shape[1]):
                if walks[j, mask, 0, s] >= FAR or carried[j, i, mask] != memory:
                    continue
                if place >= 0 and mask >> place & 1:
                    continue
                came = cost_with(walks, j, mask, s, masses, left)[0]
                if came < below:
                    below, found = came, (j, mask, s)
    return found


@inlined
def cheapest_end(walks, t):
    """Target and memory of the cheapest walk that ends in a cell, with an empty chaser."""
    least, target, memory = walks[0, 0, 0, t], 0, 0
    for i in range(walks.shape[0]):
        for mask in range(walks.shape[1]):
            if walks[i, mask, 0, t] < least:
                least, target, memory = walks[i, mask, 0, t], i, mask
    return target, memory


@kernel
def trace(cost, masses, price, grid, memory_of, least_walks, draws, done):
    """Number of visits of each target by a random walk of the cheapest mixture.

    Backwards from the end: what :func:`.cell_walks.sweep` noted is the least of all ways to be
    there, so the cheapest way is the one that it took.

    Parameters
    ----------
    draws : (draws,) float64
        From 0 to 1, one for each target of the walk, and over again: between two levels, which one
        it goes on with.
    done : (targets,) int64
        Is filled. Other parameters are those of :func:`.cell_walks.sweep`, which filled some.

    Returns
    -------
    mass : float
        Of its missions at launch, together [kg].
    missions : int
    """
    level = masses.level
    walks, ended = least_walks
    for i in range(done.size):
        done[i] = 0
    t, total, missions, drawn = walks.shape[3] - 1, 0.0, 0, 0
    while t >= 0 and ended[t] < 0.0:
        # A mission ended in the first cell by which as little is spent.
        while t > 0 and ended[t - 1] <= ended[t]:
            t -= 1
        i, memory = cheapest_end(walks, t)
        b, flies = 0, True
        missions += 1
        while flies:
            done[i] += 1
            mass = level[b] + masses.kit
            # A mission is launched with nothing in memory; any leg is cheaper than what is far.
            launched = np.float64(FAR)
            if memory == 0:
                launched = np.float64(masses.fixed) + masses.per_kg * mass
                if t >= grid.apart:
                    launched += ended[t - grid.apart]
            here = i, memory, t, mass
            j, mask, s = cheapest_leg(cost, masses, grid, memory_of, walks, here, launched)
            flies = j >= 0
            if not flies:
                total += mass
                t -= grid.apart
                break
            # Between two levels the cost is that of a mixture: draw one of them by its share.
            mass *= masses.growth[cost[s, j, i, t - grid.least_gap - s]]
            b = cost_with(walks, j, mask, s, masses, mass)[1]
            if b + 1 < level.size:
                share = (mass - level[b]) / (level[b + 1] - level[b])
                if draws[drawn % draws.size] < share:
                    b += 1
                drawn += 1
            i, memory, t = j, mask, s
    return total, missions
