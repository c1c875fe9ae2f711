"""Order of the greedy planners, a starting point of many searches."""

from __future__ import annotations

import math
from collections.abc import Iterable
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from adr_opt.kernels.core.compile import kernel
from adr_opt.kernels.core.memory import borrowed, write
from adr_opt.kernels.core.windows import last_begin
from adr_opt.kernels.rules import rules as rule_kernels
from adr_opt.kernels.rules.loads import most_kits
from adr_opt.mission.mission import Mission

GUARDED_BETA = 0.0125
"""Price of time of the guarded planner: 45 m/s per hour [m/s per s]."""

WAYS = 4
"""Number of ways to choose a required target: cheapest or most urgent, guarded or not."""


class MoveCost(NamedTuple):
    """Cost of a move: α·ΔV [m/s] + β·T [s], with T from ready to the start of service."""

    alpha: float
    beta: float


def greedy_sequence(
    mission: Mission,
    beginning: Iterable[int] = (),
    *,
    alpha: float = 1.0,
    beta: float = 0.0,
    guarded: bool = True,
) -> npt.NDArray[np.int64]:
    """Visit the cheapest legal target repeatedly; refuel if there is none.

    Where targets are required, a move after which a chaser that looks at them alone no longer comes
    to all of them is not made: the chaser goes to them first.

    Parameters
    ----------
    mission : Mission
    beginning : sequence of int
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
    moves = np.array(tuple(beginning), dtype=np.int64)
    rules = mission.rules
    # What is taken along weighs: with every number of kits it is another mission.
    most = most_kits(rules.loads)
    heavy = rules.loads is not None and rules.loads.heavy
    found: list[npt.NDArray[np.int64]] = [
        _greedy(rules, mission.is_required, moves, MoveCost(alpha, beta), guarded, kits)
        for kits in range(0 if heavy else most, most + 1)
    ]
    return max(found, key=lambda sequence: float(rules.prize[sequence].sum()))


def guarded_sequence(mission: Mission) -> npt.NDArray[np.int64]:
    """The guarded greedy order, as in the planner ``greedy-guarded``."""
    return greedy_sequence(mission, beta=GUARDED_BETA * mission.instance.hurry)


@kernel
def _greedy(rules, is_required, beginning, costs, guarded, kits):
    rules = borrowed(rules)
    bodies = rules.service.size
    visited = np.zeros(bodies, dtype=np.bool_)
    ends, lefts = np.empty(beginning.size), np.empty(beginning.size)
    moves, _, state = rule_kernels.replay(
        rules, beginning, rule_kernels.beginning_with(rules, kits), visited, ends, lefts
    )
    sequence = np.empty(moves + 2 * bodies, dtype=np.int64)
    write(sequence, beginning[:moves])
    missing = _missing(is_required, visited)
    while True:
        choice = greedy_next(rules, is_required, state, visited, costs, guarded, False, False)
        if missing > 0:
            choice = _in_time(rules, is_required, state, visited, costs, choice)
        if choice < 0:
            return sequence[:moves]
        _, _, state = rule_kernels.step(rules, state, choice)
        visited[choice] = not rules.is_station[choice]
        missing -= is_required[choice]
        sequence[moves] = choice
        moves += 1


@kernel
def greedy_next(rules, is_required, state, visited, costs, guarded, required, urgent):
    """The cheapest legal target, or else a station; −1 if no move is legal.

    Parameters
    ----------
    required : bool
        Look at required targets only.
    urgent : bool
        Take the target whose window closes first instead of the cheapest.
    """
    best, best_cost = -1, math.inf
    safe, safe_cost = -1, math.inf
    for place in range(rule_kernels.looked_at(rules)):
        j = rule_kernels.destination(rules, state.body, state.resources.time, place)
        if j < rules.first_target or (required and not is_required[j]):
            continue
        if not rule_kernels.may_go(rules, state, visited, j):
            continue
        legal, delta_v, after = rule_kernels.step(rules, state, j)
        if not legal:
            continue
        taken_s = after.resources.time - rules.service[j] - state.resources.time
        cost = costs.alpha * delta_v + costs.beta * taken_s
        if urgent:
            cost = last_begin(rules.windows, j) + rules.service[j]
        if cost < best_cost:
            best, best_cost = j, cost
        if guarded and cost < safe_cost and rule_kernels.has_way_back(rules, after):
            safe, safe_cost = j, cost
    choice = safe if guarded else best
    if choice < 0:
        choice = _cheapest_station(rules, state, costs)
    return best if choice < 0 else choice


@kernel
def _next_required(rules, is_required, state, visited, costs, way):
    """The cheapest legal required target, by one of the ways to choose it."""
    return greedy_next(rules, is_required, state, visited, costs, way < 2, True, way % 2 == 1)


@kernel
def _in_time(rules, is_required, state, visited, costs, choice):
    """The first move after which the required targets can still be serviced, or else the first."""
    if choice >= 0:
        done = visited.copy()
        done[choice] = not rules.is_station[choice]
        _, _, after = rule_kernels.step(rules, state, choice)
        for way in range(WAYS):
            if _services(rules, is_required, after, done, costs, way):
                return choice
    for way in range(WAYS):
        if _services(rules, is_required, state, visited, costs, way):
            return _next_required(rules, is_required, state, visited, costs, way)
    return choice


@kernel
def _services(rules, is_required, state, visited, costs, way):
    """Whether a chaser that visits only required targets reaches all missing ones."""
    visited = visited.copy()
    missing = _missing(is_required, visited)
    while missing > 0:
        choice = _next_required(rules, is_required, state, visited, costs, way)
        if choice < 0:
            return False
        _, _, state = rule_kernels.step(rules, state, choice)
        visited[choice] = not rules.is_station[choice]
        missing -= is_required[choice]
    return True


@kernel
def _missing(is_required, visited):
    """Number of required targets not yet serviced."""
    count = 0
    for j in range(visited.size):
        count += is_required[j] and not visited[j]
    return count


@kernel
def _cheapest_station(rules, state, costs):
    """The station where a chaser refuels; −1 if it may refuel at none."""
    cheapest, least = -1, math.inf
    for s in range(rules.stations):
        if s == state.body:
            continue
        legal, delta_v, after = rule_kernels.step(rules, state, s)
        taken_s = after.resources.time - state.resources.time
        cost = costs.alpha * delta_v + costs.beta * taken_s
        if legal and cost < least:
            cheapest, least = s, cost
    return cheapest
