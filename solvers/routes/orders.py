"""Routes of all chasers as one order, with the earliest and latest times of every stop.

An order holds for each chaser its start, its targets and its end, chaser by chaser, then the
targets that nobody visits. Of every stop one knows when it is done at the earliest, and when at the
latest it must be for all that follow to be done in time.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from adr_opt.kernels.core.compile import inlined, kernel
from adr_opt.kernels.core.memory import borrowed
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
    """Limits and worths of routes.

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
    source, destination = borrowed(source), borrowed(destination)
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
    """Largest cost of a leg between two nodes [m/s]."""
    pair = pair_of(ways, a, b)
    return ways.cost[pair] if pair >= 0 else 0.0


@kernel
def time_forth(ways, order, first, length, settled):
    """Update earliest times from a position on, until unchanged from ``settled`` on."""
    ways, order = borrowed(ways), borrowed(order)
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
    """Update latest times back from a position, until unchanged at ``settled`` or before."""
    ways, order = borrowed(ways), borrowed(order)
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
    """Count the targets of all chasers and the costs of their legs."""
    ways, order = borrowed(ways), borrowed(order)
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
