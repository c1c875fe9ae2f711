"""Recreate: operators that reinsert missing targets into the order of all chasers."""

from __future__ import annotations

import math

import numpy as np

from adr_opt.kernels.core.compile import kernel
from adr_opt.kernels.core.lists import rising
from adr_opt.kernels.core.memory import borrowed

from .insertion import best_position, find_gaps, insert

PASSED_OVER = 0.03
"""Probability that a position is skipped when targets are inserted in turn."""

MOST_TRIED, MOST_COMPARED = 250, 120
"""Maximum number of missing targets tried, and number compared at each insertion."""

BY_REGRET = 0.2
"""Share of the other iterations that insert by regret."""

SELDOM = 0.003
"""Share of iterations for which a target counts as missing that never was."""


@kernel
def _draw_missing(terms, order, length, absent, by_need, rng):
    """Missing targets to be tried, in the order of insertion."""
    terms, order = borrowed(terms), borrowed(order)
    missing = order.nodes.size - length
    keys, way = np.empty(missing), rng.random()
    for m in range(missing):
        j, drawn = order.nodes[length + m], rng.random()
        if way < 0.2:
            keys[m] = drawn
        elif way < 0.5:
            keys[m] = drawn - absent[j]
        elif by_need:
            keys[m] = -drawn * (absent[j] + SELDOM)
        else:
            keys[m] = -terms.prize[j] * (0.3 + drawn)
    ranks = rising(keys, missing)
    wanted = np.empty(min(missing, MOST_TRIED), np.int64)
    for m in range(wanted.size):
        wanted[m] = order.nodes[length + ranks[m]]
    return wanted


@kernel
def insert_in_turn(ways, terms, order, length, gaps, absent, deadline, by_slack, rng):  # noqa: PLR0913
    """Insert missing targets in a random order; returns the number of stops."""
    ways, terms, order = borrowed(ways), borrowed(terms), borrowed(order)
    gaps = borrowed(gaps)
    drawn = _draw_missing(terms, order, length, absent, by_slack, rng)
    find_gaps(ways, terms, order, length, by_slack, gaps)
    for j in drawn:
        position, chaser, _, _ = best_position(
            ways, terms, order, gaps, length, j, PASSED_OVER, rng
        )
        if position >= 0:
            insert(ways, order, length, j, position, chaser, deadline)
            length += 1
            find_gaps(ways, terms, order, length, by_slack, gaps)
    return length


@kernel
def insert_best(ways, terms, order, length, gaps, absent, deadline, pace, rng):  # noqa: PLR0913
    """Insert the best missing target repeatedly; returns the number of stops."""
    ways, terms, order = borrowed(ways), borrowed(terms), borrowed(order)
    gaps = borrowed(gaps)
    drawn = _draw_missing(terms, order, length, absent, False, rng)
    left = min(drawn.size, MOST_COMPARED)
    by_regret, power = rng.random() < BY_REGRET, 1.0 + rng.random()
    worth = np.empty(left)
    for m in range(left):
        worth[m] = terms.prize[drawn[m]] ** power
    while left > 0:
        find_gaps(ways, terms, order, length, False, gaps)
        best, most, where, whose, kept = -1, -math.inf, -1, -1, 0
        for m in range(left):
            j = drawn[m]
            position, chaser, delay, second = best_position(
                ways, terms, order, gaps, length, j, 0.0, rng
            )
            if position < 0:
                continue
            gain = (0.8 + 0.4 * rng.random()) * worth[m]
            gain *= (
                min(second - delay, 10.0 * pace) if by_regret else 1.0 / (max(delay, 0.0) + pace)
            )
            if gain > most:
                best, most, where, whose = kept, gain, position, chaser
            drawn[kept], worth[kept] = j, worth[m]
            kept += 1
        if best < 0:
            break
        insert(ways, order, length, drawn[best], where, whose, deadline)
        length += 1
        left = kept - 1
        drawn[best], worth[best] = drawn[left], worth[left]
    return length
