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

from adr_opt.kernels.core.compile import kernel
from adr_opt.kernels.core.memory import borrowed, write
from adr_opt.kernels.core.windows import opening

from .insertion import new_gaps
from .orders import copy_order, count_all, is_possible, new_order, time_back, time_forth
from .recreate import insert_best, insert_in_turn
from .ruin import ruin

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
