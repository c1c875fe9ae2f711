"""Which arcs a plan better than the best known one can use: reduced costs of the network.

With a multiplier π_j ≥ 0 on "target j at most once", every plan is worth at most

    Σ over all targets π_j + Σ over its targets (prize_j − π_j) ,

and so every plan that uses an arc is worth at most Σ π plus the best path through that arc, where
a path may service a target again. The best path up to each node and from each node come out of
one sweep forwards and one backwards, over (node, ΔV used since refuelling). Times are exact; ΔV
is counted in slots, those of a leg rounded down and so is the budget, which only adds paths. An
arc goes if what comes out is less than a better plan is worth. The paths know which target they
come from, so an immediate return is not among them.
"""

from __future__ import annotations

import math

import numpy as np

from adr_opt.kernels.compile import kernel
from adr_opt.kernels.constants import STATION

from .network import Network

MOST_STATES = 40_000_000
"""States of a sweep; slots of ΔV are widened until they are no more."""

FINEST_SLOT_M_S = 0.5
SLACK_SLOTS = 1e-9
ROUNDING = 1e-9
"""Relative guard of sums of prizes; what misses the goal by less is kept."""


def affordable_slot(network: Network, budget: float) -> float:
    """The finest slot of ΔV that a sweep over the network can afford [m/s]."""
    return max(FINEST_SLOT_M_S, budget * network.nodes / MOST_STATES)


@kernel
def _forwards(network, cost, gain, top, best):
    """Most collected up to every (node, slots used), the node's own gain included."""
    best[:] = -np.inf
    best[0, 0] = 0.0
    for node in range(network.body.size):
        for a in range(network.head[node], network.head[node + 1]):
            after = network.successor[a]
            if network.body[after] == STATION:
                most = -np.inf
                for s in range(top + 1 - cost[after]):
                    most = max(most, best[node, s])
                best[after, 0] = max(best[after, 0], most)
            else:
                shift, worth = cost[after], gain[network.body[after]]
                for s in range(top + 1 - shift):
                    best[after, s + shift] = max(best[after, s + shift], best[node, s] + worth)


@kernel
def _backwards(network, cost, gain, top, best, through):
    """Most of a path through every arc; turns ``best``, as forwards, into what is left to come.

    Rows of ``best`` are read last when the node's own arcs are done, so each is then overwritten
    with the most that can be collected after the node, by slots used.
    """
    rest = np.empty(top + 1)
    for node in range(network.body.size - 1, -1, -1):
        rest[:] = 0.0
        for a in range(network.head[node], network.head[node + 1]):
            after = network.successor[a]
            shift, worth = cost[after], gain[network.body[after]]
            refuelled = network.body[after] == STATION
            most = -np.inf
            for s in range(top + 1 - shift):
                ahead = worth + best[after, 0 if refuelled else s + shift]
                most = max(most, best[node, s] + ahead)
                rest[s] = max(rest[s], ahead)
            through[a] = most
        best[node] = rest


def best_through(
    network: Network, prize: np.ndarray, multipliers: np.ndarray, budget: float, slot: float
) -> np.ndarray:
    """No plan that uses an arc is worth more than this.

    Parameters
    ----------
    network : Network
    prize, multipliers : (bodies,) float64
        Multipliers are at least 0, and 0 for the station.
    budget : float
        [m/s].
    slot : float
        Slot of ΔV [m/s].

    Returns
    -------
    (arcs,) float64
    """
    top = math.floor(budget / slot + SLACK_SLOTS)
    cost = np.maximum(0, np.floor(network.delta_v / slot - SLACK_SLOTS)).astype(np.int64)
    cost = np.minimum(cost, top)
    gain = prize - multipliers
    gain[STATION] = 0.0
    through: np.ndarray = np.empty(network.arcs)
    best = np.empty((network.nodes, top + 1))
    _forwards(network, cost, gain, top, best)
    _backwards(network, cost, gain, top, best, through)
    through += multipliers.sum()
    return through


def can_reach(through: np.ndarray, goal: float) -> np.ndarray:
    """Arcs that a plan worth the goal may use, shape (arcs,) bool.

    Parameters
    ----------
    through : (arcs,) float64
        As :func:`best_through` gives it.
    goal : float
    """
    reaches: np.ndarray = through >= goal - ROUNDING * abs(goal)
    return reaches
