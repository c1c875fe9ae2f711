"""Cheapest routes over a set of targets, exactly: dynamic programming over all orders.

Labels as of the schedule of an order, kept for each part of the set that is done and each body; of
two that have done the same, one that is ready no later, has no less left and costs no more makes
the other one superfluous, whatever orders they come by.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from typing import NamedTuple

import numpy as np

from adr_opt.kernels.rules.resources import CountLimits
from adr_opt.kernels.rules.schedule import undominated
from adr_opt.mission.mission import Mission
from adr_opt.mission.orders import NOTHING, counts_after, why_full
from adr_opt.mission.schedule import Front


class _State(NamedTuple):
    """Serviced targets, position, whether it has refuelled, stops at limited stations, and counts.

    Then ``stops`` are the refuellings at those, in order of their numbers.
    """

    done: frozenset[int]
    body: int
    refuelled: bool
    stops: tuple[int, ...]
    counts: CountLimits


class _Reached(NamedTuple):
    """Labels of a state, with their predecessors."""

    front: Front
    before: list[_State | None]


class Cheapest(NamedTuple):
    """The cheapest route with given refuellings at limited stations.

    Attributes
    ----------
    route : tuple of int
    cost : float
    stops : tuple of int
        Refuellings at stations that are counted, in order of their numbers.
    """

    route: tuple[int, ...]
    cost: float
    stops: tuple[int, ...]


def cheapest_routes(
    mission: Mission,
    targets: frozenset[int],
    over: Callable[[], bool],
    counted: frozenset[int] = frozenset(),
    *,
    every: bool = False,
) -> list[Cheapest] | None:
    """Cheapest routes that service these targets; a single one if no station is counted.

    None for more targets than the chaser may service, or has kits for.

    Parameters
    ----------
    mission : Mission
    targets : frozenset of int
    over : callable
        Asked now and then whether to give up.
    counted : frozenset of int
        Stations of which it counts how often they refuel the chaser.
    every : bool
        All routes worth having, dearer ones that are ready earlier or have more left included:
        they may take less propellant of stations.

    Returns
    -------
    routes : list of Cheapest or None
        None if it gave up.
    """
    rules, schedules = mission.rules, mission.schedules
    kits = schedules.kits_for(tuple(targets))
    room = 0 if rules.loads is None else rules.loads.full.size - 1
    if len(targets) > rules.limits.targets or kits > room:
        return []
    start = _State(frozenset(), rules.start, False, (), NOTHING)
    known: dict[_State, _Reached] = {start: _Reached(schedules.beginning(kits), [None])}
    layer = [start]
    for _ in range(len(targets)):
        after: dict[_State, list[tuple[_State, Front]]] = {}
        for state in layer:
            if over():
                return None
            for j in sorted(targets - state.done):
                _extend(mission, kits, known, state, j, counted, after)
        layer = _merged(known, after)
        stops: dict[_State, list[tuple[_State, Front]]] = {}
        for state in layer:
            for station in range(rules.stations):
                _extend(mission, kits, known, state, station, counted, stops)
        layer += _merged(known, stops)
    ends = [state for state in layer if rules.may_end[state.body]]
    if every:
        alike = {
            tuple(_backwards(known, state, label))[::-1]: state.stops
            for state in ends
            for label in range(known[state].front.ready.size)
        }
        return [_timed(mission, route, stops) for route, stops in alike.items()]
    best: dict[tuple[int, ...], tuple[float, _State, int]] = {}
    for state in ends:
        paid = schedules.paid(known[state].front)
        label = int(np.argmin(paid))
        if state.stops not in best or paid[label] < best[state.stops][0]:
            best[state.stops] = float(paid[label]), state, label
    return [
        _timed(mission, tuple(_backwards(known, state, label))[::-1], stops)
        for stops, (_, state, label) in best.items()
    ]


def _timed(mission: Mission, route: tuple[int, ...], stops: tuple[int, ...]) -> Cheapest:
    """A route with its cost."""
    return Cheapest(route, mission.time(route).cost if route else 0.0, stops)


def _extend(
    mission: Mission,
    kits: int,
    known: dict[_State, _Reached],
    state: _State,
    j: int,
    counted: frozenset[int],
    found: dict[_State, list[tuple[_State, Front]]],
) -> None:
    """Extend a state to body j."""
    stop = bool(mission.rules.is_station[j])
    if not stop and why_full(mission.rules, state.counts):
        return
    aboard = kits - mission.schedules.kits_for(tuple(state.done))
    front = mission.schedules.extended(
        known[state].front, state.body, j, aboard, refuelled=state.refuelled
    )
    if front.ready.size:
        done = state.done if stop else state.done | {j}
        stops = tuple(sorted((*state.stops, j))) if j in counted else state.stops
        counts = counts_after(mission.rules, state.counts, j)
        then = _State(done, j, state.refuelled or stop, stops, counts)
        found.setdefault(then, []).append((state, front))


def _merged(
    known: dict[_State, _Reached], found: dict[_State, list[tuple[_State, Front]]]
) -> list[_State]:
    """Merge labels by state, keeping useful ones; returns the states."""
    for state, pieces in found.items():
        fronts = [front for _, front in pieces]
        joined = Front._make(
            np.concatenate([getattr(front, name) for front in fronts]) for name in Front._fields
        )
        before = [one for one, front in pieces for _ in range(front.ready.size)]
        order, kept = undominated(joined.ready, joined.left, joined.cost, joined.ready.size)
        which = order[:kept]
        front = Front._make(part[which] if part.size else part for part in tuple(joined))
        known[state] = _Reached(front, [before[at] for at in which])
    return list(found)


def _backwards(known: dict[_State, _Reached], state: _State, label: int) -> Iterator[int]:
    """Bodies on the way to a label, the last one first."""
    while True:
        reached = known[state]
        before = reached.before[label]
        if before is None:
            return
        yield state.body
        state, label = before, int(reached.front.parent[label])
