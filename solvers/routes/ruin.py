"""Ruin: operators that remove targets from the order of all chasers."""

from __future__ import annotations

import math

import numpy as np

from adr_opt.kernels.core.compile import kernel
from adr_opt.kernels.core.lists import rising
from adr_opt.kernels.core.memory import borrowed

from .orders import count_all
from .strings import LONGEST_STRING, mark_strings, take_out

STRINGS, ONE_STRING, AT_RANDOM = 0.6, 0.8, 0.95
"""Cumulative shares of the ruin operators; the last removes the least worthwhile targets."""


@kernel
def _mark_strings(ways, order, length, near, rng, out):
    """Mark strings of stops near a random target."""
    nodes, place = order.nodes, np.full(ways.bodies, -1)
    for p in range(length):
        if nodes[p] < ways.bodies:
            place[nodes[p]] = p
    targets = nodes.size - 2 * order.visited.size
    at = rng.integers(0, targets)
    seed = near[0, at]
    mark_strings(near, place, seed, length, rng, out)


@kernel
def ruin(ways, terms, order, length, near, full, rng):
    """Remove targets from an order; only a few strings once the order is ``full``.

    Returns
    -------
    length, first, last : int
        Stops left; positions before ``first`` are as they were, and so are those from ``last`` on,
        counted anew.
    """
    ways, terms, order = borrowed(ways), borrowed(terms), borrowed(order)
    nodes, bodies = order.nodes, ways.bodies
    out = np.zeros(length, np.bool_)
    visited = length - 2 * order.visited.size
    way = rng.random()
    if full or way < STRINGS:
        _mark_strings(ways, order, length, near, rng, out)
    elif way < ONE_STRING:
        size = min(1 + rng.integers(0, max(1, min(visited, 10 * LONGEST_STRING) // 2)), length)
        begin = rng.integers(0, length - size + 1)
        for p in range(begin, begin + size):
            out[p] = True
    elif way < AT_RANDOM:
        for _ in range(rng.integers(1, max(2, min(visited, 10 * LONGEST_STRING) // 3))):
            out[rng.integers(0, length)] = True
    else:
        keys = np.empty(length)
        for p in range(length):
            keys[p] = math.inf
            if nodes[p] < bodies:
                keys[p] = terms.prize[nodes[p]] * rng.random()
        ranks = rising(keys, length)
        for m in range(min(visited, rng.integers(1, 2 * LONGEST_STRING))):
            out[ranks[m]] = True
    for p in range(length):
        out[p] = out[p] and nodes[p] < bodies
    size, first, last = take_out(nodes, out, length)
    count_all(ways, order, size)
    return size, first, last + 1
