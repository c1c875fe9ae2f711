"""The best plan of a small mission by enumeration: the yardstick for planners and bounds.

All sets of targets and all places to be at, with every way worth having to get there over every
connection, by the rules of `plain_rules`.
"""

from __future__ import annotations

import math
from bisect import bisect_left
from collections.abc import Iterable, Iterator
from functools import cache, lru_cache
from itertools import product
from operator import add, le
from typing import Any

import numpy as np
from plain_rules import (
    Leg,
    State,
    World,
    begin,
    cost,
    limits,
    may_end,
    may_go,
    move,
    price,
    sequence,
)
from plain_world import legs_of, world_of

from adr_opt.common.constants import SLACK_S
from adr_opt.mission.mission import Mission
from adr_opt.mission.problem import Problem
from adr_opt.problem.instance import Instance

Vector = tuple[float, ...]
Targets = frozenset[int]
Ways = dict[Targets, dict[Vector, tuple[int, ...]]]
"""Of sets of targets, what doing them takes (cost, loss of prizes, uses of stations), and how."""


class Legs:
    """All connections from one place to another."""

    def __init__(self, legs: Iterable[Leg]) -> None:
        self._by_departure = sorted(legs)
        self.worth_taking = cache(self._worth_taking)

    def since(self, ready_s: float) -> tuple[Leg, ...]:
        """Those that depart then or later and are worth taking."""
        return self.worth_taking(bisect_left(self._by_departure, (ready_s - SLACK_S,)))

    def _worth_taking(self, first: int) -> tuple[Leg, ...]:
        """Of the later ones, each that needs less ΔV than all that arrive no later."""
        kept: list[Leg] = []
        for leg in sorted(self._by_departure[first:], key=lambda leg: leg[1:]):
            if not kept or leg.delta_v_m_s < kept[-1].delta_v_m_s:
                kept.append(leg)
        return tuple(kept)


def worth_having(things: dict[Vector, Any]) -> dict[Vector, Any]:
    """Of things by what they take, those than which no other one takes less, or as much, of all."""
    prices, kept = np.array(sorted(things)), {}
    while prices.size:
        best = tuple(prices[0].tolist())
        kept[best] = things[best]
        prices = prices[(prices < best).any(axis=1)]
    return kept


def states(world: World, pairs: tuple[tuple[tuple[Leg, ...], ...], ...]) -> Iterator[State]:
    """All states worth having, each after the one that leads to it.

    A move to a target adds to those that are done, and one to a station leads away from a target:
    states with equal targets, place and kits are all known before one of them is gone on from.
    """
    legs = [[Legs(rows) for rows in row] for row in pairs]
    waiting: dict[tuple[int, bool], dict[Any, dict[Vector, State]]] = {}

    def wait(state: State) -> None:
        turn = len(state.done), world.places[state.place].kind == "station"
        alike = waiting.setdefault(turn, {}).setdefault((state.done, state.place, state.kits), {})
        alike.setdefault(price(world, state), state)

    for kits in range(len(world.tank.full)):
        wait(begin(world, kits))
    while waiting:
        for alike in waiting.pop(min(waiting)).values():
            for state in worth_having(alike).values():
                yield state
                for there in range(len(world.places)):
                    if may_go(world, state, there):
                        for leg in legs[state.place][there].since(state.ready_s):
                            if (after := move(world, state, there, leg)) is not None:
                                wait(after)


@lru_cache(maxsize=128)  # many tests ask of the same few missions
def ways_of(world: World, pairs: tuple[tuple[tuple[Leg, ...], ...], ...]) -> Ways:
    """Ways of a chaser to do sets of targets and to end where it has to.

    A chaser that brings kits back could have left them at home.
    """
    ways: Ways = {}
    for state in states(world, pairs):
        if may_end(world, state):
            takes = cost(world, state), state.lost, *state.uses
            ways.setdefault(state.done, {}).setdefault(takes, sequence(state))
    return {done: worth_having(known) for done, known in ways.items()}


def ways_of_mission(mission: Mission) -> Ways:
    return ways_of(world_of(mission), legs_of(mission))


def best_of(instance: Instance, ways: Ways) -> tuple[float, float, tuple[int, ...]]:
    """The most prizes of ways, their least cost, and how; −inf if none does what is required."""
    targets = dict(enumerate(instance.targets, start=instance.first_target))
    required = {number for number, target in targets.items() if target.required}
    best: tuple[float, float, tuple[int, ...]] = -math.inf, -math.inf, ()
    for done, known in ways.items():
        if required <= done:
            chosen = [targets[number] for number in done]
            most = math.fsum(t.prize_until[0][1] if t.prize_until else t.prize for t in chosen)
            for (spent, lost, *_), how in known.items():
                # Sums of losses in another order are the same losses.
                prizes = round(most - lost, 9) if lost else most
                best = max(best, (prizes, -spent, how), key=lambda way: way[:2])
    return best[0], -best[1], best[2]


def brute_force(mission: Mission) -> tuple[float, float, tuple[int, ...]]:
    """The most prizes, their least cost, and a sequence of bodies that has both.

    Prizes are −inf where no plan keeps to all rules.
    """
    return best_of(mission.instance, ways_of_mission(mission))


def brute_force_campaign(campaign: Problem) -> tuple[float, float]:
    """The most prizes that all chasers together collect, and the least cost of that.

    Every partition of every set of targets among them. Prizes are −inf where no plan keeps to all
    rules.
    """
    instance, most = campaign.instance, limits(world_of(campaign.missions[0]))
    together: Ways = {frozenset(): {(0.0,) * (2 + len(most)): ()}}
    for mission in campaign.missions:
        joint: Ways = {}
        for (done, ways), (more, others) in product(
            together.items(), ways_of_mission(mission).items()
        ):
            for one, other in product(ways, others) if not done & more else ():
                spent, lost, *uses = map(add, one, other)
                if instance.objective.cost == "duration":
                    spent = max(one[0], other[0])
                if all(map(le, uses, most)):
                    joint.setdefault(done | more, {})[spent, lost, *uses] = ()
        together = {done: worth_having(ways) for done, ways in joint.items()}
    return best_of(instance, together)[:2]
