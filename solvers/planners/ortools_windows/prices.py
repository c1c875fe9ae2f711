"""Prices on a window's limits: an upper bound on every path, and the edges that matter.

One visit per target and the content of each tank are priced into the objective
(Lagrangian relaxation); what is left is a longest path in a network without cycles. Subgradient
steps on the prices lower the bound.
"""

import math

import numpy as np

from adr_opt.kernels.core.compile import kernel
from adr_opt.kernels.core.memory import borrowed, write


@kernel
def _longest(joined, worth, price, fuel_price, best, choice):
    """Worth and first move of the best priced path onward from every node; −1 leaves the window."""
    net = joined.net
    for n in range(net.body.size - 1, -1, -1):
        fuel = fuel_price[net.tank[n]]
        best[n] = net.rest_worth[n] - fuel * net.rest_need[n]
        if net.onward[n] >= 0:
            best[n] += best[net.onward[n]]
        choice[n] = -1
        for e in range(net.head[n], net.head[n + 1]):
            m = net.tail[e]
            j = net.body[m]
            drawn = (worth.per_m_s + fuel) * net.delta_v[m]
            value = joined.prize[j] - price[j] - drawn + best[m]
            if value > best[n]:
                best[n], choice[n] = value, m


@kernel
def _demand(net, choice, used, visits):
    """Use of the best priced path: ΔV per tank, and visits per body."""
    for c in range(used.size):
        used[c] = 0.0
    for j in range(visits.size):
        visits[j] = 0.0
    n = 0
    while n >= 0:
        while choice[n] >= 0:
            m = choice[n]
            used[net.tank[n]] += net.delta_v[m]
            visits[net.body[m]] += 1.0
            n = m
        used[net.tank[n]] += net.rest_need[n]
        n = net.onward[n]


@kernel
def edge_worths(joined, worth, goal, steps):
    """Upper bounds on the worth of the paths over each edge.

    Parameters
    ----------
    joined : Joined
    worth : Worth
    goal : float
        Worth of interest: ends as soon as no path can reach it.
    steps : int
        Most subgradient steps.

    Returns
    -------
    bound : float
        No path is worth more; −inf if there is no path.
    worths : (edges,) float64
        No path over the edge is worth more. All −inf if the bound is below the goal.
    """
    joined = borrowed(joined)
    net, targets, limit = joined.net, joined.open_targets, joined.tanks
    nodes = net.body.size
    price, fuel_price = np.zeros(joined.prize.size), np.zeros(limit.size)
    best_price, best_fuel_price = price.copy(), fuel_price.copy()
    used, visits = np.empty(limit.size), np.empty(price.size)
    best, choice = np.empty(nodes), np.empty(nodes, dtype=np.int64)
    worths = np.full(net.tail.size, -math.inf)
    bound, best_constant = math.inf, 0.0
    pace, stale = 1.0, 0
    for _ in range(steps):
        _longest(joined, worth, price, fuel_price, best, choice)
        constant = 0.0
        for j in targets:
            constant += price[j]
        for c in range(limit.size):
            constant += fuel_price[c] * limit[c]
        value = best[0] + constant
        if value < bound:
            bound, best_constant, stale = value, constant, 0
            write(best_price, price)
            write(best_fuel_price, fuel_price)
        else:
            stale += 1
            if stale == 5:
                pace, stale = 0.6 * pace, 0
        if bound < goal:
            return bound, worths
        _demand(net, choice, used, visits)
        # Tanks in units of a full one, so that both kinds of price move at one pace.
        norm = 0.0
        for j in targets:
            if visits[j] > 1.0 or price[j] > 0.0:
                norm += (visits[j] - 1.0) ** 2
        for c in range(limit.size):
            if used[c] > limit[c] or fuel_price[c] > 0.0:
                norm += ((used[c] - limit[c]) / joined.full) ** 2
        if norm == 0.0:
            break
        step = pace * (value - goal) / norm
        for j in targets:
            price[j] = max(0.0, price[j] + step * (visits[j] - 1.0))
        for c in range(limit.size):
            fuel_price[c] += step * (used[c] - limit[c]) / joined.full**2
            fuel_price[c] = max(0.0, fuel_price[c])

    _longest(joined, worth, best_price, best_fuel_price, best, choice)
    _worths_over(joined, worth, best_price, best_fuel_price, best, best_constant, worths)
    return bound, worths


@kernel
def _worths_over(joined, worth, price, fuel_price, best, constant, worths):
    """Worth of the best priced path over each edge, from the best paths onward."""
    net = joined.net
    reach = np.full(net.body.size, -math.inf)
    reach[0] = 0.0
    for n in range(net.body.size):
        fuel = fuel_price[net.tank[n]]
        after = net.onward[n]
        if after >= 0:
            leaves = reach[n] + net.rest_worth[n] - fuel * net.rest_need[n]
            reach[after] = max(reach[after], leaves)
        for e in range(net.head[n], net.head[n + 1]):
            m = net.tail[e]
            j = net.body[m]
            there = reach[n] + joined.prize[j] - price[j]
            there -= (worth.per_m_s + fuel) * net.delta_v[m]
            reach[m] = max(reach[m], there)
            worths[e] = there + best[m] + constant
