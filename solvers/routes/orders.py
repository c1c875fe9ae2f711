"""Routes of all chasers as one order, with the earliest and latest times of every stop.

An order holds for each chaser its start, its targets and its end, chaser by chaser, then the
targets that nobody visits. Of every stop one knows when it is done at the earliest, and when at the
latest it must be for all that follow to be done in time. Whether a target fits in between two
others, and by how much it delays them, is answered without looking at the rest (Savelsbergh, Annals
of Operations Research 4, 1985, for times that are constant).
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from adr_opt.kernels.core.compile import inlined, kernel
from adr_opt.kernels.core.windows import opening

from .ways import arrives, leaves, pair_of


class Order(NamedTuple):
    """An order and its times; see :class:`.ways.Ways` on nodes.

    Attributes
    ----------
    nodes : (targets + 2 chasers,) int64
        The stops of all chasers in order, then the targets that are missing.
    early, late : (nodes,) float64
        Earliest end of the service at each node, and the latest for all that follow [s].
    spent : (chasers,) float64
        What the legs of each cost [m/s].
    visited : (chasers,) int64
        Number of targets of each.
    """

    nodes: np.ndarray
    early: np.ndarray
    late: np.ndarray
    spent: np.ndarray
    visited: np.ndarray


class EngineTerms(NamedTuple):
    """What routes may be and what they are worth.

    Attributes
    ----------
    prize : (bodies,) float64
    budget : (chasers,) float64
        [m/s]
    most : (chasers,) int64
        Targets of each chaser at most.
    by_time : bool
        Whether the cost is the last end, else what all legs cost and the price of time.
    price : float
        Of time [m/s per s].
    """

    prize: np.ndarray
    budget: np.ndarray
    most: np.ndarray
    by_time: bool
    price: float


@kernel
def new_order(ways, nodes, chasers):
    """Storage for an order and its times."""
    return Order(
        nodes.copy(),
        np.full(ways.body.size, np.inf),
        np.full(ways.body.size, -np.inf),
        np.zeros(chasers),
        np.zeros(chasers, np.int64),
    )


@kernel
def copy_order(source, destination):
    """Copy an order and its times."""
    for p in range(source.nodes.size):
        destination.nodes[p] = source.nodes[p]
    for node in range(source.early.size):
        destination.early[node] = source.early[node]
        destination.late[node] = source.late[node]
    for c in range(source.spent.size):
        destination.spent[c] = source.spent[c]
        destination.visited[c] = source.visited[c]


@inlined
def is_start(ways, node):
    """Whether a node is the start of a chaser."""
    return node >= ways.bodies and (node - ways.bodies) % 2 == 0


@inlined
def is_end(ways, node):
    """Whether a node is the end of a chaser."""
    return node >= ways.bodies and (node - ways.bodies) % 2 == 1


@inlined
def cost_of(ways, a, b):
    """What a leg between two nodes costs at most [m/s]."""
    pair = pair_of(ways, a, b)
    return ways.cost[pair] if pair >= 0 else 0.0


@kernel
def time_forth(ways, order, first, length, settled):
    """Earliest times from a position on, to where they are as before from ``settled`` on."""
    nodes, early = order.nodes, order.early
    for p in range(first, length):
        node = nodes[p]
        end = opening(ways.windows, node)
        if not is_start(ways, node):
            end = arrives(ways, nodes[p - 1], node, early[nodes[p - 1]])
        same, early[node] = end == early[node], end
        if same and p >= settled:
            break


@kernel
def time_back(ways, order, last, settled, deadline):
    """Latest times from a position down, to where they are as before at ``settled`` or below."""
    nodes, late = order.nodes, order.late
    for p in range(last, -1, -1):
        node = nodes[p]
        latest = min(ways.closes[node], deadline)
        if not is_end(ways, node):
            latest = min(latest, leaves(ways, node, nodes[p + 1], late[nodes[p + 1]]))
        same, late[node] = latest == late[node], latest
        if same and p <= settled:
            break


@kernel
def count_all(ways, order, length):
    """Count the targets of all chasers and what their legs cost."""
    chaser = -1
    for p in range(length):
        node = order.nodes[p]
        if is_start(ways, node):
            chaser += 1
            order.spent[chaser], order.visited[chaser] = 0.0, 0
        else:
            order.spent[chaser] += cost_of(ways, order.nodes[p - 1], node)
            order.visited[chaser] += node < ways.bodies


@kernel
def is_possible(ways, order):
    """Whether all chasers end in time."""
    for end in range(ways.bodies + 1, ways.body.size, 2):
        if not order.early[end] <= order.late[end]:
            return False
    return True


@kernel
def best_position(ways, terms, order, length, j, by_slack, passed_over, rng):
    """The position at which a target delays what follows least, or leaves it most time.

    Parameters
    ----------
    ways : Ways
    terms : EngineTerms
    order : Order
    length : int
        Number of stops.
    j : int
    by_slack : bool
        Whether the time that is left counts in place of the delay.
    passed_over : float
        Probability that a position is not looked at; only if it is 0 a second one is asked for.
    rng : numpy.random.Generator

    Returns
    -------
    position, chaser : int
        −1 if it fits nowhere.
    delay, second : float
        By how much later the next stop is done, less the time that it had if that counts, and the
        same at the next best position [s].
    """
    nodes, early, late = order.nodes, order.early, order.late
    spent, count = order.spent, order.visited
    best, whose, least, second, known, chaser = -1, -1, math.inf, math.inf, math.inf, -1
    for p in range(length):
        k = nodes[p]
        if is_start(ways, k):
            chaser += 1
            continue
        if count[chaser] >= terms.most[chaser]:
            continue
        i = nodes[p - 1]
        before = late[k] if by_slack else min(early[k], late[k])
        # No way is quicker than the least of its pair: most positions need no closer look.
        onward = ways.least[j * ways.bodies + k] if k < ways.bodies else 0.0
        latest = late[k] - onward
        latest = min(latest, min(before + known - onward, ways.closes[j]))
        if not early[i] + ways.least[ways.body[i] * ways.bodies + j] <= latest:
            continue
        if passed_over > 0.0 and rng.random() < passed_over:
            continue
        end = arrives(ways, i, j, early[i])
        if not end <= latest:
            continue
        after = arrives(ways, j, k, end)
        if not after <= late[k]:
            continue
        more = cost_of(ways, i, j) + cost_of(ways, j, k) - cost_of(ways, i, k)
        if spent[chaser] + more > terms.budget[chaser]:
            continue
        delay = after - before + TIME_SPENT * (end - early[i])
        if delay < least:
            best, whose, least, second = p, chaser, delay, least
        elif delay < second:
            second = delay
        known = second if passed_over == 0.0 else least
    return best, whose, least, second


TIME_SPENT = 1e-3
"""Weight of the time that it takes to get to a target and service it, among equal delays."""


@kernel
def insert(ways, order, length, j, position, chaser, deadline):
    """Insert a missing target at a position, and time what changes."""
    nodes = order.nodes
    source = length
    while nodes[source] != j:
        source += 1
    for p in range(source, position, -1):
        nodes[p] = nodes[p - 1]
    nodes[position] = j
    i, k = nodes[position - 1], nodes[position + 1]
    order.spent[chaser] += cost_of(ways, i, j) + cost_of(ways, j, k) - cost_of(ways, i, k)
    order.visited[chaser] += 1
    time_forth(ways, order, position, length + 1, position + 1)
    time_back(ways, order, position, position - 1, deadline)
