"""Reduced costs of the network: legs that a better plan can use.

With a multiplier π_j ≥ 0 on "target j at most once", every plan is worth at most

    Σ over all targets π_j + Σ over its targets (prize_j − π_j) ,

and so every plan that uses a leg is worth at most Σ π plus the best path through that leg, where a
path may service a target again. The best path up to each node and from each node come out of one
sweep forwards and one backwards, over (node, ΔV used since refuelling). Times are exact; ΔV is
counted in slots, those of a leg rounded down and so is the budget, which only adds paths. A leg
goes if what comes out is less than a better plan is worth.

Paths do not go back at once to where they come from, unless it is from a station: each state keeps
the best path and the best one of those that come from another body than it, so that whatever the
next body is, one of the two may go there (as in :mod:`solvers.walks.walks`).
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from adr_opt.kernels.core.compile import inlined, kernel
from adr_opt.kernels.rules.rules import Rules

from ..networks.layers import SLACK
from .solver_network import SolverNetwork

MOST_STATES = 10_000_000
"""Maximum number of states in a sweep; slots of ΔV are widened to keep to it."""

FINEST_SLOT_M_S = 0.5
ROUNDING = 1e-9
"""Relative guard for sums of prizes; a shortfall below it is kept."""

BITS = 16
"""Bits of a packed value for the body before, or after: ``value << BITS | body``."""

NOBODY = 2**BITS - 1
"""Mark of a path that may come from, or go to, any body."""

NEVER = -(2**61)
LARGEST = 2**40
"""Upper limit of sums of values, with NEVER far below anything added to it."""


class PathTerms(NamedTuple):
    """Costs of legs and gains of services.

    Attributes
    ----------
    cost : (legs,) int64
        [slots].
    gain : (bodies,) int64
        Packed with no body.
    top : int
        Slots of a full tank.
    """

    cost: np.ndarray
    gain: np.ndarray
    top: int


def finest_slot(network: SolverNetwork, budget: float) -> float:
    """Finest affordable slot of ΔV for a sweep over the network [m/s]."""
    return max(FINEST_SLOT_M_S, budget * network.nodes / MOST_STATES)


@inlined
def _other_than(best, second, body):
    """The better of two packed values with a body other than the given one."""
    return second if best & NOBODY == body else best


@inlined
def _put(best, second, value):
    """The best packed value, and the best with another body, updated with a third."""
    if value > best:
        return value, (second if (value ^ best) & NOBODY == 0 else best)
    if (value ^ best) & NOBODY != 0 and value > second:
        return best, value
    return best, second


@kernel
def _forwards(network, is_station, terms, best, second):
    """Most collected up to every (node, slots used), the node's own gain included."""
    cost, gain, top = terms
    best[:] = NEVER
    second[:] = NEVER
    best[0, 0] = NOBODY
    for node in range(network.body.size):
        i = network.body[node]
        label = NOBODY if is_station[i] else i
        onward = network.onward[node]
        if onward >= 0:
            for s in range(top + 1):
                one, two = _put(best[onward, s], second[onward, s], best[node, s])
                best[onward, s], second[onward, s] = _put(one, two, second[node, s])
        for leg in range(network.first[node], network.first[node + 1]):
            landing, shift = network.landing[leg], cost[leg]
            j = network.body[landing]
            if is_station[j]:
                most = NEVER
                for s in range(top + 1 - shift):
                    most = max(most, best[node, s])
                value = (most & ~NOBODY) + label
                best[landing, 0], second[landing, 0] = _put(
                    best[landing, 0], second[landing, 0], value
                )
                continue
            for s in range(top + 1 - shift):
                value = _other_than(best[node, s], second[node, s], j)
                value = (value & ~NOBODY) + gain[j] + label
                best[landing, s + shift], second[landing, s + shift] = _put(
                    best[landing, s + shift], second[landing, s + shift], value
                )


@kernel
def _backwards(network, is_station, may_end, terms, best, second, through):
    """Best path through every leg; turns ``best`` from a forward value into a backward one.

    Rows of ``best`` are read last when the node's own legs are done, so each is then overwritten
    with the most that can be collected after the node, by slots used.
    """
    cost, gain, top = terms
    ahead, instead = np.empty(top + 1, np.int64), np.empty(top + 1, np.int64)
    for node in range(network.body.size - 1, -1, -1):
        i = network.body[node]
        behind = NOBODY if is_station[i] else i
        onward = network.onward[node]
        # Stopping here leads nowhere: no leg has NOBODY as its destination.
        stop = NOBODY if may_end[i] else NEVER
        for s in range(top + 1):
            ahead[s], instead[s] = stop, NEVER
            if onward >= 0:
                ahead[s], instead[s] = _put(stop, NEVER, best[onward, s])
                ahead[s], instead[s] = _put(ahead[s], instead[s], second[onward, s])
        for leg in range(network.first[node], network.first[node + 1]):
            landing, shift = network.landing[leg], cost[leg]
            j = network.body[landing]
            most = NEVER
            for s in range(top + 1 - shift):
                left = 0 if is_station[j] else s + shift
                rest = best[landing, left]
                if behind != NOBODY:
                    rest = _other_than(rest, second[landing, left], behind)
                rest = (rest & ~NOBODY) + gain[j]
                before = _other_than(best[node, s], second[node, s], j) & ~NOBODY
                most = max(most, before + rest)
                ahead[s], instead[s] = _put(ahead[s], instead[s], rest + j)
            through[leg] = most >> BITS
        for s in range(top + 1):
            best[node, s], second[node, s] = ahead[s], instead[s]


def best_through(
    network: SolverNetwork, rules: Rules, multipliers: np.ndarray, slot: float
) -> np.ndarray:
    """Upper bound on plans that use each leg.

    Parameters
    ----------
    network : SolverNetwork
    rules : adr_opt.kernels.rules.rules.Rules
    multipliers : (bodies,) float64
        At least 0, and 0 where there is no target.
    slot : float
        Slot of ΔV [m/s].

    Returns
    -------
    (legs,) float64
        −inf where no path goes through the leg.
    """
    top = math.floor(rules.budget / slot + SLACK)
    cost = np.maximum(0, np.floor(network.delta_v / slot - SLACK)).astype(np.int64)
    cost = np.minimum(cost, top)
    worth = rules.prize - multipliers
    worth[: rules.first_target] = 0.0
    # A walk has no more legs than there are nodes. Units are a power of two: exact numbers.
    greatest = float(np.abs(worth).max(initial=0.0)) or 1.0
    unit = 2.0 ** -math.floor(math.log2(LARGEST / network.nodes / greatest))
    gain = np.ceil(worth / unit).astype(np.int64) << BITS
    best, second = (np.empty((network.nodes, top + 1), dtype=np.int64) for _ in range(2))
    most = np.empty(network.legs, dtype=np.int64)
    terms = PathTerms(cost, gain, top)
    _forwards(network, rules.is_station, terms, best, second)
    _backwards(network, rules.is_station, rules.may_end, terms, best, second, most)
    through: np.ndarray = most * unit + float(multipliers.sum())
    through[most < -LARGEST] = -math.inf
    return through


def can_reach(through: np.ndarray, goal: float) -> np.ndarray:
    """Legs that a plan above the goal may use, shape (legs,) bool.

    Parameters
    ----------
    through : (legs,) float64
        As :func:`best_through` gives it.
    goal : float
    """
    reaches: np.ndarray = through >= goal - ROUNDING * abs(goal)
    return reaches
