"""The best plan of a small mission by enumeration: the yardstick for planners and bounds.

All sets of targets and all places to be at, with every way worth having to get there over every
connection, by the rules of `plain_rules`.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from functools import cache, lru_cache
from itertools import product
from operator import add, le

import numpy as np
from plain_rules import Counts, Leg, Numbers, State, World, begin, cost, limits, may_go, move, price
from plain_world import Pairs, legs_of, world_of

from adr_opt.common.constants import SLACK_S
from adr_opt.mission.mission import Mission
from adr_opt.mission.problem import Problem
from adr_opt.problem.instance import Instance

Vector = tuple[float, ...]
Targets = frozenset[int]
Ways = dict[Targets, dict[Vector, tuple[int, ...]]]
"""Of sets of targets, what doing them takes (cost, loss of prizes, uses of stations), and how."""


class Legs:
    """All connections from one place to another, as rows of departure, arrival and ΔV."""

    def __init__(self, rows: tuple[Vector, ...]) -> None:
        self._rows = np.array(sorted(rows)).reshape(-1, 3)
        self._since = cache(self._worth_taking)

    def since(self, ready_s: Numbers) -> tuple[Counts, Leg]:
        """For each that is ready then, by its number, the legs from then on worth taking."""
        firsts = np.searchsorted(self._rows[:, 0], ready_s - SLACK_S).tolist()
        taken = [self._since(first) for first in firsts]
        who = np.repeat(np.arange(len(taken)), [len(rows) for rows in taken])
        return who, Leg(*np.concatenate(taken).T)

    def _worth_taking(self, first: int) -> Numbers:
        """Of the later ones, each that needs less ΔV than all that arrive no later."""
        later = self._rows[first:]
        later = later[np.lexsort((later[:, 2], later[:, 1]))]
        least = np.minimum.accumulate(later[:, 2])
        return later[later[:, 2] < np.append(np.inf, least)[: len(later)]]


def worth_having(prices: Numbers) -> Counts:
    """The rows than which no other is less, or equal, in all columns; of equal ones the first."""
    left, kept = np.lexsort(prices.T[::-1]), []
    while left.size:
        kept.append(left[0])
        left = left[(prices[left] < prices[left[0]]).any(axis=1)]
    return np.array(kept, np.int64)


def joined(states: list[State]) -> State:
    """All of them in one."""
    return State(*(np.concatenate(columns) for columns in zip(*states, strict=True)))


def best_of_equals(world: World, states: State) -> State:
    """Of states at one place with equal targets and kits those that are worth having."""
    prices, alike = price(world, states), np.lexsort((states.kits, states.done))
    keys = np.column_stack((states.done, states.kits))[alike]
    ends = np.flatnonzero((keys[1:] != keys[:-1]).any(axis=1)) + 1
    return states.of(
        np.concatenate([each[worth_having(prices[each])] for each in np.split(alike, ends)])
    )


def levels(world: World, pairs: Pairs) -> Iterator[tuple[int, State]]:
    """All states worth having, place by place, each after the one that leads to it.

    A move to a target adds to those that are done, and one to a station leads away from a target.
    So, by the number of targets, states at targets come first, and then those at stations: all are
    known before one of them is gone on from. They are numbered as they come.
    """
    legs = {pair: Legs(rows) for pair, rows in pairs}
    bodies, count = range(len(world.places)), 0
    waiting: dict[tuple[int, bool, int], list[State]] = {}

    def wait(place: int, states: State) -> None:
        for targets in np.unique(states.targets).tolist():
            turn = targets, world.places[place].kind == "station", place
            waiting.setdefault(turn, []).append(states.of(states.targets == targets))

    wait(world.start, begin(world))
    while waiting:
        turn = min(waiting)
        here, states = turn[2], best_of_equals(world, joined(waiting.pop(turn)))
        yield here, states
        numbers, count = np.arange(count, count + states.done.size), count + states.done.size
        for there in bodies:
            may = np.flatnonzero(may_go(world, states, here, there))
            if may.size and (here, there) in legs:
                who, leg = legs[here, there].since(states.ready_s[may])
                going = may[who]
                wait(there, move(world, states.of(going), numbers[going], there, leg))


@lru_cache(maxsize=128)  # many tests ask of the same few missions
def ways_of(world: World, pairs: Pairs) -> Ways:
    """Ways of a chaser to do sets of targets and to end where it has to.

    A chaser that brings kits back could have left them at home.
    """
    places: list[int] = []
    before: list[int] = []
    ends: dict[int, list[tuple[Vector, int]]] = {}
    for place, states in levels(world, pairs):
        first = len(places)
        places += [place] * states.done.size
        before += states.before.tolist()
        if world.end in (None, place):
            takes = np.column_stack((cost(world, states), states.lost, states.uses)).tolist()
            for number, (done, each) in enumerate(zip(states.done.tolist(), takes, strict=True)):
                ends.setdefault(done, []).append((tuple(each), first + number))

    def sequence(number: int) -> tuple[int, ...]:
        return () if before[number] < 0 else (*sequence(before[number]), places[number])

    ways: Ways = {}
    for done, found in ends.items():
        targets = frozenset(place for place in range(len(world.places)) if done >> place & 1)
        kept = worth_having(np.array([takes for takes, _ in found])).tolist()
        ways[targets] = {found[each][0]: sequence(found[each][1]) for each in kept}
    return ways


def ways_of_mission(mission: Mission) -> Ways:
    """The same of the chaser of a mission."""
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
    instance, most = campaign.instance, limits(world_of(campaign.missions[0])).tolist()
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
        together = {}
        for done, ways in joint.items():
            taken = list(ways)
            together[done] = {taken[each]: () for each in worth_having(np.array(taken))}
    return best_of(instance, together)[:2]
