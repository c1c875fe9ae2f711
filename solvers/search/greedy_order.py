"""The order of the greedy planners, which many a search begins from."""

from __future__ import annotations

import math

import numpy as np

from adr_opt.kernels import rules as rule_kernels
from adr_opt.kernels.compile import kernel
from adr_opt.kernels.memory import write


@kernel
def greedy_sequence(rules, beginning, alpha, beta, guarded):
    """Visit the cheapest legal target again and again; refuel when there is none.

    Parameters
    ----------
    rules : Rules
    beginning : (moves,) int64
        Moves to make before; cut where one is not legal.
    alpha, beta : float
        Cost of a move: α·ΔV [m/s] + β·T [s], T from ready to the beginning of service.
    guarded : bool
        Take a target only if the chaser can still refuel after it, or need not any more. Where
        neither a guarded target nor refuelling is legal, an unguarded target can only add to the
        mission.

    Returns
    -------
    sequence : (moves,) int64
    """
    rules = rule_kernels.lent(rules)
    bodies = rules.service.size
    visited = np.zeros(bodies, dtype=np.bool_)
    ends, lefts = np.empty(beginning.size), np.empty(beginning.size)
    moves, _, state = rule_kernels.replay(
        rules, beginning, rule_kernels.beginning(rules), visited, ends, lefts
    )
    sequence = np.empty(moves + 2 * bodies, dtype=np.int64)
    write(sequence, beginning[:moves])
    while True:
        best, best_cost = -1, math.inf
        safe, safe_cost = -1, math.inf
        for j in range(rules.first_target, bodies):
            if not rule_kernels.may_go(rules, state, visited, j):
                continue
            legal, delta_v, after = rule_kernels.step(rules, state, j)
            if not legal:
                continue
            cost = alpha * delta_v + beta * (after.time - rules.service[j] - state.time)
            if cost < best_cost:
                best, best_cost = j, cost
            if guarded and cost < safe_cost and rule_kernels.has_way_back(rules, after):
                safe, safe_cost = j, cost
        choice = safe if guarded else best
        if choice < 0:
            choice = _cheapest_station(rules, state, alpha, beta)
        if choice < 0:
            choice = best
        if choice < 0:
            return sequence[:moves]
        _, _, state = rule_kernels.step(rules, state, choice)
        visited[choice] = not rules.is_station[choice]
        sequence[moves] = choice
        moves += 1


@kernel
def _cheapest_station(rules, state, alpha, beta):
    """The station where a chaser refuels; −1 if it may refuel at none."""
    cheapest, least = -1, math.inf
    for s in range(rules.stations):
        if s == state.body:
            continue
        legal, delta_v, after = rule_kernels.step(rules, state, s)
        cost = alpha * delta_v + beta * (after.time - state.time)
        if legal and cost < least:
            cheapest, least = s, cost
    return cheapest
