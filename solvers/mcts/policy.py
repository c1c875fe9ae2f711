"""How simulations move: uniformly at random, or guarded.

The guard. A target is *safe* if the ΔV left there still reaches the station, or if a refuelling
that begins there would end too late for one more target: then nothing is lost by being stranded.
Greedy planners without a guard strand themselves early, and so do uniform rollouts: they see
refuelling late or never.
"""

import math
from typing import NamedTuple

import numpy as np

from adr_opt.kernels import rules as rule_kernels
from adr_opt.kernels import timetable
from adr_opt.kernels.compile import kernel
from adr_opt.kernels.constants import STATION


class Policy(NamedTuple):
    """Numbers of the rollouts.

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
    last_refuelling : float
        A refuelling that ends later is of no use [s].
    """

    depth: int
    guarded: bool
    time_value: float
    temperature: float
    last_refuelling: float


class Scratch(NamedTuple):
    """Memory of one simulation.

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
    weight, delta_v, end : (bodies,) float64
        Their weights, ΔV [m/s] and ends of service [s].
    """

    sequence: np.ndarray
    path: np.ndarray
    visited: np.ndarray
    open: np.ndarray
    places: np.ndarray
    weight: np.ndarray
    delta_v: np.ndarray
    end: np.ndarray


def scratch(bodies: int) -> Scratch:
    """Fresh memory; no sequence of moves is longer than two per body."""
    return Scratch(
        np.zeros(2 * bodies, dtype=np.int64),
        np.zeros(2 * bodies + 1, dtype=np.int64),
        np.zeros(bodies, dtype=np.bool_),
        np.zeros(bodies, dtype=np.int64),
        np.zeros(bodies, dtype=np.int64),
        np.zeros(bodies),
        np.zeros(bodies),
        np.zeros(bodies),
    )


@kernel
def last_refuelling(rules):
    """The latest time at which a chaser, refuelled, can still service some target [s].

    The mission's end minus the shortest transfer and service from the station.
    """
    shortest = math.inf
    for j in range(1, rules.service.size):
        for event in range(timetable.events(rules.table, STATION, j)):
            delta_v, arrival = timetable.entry_at(rules.table, STATION, j, event)
            if delta_v <= rules.budget:
                departure = timetable.departure_at(rules.table, STATION, j, event)
                shortest = min(shortest, arrival - departure + rules.service[j])
    return rules.duration - shortest


@kernel
def is_safe(rules, policy, destination, end, left):
    """Whether a chaser that ends service at a target with some ΔV left is not stranded there."""
    _, back, refuelled = rule_kernels.fits(rules, destination, end, left, STATION)
    return back <= left or refuelled > policy.last_refuelling


@kernel
def may_refuel(rules, policy, body, time, left, since_refuel):
    """Whether refuelling is legal and of use, with its ΔV and its end."""
    if body == STATION or since_refuel == 0:
        return False, 0.0, 0.0
    legal, delta_v, end = rule_kernels.fits(rules, body, time, left, STATION)
    return legal and end <= policy.last_refuelling, delta_v, end


@kernel
def cheapest_moves(rules, policy, body, time, left, since_refuel, visited, width, moves, cost):
    """The few moves of a state worth a branch: the cheapest safe targets, and the station.

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
    count = 0
    soonest, unsafe = math.inf, -1
    for j in range(1, rules.service.size):
        if not rule_kernels.may_go(body, since_refuel, visited, j):
            continue
        legal, delta_v, end = rule_kernels.fits(rules, body, time, left, j)
        if not legal:
            continue
        price = delta_v + policy.time_value * (end - time)
        if count == width and price >= cost[0]:
            continue
        if not is_safe(rules, policy, j, end, left - delta_v):
            if end < soonest:
                soonest, unsafe = end, j
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
    if may_refuel(rules, policy, body, time, left, since_refuel)[0]:
        for k in range(count, 0, -1):
            moves[k] = moves[k - 1]
        moves[0] = STATION
        count += 1
    if count == 0 and unsafe >= 0:
        moves[0] = unsafe
        count = 1
    return count


@kernel
def _draw_uniform(rules, rng, candidates, count, visited, body, time, left, since_refuel):
    """A legal move, all equally likely: drawn without replacement until one is legal.

    Returns
    -------
    place : int
        In ``candidates``; −1 if no move is legal.
    delta_v, end : float
    """
    while count > 0:
        place = int(rng.random() * count)
        j = candidates[place]
        if rule_kernels.may_go(body, since_refuel, visited, j):
            legal, delta_v, end = rule_kernels.fits(rules, body, time, left, j)
            if legal:
                return place, delta_v, end
        count -= 1
        candidates[place], candidates[count] = candidates[count], j
    return -1, 0.0, 0.0


@kernel
def _draw_guarded(rules, policy, rng, scratch, count, body, time, left, since_refuel):
    """A safe target with weight exp(−cost / temperature), else the station, else any target.

    Targets are drawn first and guarded afterwards, with replacement of the unsafe ones by a new
    draw: the distribution is that over the safe targets, at a fraction of the look-ups. Returns
    as :func:`_draw_uniform`.
    """
    candidates, places, weight = scratch.open, scratch.places, scratch.weight
    delta_vs, ends = scratch.delta_v, scratch.end
    found, station = 0, -1
    least = math.inf
    for place in range(count):
        j = candidates[place]
        if j == STATION:
            station = place
            continue
        if not rule_kernels.may_go(body, since_refuel, scratch.visited, j):
            continue
        legal, delta_v, end = rule_kernels.fits(rules, body, time, left, j)
        if legal:
            price = delta_v + policy.time_value * (end - time)
            places[found], delta_vs[found], ends[found] = place, delta_v, end
            weight[found] = price
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
        if is_safe(rules, policy, candidates[places[k]], ends[k], left - delta_vs[k]):
            return places[k], delta_vs[k], ends[k]
        # What is unsafe goes behind the rest, where the last resort below still finds it.
        remaining -= 1
        places[k], places[remaining] = places[remaining], places[k]
        delta_vs[k], delta_vs[remaining] = delta_vs[remaining], delta_vs[k]
        ends[k], ends[remaining] = ends[remaining], ends[k]
        weight[k] = weight[remaining]
        total = np.sum(weight[:remaining])
    refuel, delta_v, end = may_refuel(rules, policy, body, time, left, since_refuel)
    if refuel:
        return station, delta_v, end
    soonest = -1
    for k in range(found):
        if soonest < 0 or ends[k] < ends[soonest]:
            soonest = k
    if soonest < 0:
        return -1, 0.0, 0.0
    return places[soonest], delta_vs[soonest], ends[soonest]


@kernel
def rollout(rules, policy, rng, scratch, moves, body, time, left, since_refuel):
    """Move at random from a state until the depth is reached or no move is left.

    Parameters
    ----------
    scratch : Scratch
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
    candidates = scratch.open
    count = 0
    for j in range(rules.service.size):
        if not scratch.visited[j]:
            candidates[count] = j
            count += 1
    collected, spent = 0.0, 0.0
    for _ in range(policy.depth):
        if policy.guarded:
            place, delta_v, end = _draw_guarded(
                rules, policy, rng, scratch, count, body, time, left, since_refuel
            )
        else:
            place, delta_v, end = _draw_uniform(
                rules, rng, candidates, count, scratch.visited, body, time, left, since_refuel
            )
        if place < 0:
            break
        body = candidates[place]
        if body == STATION:
            since_refuel = 0
        else:
            since_refuel += 1
            count -= 1
            candidates[place], candidates[count] = candidates[count], body
        left = rule_kernels.left_after(rules, left, delta_v, body)
        time = end
        collected += rules.prize[body]
        spent += delta_v
        scratch.sequence[moves] = body
        moves += 1
    return moves, collected, spent
