"""Ruin and recreate of the routes of all chasers, in continuous time.

An iteration takes targets out of the order: strings near a target that is drawn (Christiaens and
Vanden Berghe, Transportation Science 54, 2020), one long string, some at random, or those of least
prize. Then it puts missing ones back as far as they fit, one after the other where they delay what
follows least, or each time the one of most prize for its delay, or of most regret. Simulated
annealing decides whether to go on with the result.

While targets are missing, an order is worth its prizes, and a little for the mean slack of its
targets. Once none is, the cost counts alone. Of the last end one accepts so much more: the deadline
is drawn first. That end says little where a chaser waits late in the mission, as what is gained
before is not seen there; so slack counts there as well.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from adr_opt.kernels.core.compile import kernel
from adr_opt.kernels.core.lists import rising
from adr_opt.kernels.core.memory import borrowed, write
from adr_opt.kernels.core.windows import opening

from .insertion import best_position, find_gaps, insert, new_gaps
from .orders import copy_order, count_all, is_possible, new_order, time_back, time_forth
from .strings import LONGEST_STRING, mark_strings, take_out

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


ONE_BY_ONE = 0.6
"""Share of the iterations that insert targets in a random order."""

PATIENCE = 0.99
"""Factor per iteration on the memory of missing targets."""

RENEWED = 20
"""Iterations after which another deadline is drawn if no order was accepted."""

MORE = 2.0
"""Multiple of the accepted delay of the end by which an order with more slack may end later."""


class Cooling(NamedTuple):
    """Weights and temperatures of a run.

    Attributes
    ----------
    iterations : int
    hot, cold : float
        First and last temperature while targets are missing [prizes].
    hot_cost, cold_cost : float
        The same once none is, in mean costs of a target.
    worth : float
        Of a second of mean slack while targets are missing [prizes per s].
    spare : float
        The same once none is, in seconds of the end.
    pace : float
        Usual time between two targets [s].
    """

    iterations: int
    hot: float
    cold: float
    hot_cost: float
    cold_cost: float
    worth: float
    spare: float
    pace: float


@kernel
def _prize(ways, terms, order, length):
    """Sum of the prizes of all stops."""
    order = borrowed(order)
    total = 0.0
    for p in range(length):
        if order.nodes[p] < ways.bodies:
            total += terms.prize[order.nodes[p]]
    return total


@kernel
def cost_of_all(ways, terms, order):
    """Cost of all routes [s or m/s], without chasers that visit no target."""
    total = 0.0
    for chaser in range(terms.budget.size):
        start = ways.bodies + 2 * chaser
        end = order.early[start + 1]
        if order.visited[chaser] and terms.by_time:
            total = max(total, end)
        elif order.visited[chaser]:
            total += order.spent[chaser] + terms.price * (end - opening(ways.windows, start))
    return total


@kernel
def _slack(ways, order, length):
    """Mean slack of all targets [s]."""
    total, count = 0.0, 0
    for p in range(length):
        node = order.nodes[p]
        if node < ways.bodies:
            total += order.late[node] - order.early[node]
            count += 1
    return total / max(count, 1)


@kernel
def _value(ways, terms, order, length, cooling, full):
    """Objective of an order, to be maximised."""
    if not full:
        slack = cooling.worth * _slack(ways, order, length)
        return _prize(ways, terms, order, length) + slack
    cost = cost_of_all(ways, terms, order)
    if not terms.by_time:
        return -cost
    time_back(ways, order, length - 1, -1, cost)
    return cooling.spare * _slack(ways, order, length) - cost


@kernel
def _remember(ways, order, length, full, absent):
    """Update the memory of missing targets; once none is missing, of removals of each target."""
    for p in range(length if full else 0, order.nodes.size):
        j = order.nodes[p]
        if j < ways.bodies:
            kept = 1.0 if full else PATIENCE
            absent[j] = kept * absent[j] + (1.0 - PATIENCE) * (p >= length)


@kernel
def anneal(ways, terms, nodes, length, near, absent, cooling, rng, halt):  # noqa: PLR0913
    """Improve an order.

    Parameters
    ----------
    ways : Ways
    terms : EngineTerms
    nodes : (targets + 2 chasers,) int64
        As of an :class:`.orders.Order`, which need not be possible. Left as the last one accepted.
    length : int
        Number of stops.
    near : (bodies, targets) int64
        Targets by how near they are to each body, itself first.
    absent : (bodies,) float64
        Share of the iterations in which each target was missing, smoothed; updated.
    cooling : Cooling
    rng : numpy.random.Generator
    halt : (1,) bool
        Once another thread sets it, the run ends.

    Returns
    -------
    best : (stops,) int64
        Of most prize, then of least cost.
    prize, cost : float
    length : int
        Of the last order accepted.
    done : int
        Iterations.
    """
    chasers = terms.budget.size
    here, there = new_order(ways, nodes, chasers), new_order(ways, nodes, chasers)
    return _anneal(ways, terms, here, there, length, near, absent, cooling, rng, halt, nodes)


@kernel
def _anneal(ways, terms, here, there, length, near, absent, cooling, rng, halt, nodes):  # noqa: PLR0913
    """Anneal in borrowed arrays; the second order is overwritten first."""
    ways, terms, near, absent = borrowed(ways), borrowed(terms), borrowed(near), borrowed(absent)
    here, there = borrowed(here), borrowed(there)
    targets, gaps = nodes.size - 2 * terms.budget.size, new_gaps(nodes.size, ways.body.size)
    # An order that is not possible loses its last targets.
    while True:
        time_back(ways, here, length - 1, -1, math.inf)
        time_forth(ways, here, 0, length, length)
        count_all(ways, here, length)
        p = length - 1
        while p >= 0 and (here.nodes[p] >= ways.bodies):
            p -= 1
        if p < 0 or (is_possible(ways, here) and _is_within(terms, here)):
            break
        late = here.nodes[p]
        for q in range(p, length - 1):
            here.nodes[q] = here.nodes[q + 1]
        length -= 1
        here.nodes[length] = late
    full = length == nodes.size
    value = _value(ways, terms, here, length, cooling, full)
    best, best_prize = here.nodes[:length].copy(), _prize(ways, terms, here, length)
    best_cost, cost = cost_of_all(ways, terms, here), 0.0
    deadline, later, since, iteration = math.inf, 0.0, RENEWED, 0
    cost, since_s = best_cost, 0.0
    if terms.by_time:
        since_s = opening(ways.windows, ways.bodies)
    copy_order(here, there)
    while iteration < cooling.iterations and not halt[0]:
        share = iteration / cooling.iterations
        since += 1
        if full and since > RENEWED:
            since = 0
            later = -cooling.hot_cost * (cooling.cold_cost / cooling.hot_cost) ** share
            later *= math.log(1.0 - rng.random()) * (best_cost - since_s) / targets
            deadline = cost + MORE * later if terms.by_time else math.inf
            time_back(ways, here, length - 1, -1, deadline)
            copy_order(here, there)
        size, first, last = ruin(ways, terms, there, length, near, full, rng)
        time_forth(ways, there, first, size, last)
        time_back(ways, there, min(last, size - 1), first - 1, deadline)
        taken, all_in, new = False, False, value
        if is_possible(ways, there):
            if full or rng.random() < ONE_BY_ONE:
                size = insert_in_turn(ways, terms, there, size, gaps, absent, deadline, full, rng)
            else:
                size = insert_best(
                    ways, terms, there, size, gaps, absent, deadline, cooling.pace, rng
                )
            all_in = size == nodes.size
            if is_possible(ways, there) and (all_in or not full):
                new = _value(ways, terms, there, size, cooling, all_in)
                if not full:
                    later = -cooling.hot * (cooling.cold / cooling.hot) ** share
                    later *= math.log(1.0 - rng.random())
                taken = (all_in and not full) or new >= value - later
        if full:
            _remember(ways, there, size, True, absent)
        if taken:
            length, value = size, new
            prize, cost = _prize(ways, terms, there, size), cost_of_all(ways, terms, there)
            if all_in:
                full, since = True, RENEWED
            copy_order(there, here)
            if prize > best_prize or (prize == best_prize and cost < best_cost):
                best, best_prize, best_cost = here.nodes[:length].copy(), prize, cost
        else:
            copy_order(here, there)
        if not full:
            _remember(ways, here, length, False, absent)
        iteration += 1
    write(nodes, here.nodes)
    return best, best_prize, best_cost, length, iteration


@kernel
def _is_within(terms, order):
    """Whether all chasers keep to their tanks and numbers of targets."""
    for c in range(terms.budget.size):
        if order.spent[c] > terms.budget[c] or order.visited[c] > terms.most[c]:
            return False
    return True
