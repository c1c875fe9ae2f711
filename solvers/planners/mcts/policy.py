"""Rollout policies: uniformly random, or guarded.

The guard is :func:`adr_opt.kernels.rules.rules.has_way_back`. Greedy planners without it strand
themselves early, and so do uniform rollouts: they see refuelling late or never.
"""

import math
from typing import NamedTuple

import numpy as np

from adr_opt.kernels.core.compile import inlined, kernel
from adr_opt.kernels.core.memory import borrowed
from adr_opt.kernels.rules import rules as rule_kernels


class RolloutSettings(NamedTuple):
    """Parameters of rollouts.

    Attributes
    ----------
    depth : int
        Most moves of a rollout.
    guarded : bool
        Guarded rollouts instead of uniform ones.
    time_value : float
        What a second is worth in the cost of a guarded move [m/s per s].
    temperature : float
        Guarded moves are drawn with weights exp(−cost / temperature) [m/s].
    """

    depth: int
    guarded: bool
    time_value: float
    temperature: float


class SimulationScratch(NamedTuple):
    """Scratch arrays of one simulation.

    Attributes
    ----------
    sequence : (moves,) int64
        Moves since the start of the mission.
    path : (moves + 1,) int64
        Nodes from the root to the leaf.
    visited : (bodies,) bool
    open : (bodies,) int64
        Bodies a rollout may still draw.
    places : (bodies,) int64
        Places in ``open`` of the moves considered.
    weight, end : (bodies,) float64
        Their weights and ends of service [s].
    """

    sequence: np.ndarray
    path: np.ndarray
    visited: np.ndarray
    open: np.ndarray
    places: np.ndarray
    weight: np.ndarray
    end: np.ndarray


def scratch(bodies: int) -> SimulationScratch:
    """New scratch arrays; a sequence has at most two moves per body."""
    return SimulationScratch(
        np.zeros(2 * bodies, dtype=np.int64),
        np.zeros(2 * bodies + 1, dtype=np.int64),
        np.zeros(bodies, dtype=np.bool_),
        np.zeros(bodies, dtype=np.int64),
        np.zeros(bodies, dtype=np.int64),
        np.zeros(bodies),
        np.zeros(bodies),
    )


@inlined
def refuelling(rules, state):
    """Station with the earliest end of a legal and useful refuelling; −1 if there is none."""
    chosen, soonest = -1, rules.duration - rules.shortest_sortie
    for s in range(rules.stations):
        if s != state.body:
            legal, _, after = rule_kernels.step(rules, state, s)
            if legal and after.resources.time <= soonest:
                chosen, soonest = s, after.resources.time
    return chosen


@inlined
def _price(policy, delta_v, state, after):
    """Cost of a move by ΔV and time [m/s]."""
    return delta_v + policy.time_value * (after.resources.time - state.resources.time)


@kernel
def cheapest_moves(rules, policy, state, visited, width, moves, cost):
    """The few moves of a state worth a branch: the cheapest safe targets, and a station.

    If there is neither, the target serviced soonest.

    Parameters
    ----------
    width : int
        Most targets.
    moves : (width + 1,) int32
        Written: the moves, the last to be tried first in the array.
    cost : (width,) float64
        Scratch: ΔV + time value · time.

    Returns
    -------
    count : int
    """
    rules, visited = borrowed(rules), borrowed(visited)
    moves, cost = borrowed(moves), borrowed(cost)
    count = 0
    soonest, unsafe = math.inf, -1
    for j in range(rules.first_target, rules.service.size):
        if not rule_kernels.may_go(rules, state, visited, j):
            continue
        legal, delta_v, after = rule_kernels.step(rules, state, j)
        if not legal:
            continue
        price = _price(policy, delta_v, state, after)
        if count == width and price >= cost[0]:
            continue
        if not rule_kernels.has_way_back(rules, after):
            if after.resources.time < soonest:
                soonest, unsafe = after.resources.time, j
            continue
        # Dearest first, so that the cheapest is taken off the end.
        place = 0
        if count < width:
            for k in range(count, 0, -1):
                moves[k], cost[k] = moves[k - 1], cost[k - 1]
            count += 1
        while place + 1 < count and cost[place + 1] > price:
            moves[place], cost[place] = moves[place + 1], cost[place + 1]
            place += 1
        moves[place], cost[place] = j, price
    station = refuelling(rules, state)
    if station >= 0:
        for k in range(count, 0, -1):
            moves[k] = moves[k - 1]
        moves[0] = station
        count += 1
    if count == 0 and unsafe >= 0:
        moves[0] = unsafe
        count = 1
    return count


@inlined
def _draw_uniform(rules, rng, candidates, count, visited, state):
    """A uniformly random legal move, drawn without replacement until one is legal.

    Returns
    -------
    place : int
        In ``candidates``; −1 if no move is legal.
    delta_v : float
        [m/s].
    after : State
    """
    while count > 0:
        place = int(rng.random() * count)
        j = candidates[place]
        if rule_kernels.may_go(rules, state, visited, j):
            legal, delta_v, after = rule_kernels.step(rules, state, j)
            if legal:
                return place, delta_v, after
        count -= 1
        candidates[place], candidates[count] = candidates[count], j
    return -1, 0.0, state


@kernel
def _draw_guarded(rules, policy, rng, scratch, count, state):
    """A safe target with weight exp(−cost / temperature), else a station, else any target.

    Targets are drawn first and guarded afterwards, with replacement of the unsafe ones by a new
    draw: the distribution is that over the safe targets, at a fraction of the look-ups. Returns
    as :func:`_draw_uniform`.
    """
    rules, scratch = borrowed(rules), borrowed(scratch)
    candidates, places, weight, ends = scratch.open, scratch.places, scratch.weight, scratch.end
    found = 0
    least = math.inf
    for place in range(count):
        j = candidates[place]
        if rules.is_station[j] or not rule_kernels.may_go(rules, state, scratch.visited, j):
            continue
        legal, delta_v, after = rule_kernels.step(rules, state, j)
        if legal:
            price = _price(policy, delta_v, state, after)
            places[found], ends[found], weight[found] = place, after.resources.time, price
            least = min(least, price)
            found += 1
    total = 0.0
    for k in range(found):
        excess = (weight[k] - least) / policy.temperature
        weight[k] = math.exp(-excess) if excess < 30.0 else 1e-13
        total += weight[k]
    remaining = found
    while remaining > 0:
        ticket = rng.random() * total
        k = 0
        while k < remaining - 1 and ticket >= weight[k]:
            ticket -= weight[k]
            k += 1
        _, delta_v, after = rule_kernels.step(rules, state, candidates[places[k]])
        if rule_kernels.has_way_back(rules, after):
            return places[k], delta_v, after
        # What is unsafe goes behind the rest, where the last resort below still finds it.
        remaining -= 1
        places[k], places[remaining] = places[remaining], places[k]
        ends[k], ends[remaining] = ends[remaining], ends[k]
        weight[k] = weight[remaining]
        total = np.sum(weight[:remaining])
    chosen = -1
    station = refuelling(rules, state)
    if station >= 0:
        for place in range(count):
            if candidates[place] == station:
                chosen = place
    else:
        soonest = math.inf
        for k in range(found):
            if ends[k] < soonest:
                chosen, soonest = places[k], ends[k]
    if chosen < 0:
        return -1, 0.0, state
    _, delta_v, after = rule_kernels.step(rules, state, candidates[chosen])
    return chosen, delta_v, after


@kernel
def rollout(rules, policy, rng, scratch, moves, state):
    """Move at random from a state until a depth is reached or no move is left.

    Parameters
    ----------
    scratch : SimulationScratch
        ``visited`` is read; ``sequence`` is continued.
    moves : int
        Moves made before.

    Returns
    -------
    moves : int
        Moves made now.
    collected : float
        Prizes of the rollout.
    spent : float
        ΔV of the rollout [m/s].
    """
    rules, scratch = borrowed(rules), borrowed(scratch)
    candidates = scratch.open
    count = 0
    for j in range(rules.service.size):
        if not scratch.visited[j]:
            candidates[count] = j
            count += 1
    collected, spent = 0.0, 0.0
    for _ in range(policy.depth):
        if policy.guarded:
            place, delta_v, after = _draw_guarded(rules, policy, rng, scratch, count, state)
        else:
            place, delta_v, after = _draw_uniform(
                rules, rng, candidates, count, scratch.visited, state
            )
        if place < 0:
            break
        body, state = candidates[place], after
        if not rules.is_station[body]:
            count -= 1
            candidates[place], candidates[count] = candidates[count], body
        collected += rule_kernels.worth_at(rules, body, state.resources.time)
        spent += delta_v
        scratch.sequence[moves] = body
        moves += 1
    return moves, collected, spent
