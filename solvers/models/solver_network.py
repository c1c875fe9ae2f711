"""Network of all connections, reduced to those a plan can use, as plain arrays.

See docs/model.md section 4.

A node is a body from a departure event on; its legs are all connections that leave from then until
the next node of the body, and one arc leads there: to wait. Times are exact. Plans are the paths
from the first node that service no target twice and keep to the ΔV. It is made of the rows of
:mod:`solvers.networks.network`, and what goes on the way belongs to no plan, or to none that the
rest has not as good a one for:

- legs beyond the budget, by the least ΔV used since refuelling at the node they leave;
- legs after which nothing of worth can come, or after which the mission cannot end;
- legs of a pair that another one *dominates*: it can be taken as late, lands no later and costs no
  more. Being there earlier and richer is never worse, since a chaser may wait.

Nodes between which nothing lands are one, and so are those between which nothing leaves. Merging
lets legs dominate one another, and dropping these lets nodes be merged; so it is done in turns.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from adr_opt.kernels.core.compile import kernel
from adr_opt.kernels.core.lists import with_stair
from adr_opt.kernels.rules.rules import Rules

from ..networks.arrays import Network as Rows

GUARD_M_S = 1e-6
"""Guard for sums of ΔV rounded in another order: an excess below it is kept. No plan within the
rules is ever lost, and an infeasible path is re-timed."""

ENOUGH = 0.98
"""Reduction is repeated while it leaves at most this share of the legs."""


class SolverNetwork(NamedTuple):
    """Nodes in order of time, the start first, with the ways between them.

    Attributes
    ----------
    body : (nodes,) int32
        Where the chaser is.
    onward : (nodes,) int32
        Node that waiting leads to: the next one of the body; −1 for none.
    first : (nodes + 1,) int64
        The legs that leave node n are ``first[n]`` to ``first[n + 1]`` − 1.
    landing : (legs,) int32
        Node at the end of the service that follows the leg.
    delta_v : (legs,) float64
        [m/s].
    """

    body: np.ndarray
    onward: np.ndarray
    first: np.ndarray
    landing: np.ndarray
    delta_v: np.ndarray

    @property
    def nodes(self) -> int:
        """Number of nodes, the start included."""
        return int(self.body.size)

    @property
    def legs(self) -> int:
        """Number of legs."""
        return int(self.landing.size)

    @property
    def tail(self) -> np.ndarray:
        """Node that a leg leaves, shape (legs,)."""
        return np.repeat(np.arange(self.nodes), np.diff(self.first))

    @property
    def origin(self) -> np.ndarray:
        """Body that a leg leaves, shape (legs,)."""
        return np.repeat(self.body, np.diff(self.first))

    @property
    def destination(self) -> np.ndarray:
        """Body that a leg reaches, shape (legs,)."""
        destinations: np.ndarray = self.body[self.landing]
        return destinations


@kernel
def _within_reach(network, is_station, budget, kept, used):
    """Least ΔV used since refuelling at every node; drops legs beyond the remaining budget."""
    used[:] = math.inf
    used[0] = 0.0
    for node in range(network.body.size):
        for leg in range(network.first[node], network.first[node + 1]):
            spent = used[node] + network.delta_v[leg]
            kept[leg] = kept[leg] and spent <= budget + GUARD_M_S
            if kept[leg]:
                landing = network.landing[leg]
                if is_station[network.body[landing]]:
                    spent = 0.0
                used[landing] = min(used[landing], spent)
        onward = network.onward[node]
        if onward >= 0:
            used[onward] = min(used[onward], used[node])


@kernel
def _of_use(network, rules, kept):
    """Drop legs after which the mission cannot end, or no worth can be collected."""
    ends = np.empty(network.body.size, np.bool_)
    worthy = np.empty(network.body.size, np.bool_)
    for node in range(network.body.size - 1, -1, -1):
        onward = network.onward[node]
        ends[node] = rules.may_end[network.body[node]] or (onward >= 0 and ends[onward])
        worthy[node] = onward >= 0 and worthy[onward]
        for leg in range(network.first[node], network.first[node + 1]):
            landing = network.landing[leg]
            j = network.body[landing]
            # Where a mission must end somewhere it is worth something to get there.
            worth = rules.prize[j] > 0.0 or (rules.returns and rules.may_end[j])
            kept[leg] = kept[leg] and ends[landing] and (worth or worthy[landing])
            ends[node] |= kept[leg]
            worthy[node] |= kept[leg]


@kernel
def _merge(network, kept, landed, place, group):
    """Groups of nodes to be merged.

    Parameters
    ----------
    landed : (nodes,) bool
        Written: whether the node is the first of those that it is one with.
    place : (nodes,) int64
        Written: the node from which something leaves that one is at, or waits for, after landing.
    group : (nodes,) int64
        Written: the first node of those that are one with it.
    """
    nodes = network.body.size
    for node in range(nodes - 1, -1, -1):
        leaves = False
        for leg in range(network.first[node], network.first[node + 1]):
            leaves = leaves or kept[leg]
        onward = network.onward[node]
        place[node] = node if leaves or onward < 0 else place[onward]
    landed[:] = False
    landed[place[0]] = True
    for node in range(nodes):
        for leg in range(network.first[node], network.first[node + 1]):
            if kept[leg]:
                landed[place[network.landing[leg]]] = True
    for node in range(nodes):
        group[node] = node
    for node in range(nodes):
        onward = network.onward[node]
        if onward >= 0 and not landed[onward]:
            group[onward] = group[node]


@kernel
def _dominated(pair, landing, delta_v, dominated):
    """Legs that another dominates.

    They are sorted: by pair, from the last node they leave to the first, by landing, by ΔV.
    """
    lands, costs = np.empty(landing.size, np.int64), np.empty(landing.size)
    size = 0
    for leg in range(landing.size):
        if leg > 0 and pair[leg] != pair[leg - 1]:
            size = 0
        # Stairs: later is cheaper. The last of those that land no later is the cheapest of them.
        at = np.searchsorted(lands[:size], landing[leg], side="right")
        dominated[leg] = at > 0 and costs[at - 1] <= delta_v[leg]
        if dominated[leg]:
            continue
        low = at - 1 if at > 0 and lands[at - 1] == landing[leg] else at
        size = with_stair(lands, costs, size, low, landing[leg], delta_v[leg])


def all_of(rows: Rows, rules: Rules) -> SolverNetwork:
    """Rows, legs and waits of a mission as a network in order of time, without reductions.

    Parameters
    ----------
    rows : solvers.networks.arrays.Network
    rules : adr_opt.kernels.rules.rules.Rules
    """
    order = np.argsort(rows.departure, kind="stable")
    # What comes before the start in time cannot be reached from it.
    order = order[int(np.flatnonzero(order == rows.roots[0])[0]) :]
    number = np.full(rows.departure.size, -1, dtype=np.int32)
    number[order] = np.arange(order.size)
    count = np.diff(rows.first)[order]
    first = np.concatenate(([0], np.cumsum(count)))
    legs = np.repeat(rows.first[:-1][order] - first[:-1], count) + np.arange(int(first[-1]))
    onward = number[np.minimum(order + 1, rows.departure.size - 1)]
    onward[np.isinf(rows.departure[order])] = -1
    bodies = np.repeat(np.arange(rules.service.size, dtype=np.int32), np.diff(rows.start))
    return SolverNetwork(
        bodies[order], onward, first, number[rows.landing[legs]], rows.delta_v[legs]
    )


def of_rows(rows: Rows, rules: Rules) -> SolverNetwork:
    """The network of a mission.

    Parameters
    ----------
    rows : solvers.networks.arrays.Network
    rules : adr_opt.kernels.rules.rules.Rules
    """
    whole = all_of(rows, rules)
    return keep(whole, np.ones(whole.legs, dtype=np.bool_), rules)


def keep(network: SolverNetwork, kept: np.ndarray, rules: Rules) -> SolverNetwork:
    """The network restricted to some legs, without those thereby made superfluous.

    Parameters
    ----------
    network : SolverNetwork
    kept : (legs,) bool
    rules : adr_opt.kernels.rules.rules.Rules
    """
    while True:
        before = network.legs
        network = _cut(network, kept, rules)
        if network.legs > ENOUGH * before or network.legs == 0:
            return network
        kept = np.ones(network.legs, dtype=np.bool_)


def _cut(network: SolverNetwork, kept: np.ndarray, rules: Rules) -> SolverNetwork:
    """Drop useless legs, merge nodes, then drop dominated legs."""
    kept = kept.copy()
    nodes = network.nodes
    _within_reach(network, rules.is_station, rules.budget, kept, np.empty(nodes))
    _of_use(network, rules, kept)
    landed, place = np.empty(nodes, dtype=np.bool_), np.empty(nodes, dtype=np.int64)
    group = np.empty(nodes, dtype=np.int64)
    _merge(network, kept, landed, place, group)
    tail = group[network.tail[kept]]
    landing, delta_v = place[network.landing[kept]], network.delta_v[kept]
    pair = network.origin[kept] * np.int64(rules.service.size) + network.destination[kept]
    order = np.lexsort((delta_v, landing, -tail, pair))
    dominated = np.empty(order.size, dtype=np.bool_)
    _dominated(pair[order], landing[order], delta_v[order], dominated)
    left = np.sort(order[~dominated])
    left = left[np.argsort(tail[left], kind="stable")]
    number = np.cumsum(landed) - 1
    tail = number[tail[left]]
    heads = np.flatnonzero(landed)
    count = np.bincount(tail, minlength=heads.size)
    return SolverNetwork(
        network.body[heads],
        _next_of_body(network.body[heads]),
        np.concatenate(([0], np.cumsum(count))).astype(np.int64),
        number[landing[left]].astype(np.int32),
        delta_v[left],
    )


def _next_of_body(body: np.ndarray) -> np.ndarray:
    """The next node of the body after each; −1 for none."""
    onward = np.full(body.size, -1, dtype=np.int32)
    order = np.argsort(body, kind="stable")
    same = body[order[1:]] == body[order[:-1]]
    onward[order[:-1][same]] = order[1:][same]
    return onward


def path_of(network: SolverNetwork, order, rules: Rules) -> list[int]:
    """Legs of an order of bodies, or of its longest beginning in the network.

    Parameters
    ----------
    network : SolverNetwork
    order : iterable of int
        Bodies.
    rules : adr_opt.kernels.rules.rules.Rules
    """
    tail, origin, destination = network.tail, network.origin, network.destination
    # Ways to be at a body: node, least ΔV used by then since refuelling, and the leg taken there.
    nodes, used = np.array([0]), np.array([0.0])
    legs, before = np.array([-1]), np.array([-1])
    stages = []
    body = rules.start
    for j in order:
        leaving = np.flatnonzero((origin == body) & (destination == j))
        way = np.searchsorted(nodes, tail[leaving], side="right") - 1
        spent = np.where(way >= 0, used[way], math.inf) + network.delta_v[leaving]
        fit = np.flatnonzero(spent <= rules.budget + GUARD_M_S)
        if fit.size == 0:
            break
        stages.append((legs, before))
        left = np.zeros(fit.size) if rules.is_station[j] else spent[fit]
        sort = np.lexsort((left, network.landing[leaving[fit]]))
        fit, left = fit[sort], left[sort]
        # Of those that land no later, the one with the least used.
        better = left < np.concatenate(([math.inf], np.minimum.accumulate(left)[:-1]))
        fit, used = fit[better], left[better]
        legs, before = leaving[fit], way[fit]
        nodes, body = network.landing[legs], j
    stages.append((legs, before))
    path = []
    at = 0
    for legs, before in reversed(stages[1:]):
        path.append(int(legs[at]))
        at = before[at]
    return path[::-1]


def bodies_along(network: SolverNetwork, chosen) -> tuple[int, ...]:
    """Bodies of the path over some legs, in order.

    Parameters
    ----------
    network : SolverNetwork
    chosen : iterable of int
        Legs, in any order.
    """
    # Legs of a path lie one after the other in time, and so are numbered.
    return tuple(int(network.body[network.landing[leg]]) for leg in sorted(chosen))
