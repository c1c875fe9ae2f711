"""The time-expanded network: every exact state a plan can reach, as plain arrays (MODEL section 3).

A node is a leg flown: from a body, at a departure event, to a body. It fixes where the chaser is
and since when, exactly, so the moves from a node are one leg per destination: the next departure
event, as the rules have it, without waiting past an event and without any rounding of time. Plans
are the paths from the first node that service no target twice and keep to the ΔV. What is left
out belongs to no plan:

- legs that end after the mission or cost more than the budget;
- the immediate return to the target that a leg has left, and refuelling at the station;
- nodes that no path reaches on the budget, by the least ΔV used since refuelling;
- refuellings that nothing follows: they collect nothing, and every plan ends as well before them.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from adr_opt.kernels import timetable as timetables
from adr_opt.kernels.compile import kernel
from adr_opt.kernels.constants import STATION

GUARD_M_S = 1e-6
"""Guard of sums of ΔV, which may be rounded in another order: what exceeds the budget by less is
kept. A plan that fits by the rules is never lost, and a path that does not fit is re-timed."""


class Network(NamedTuple):
    """Nodes in order of time, the start first, and the moves between them.

    Attributes
    ----------
    body : (nodes,) int32
        Where the chaser is.
    origin : (nodes,) int32
        The body that the leg leaves; the station itself for the start.
    event : (nodes,) int32
        Departure event of the leg; −1 for the start.
    ready : (nodes,) float64
        Since when the chaser is free [s]; ascending.
    delta_v : (nodes,) float64
        ΔV of the leg [m/s]; 0 for the start.
    head : (nodes + 1,) int64
        The arcs that leave node n are ``head[n]`` to ``head[n + 1]`` − 1.
    successor : (arcs,) int32
        Node that an arc leads to.
    """

    body: np.ndarray
    origin: np.ndarray
    event: np.ndarray
    ready: np.ndarray
    delta_v: np.ndarray
    head: np.ndarray
    successor: np.ndarray

    @property
    def nodes(self) -> int:
        """Number of nodes, the start included."""
        return int(self.body.size)

    @property
    def arcs(self) -> int:
        """Number of arcs."""
        return int(self.successor.size)

    @property
    def tail(self) -> np.ndarray:
        """Node that an arc leaves, shape (arcs,)."""
        return np.repeat(np.arange(self.nodes), np.diff(self.head))


@kernel
def _possible_legs(rules, keys, ends):
    """Keys (origin, event, destination) and ends of service of all legs of the mission."""
    table = rules.table
    bodies = rules.service.size
    most = table.entries.shape[1]
    count = 0
    for i in range(bodies):
        for j in range(bodies):
            for m in range(timetables.events(table, i, j)):
                delta_v, arrival = timetables.entry_at(table, i, j, m)
                end = arrival + rules.service[j]
                if delta_v <= rules.budget and end <= rules.duration:
                    keys[count] = (i * most + m) * bodies + j
                    ends[count] = end
                    count += 1
    return count


@kernel
def _arcs_from(rules, origin, body, time, used, number, successor):
    """Nodes of the moves from a state, as far as the legs have numbers; returns how many."""
    table = rules.table
    bodies = rules.service.size
    most = table.entries.shape[1]
    count = 0
    for j in range(bodies):
        if j == body or (j == origin and j != STATION):
            continue
        m = timetables.next_event(table, body, j, time)
        if m >= timetables.events(table, body, j):
            continue
        node = number[(body * most + m) * bodies + j]
        if node < 0:
            continue
        if used + timetables.entry_at(table, body, j, m)[0] <= rules.budget + GUARD_M_S:
            successor[count] = node
            count += 1
    return count


@kernel
def _reach(rules, keys, ends, order, number, used):
    """Least ΔV used since refuelling at every leg in order of its end; +inf if out of reach.

    ``number`` holds the place of a leg in ``order``, plus one: place 0 is the start.
    """
    bodies = rules.service.size
    most = rules.table.entries.shape[1]
    successor = np.empty(bodies, dtype=np.int32)
    used[:] = np.inf
    used[0] = 0.0
    arcs = 0
    for place in range(order.size + 1):
        if used[place] == np.inf:
            continue
        origin, body, time = STATION, STATION, 0.0
        if place > 0:
            key = keys[order[place - 1]]
            origin, body = key // bodies // most, key % bodies
            time = ends[order[place - 1]]
        count = _arcs_from(rules, origin, body, time, used[place], number, successor)
        arcs += count
        for a in range(count):
            after = successor[a]
            key = keys[order[after - 1]]
            i, m, j = key // bodies // most, key // bodies % most, key % bodies
            spent = 0.0
            if j != STATION:
                spent = used[place] + timetables.entry_at(rules.table, i, j, m)[0]
            used[after] = min(used[after], spent)
    return arcs


@kernel
def _connect(rules, body, origin, ready, used, number, head, successor):
    """All arcs between the nodes, in order of the node they leave."""
    arcs = 0
    for node in range(body.size):
        head[node] = arcs
        arcs += _arcs_from(
            rules, origin[node], body[node], ready[node], used[node], number, successor[arcs:]
        )
    head[body.size] = arcs


def unroll(rules) -> Network:
    """The whole network of a mission.

    Parameters
    ----------
    rules : adr_opt.kernels.rules.Rules
    """
    bodies, most, _, _ = rules.table.entries.shape
    size = int(rules.table.total.sum())
    keys, ends = np.empty(size, dtype=np.int64), np.empty(size)
    count = _possible_legs(rules, keys, ends)
    keys, ends = keys[:count], ends[:count]
    order = np.argsort(ends, kind="stable")

    number = np.full(bodies * most * bodies, -1, dtype=np.int32)
    number[keys[order]] = np.arange(1, count + 1)
    used = np.empty(count + 1)
    arcs = _reach(rules, keys, ends, order, number, used)

    reached = np.flatnonzero(np.isfinite(used))
    legs = keys[order[reached[1:] - 1]]
    number[:] = -1
    number[legs] = np.arange(1, legs.size + 1)
    origin, event, body = legs // bodies // most, legs // bodies % most, legs % bodies
    body = np.concatenate(([STATION], body)).astype(np.int32)
    origin = np.concatenate(([STATION], origin)).astype(np.int32)
    event = np.concatenate(([-1], event)).astype(np.int32)
    ready = np.concatenate(([0.0], ends[order[reached[1:] - 1]]))
    delta_v = np.concatenate(([0.0], rules.table.entries[origin[1:], event[1:], body[1:], 0]))
    head = np.empty(body.size + 1, dtype=np.int64)
    # One body's worth of room beyond the last arc: every call is handed what is left.
    successor = np.empty(arcs + bodies, dtype=np.int32)
    _connect(rules, body, origin, ready, used[reached], number, head, successor)
    whole = Network(body, origin, event, ready, delta_v, head, successor[:arcs])
    return keep(whole, np.ones(arcs, dtype=np.bool_))


@kernel
def _useful(body, head, successor, kept, useful):
    """Nodes on a path of kept arcs from the start to a target; drops the other arcs."""
    useful[:] = False
    useful[0] = True
    for node in range(body.size):
        for a in range(head[node], head[node + 1]):
            if useful[node] and kept[a]:
                useful[successor[a]] = True
    for node in range(body.size - 1, -1, -1):
        goes_on = False
        for a in range(head[node], head[node + 1]):
            kept[a] = kept[a] and useful[node] and useful[successor[a]]
            goes_on = goes_on or kept[a]
        if node > 0 and body[node] == STATION and not goes_on:
            useful[node] = False


def keep(network: Network, kept: np.ndarray) -> Network:
    """The network of some of its arcs, without nodes that have become useless.

    Parameters
    ----------
    network : Network
    kept : (arcs,) bool
    """
    kept = kept.copy()
    useful = np.empty(network.nodes, dtype=np.bool_)
    _useful(network.body, network.head, network.successor, kept, useful)
    number = np.cumsum(useful) - 1
    head = np.concatenate(([0], np.cumsum(kept)))[network.head]
    head = np.append(head[:-1][useful], head[-1])
    return Network(
        network.body[useful],
        network.origin[useful],
        network.event[useful],
        network.ready[useful],
        network.delta_v[useful],
        head.astype(np.int64),
        number[network.successor[kept]].astype(np.int32),
    )


def path_of(network: Network, sequence) -> list[int]:
    """The arcs of a plan, or of its longest beginning that is in the network.

    Parameters
    ----------
    network : Network
    sequence : iterable of int
        Bodies in order.
    """
    node, arcs = 0, []
    for j in sequence:
        leaving = np.arange(network.head[node], network.head[node + 1])
        found = leaving[network.body[network.successor[leaving]] == j]
        if found.size == 0:
            break
        arcs.append(int(found[0]))
        node = int(network.successor[found[0]])
    return arcs


def bodies_along(network: Network, chosen) -> tuple[int, ...]:
    """The bodies of the path that follows some arcs from the start, in order.

    Parameters
    ----------
    network : Network
    chosen : iterable of int
        Arcs, in any order; at most one leaves each node.
    """
    tail = network.tail
    following = {int(tail[a]): int(network.successor[a]) for a in chosen}
    node, moves = 0, []
    while node in following:
        node = following[node]
        moves.append(int(network.body[node]))
    return tuple(moves)
