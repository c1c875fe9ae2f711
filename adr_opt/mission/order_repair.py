"""Repair of visiting orders made elsewhere or with other costs.

Solvers for static matrices promise more than the mission keeps. :func:`as_it_is` says how much of
an order is legal when it is timed exactly, and :func:`mended` what can be saved of it by refuelling
where it must and leaving out what it cannot reach.
"""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any, TypeVar

import numpy as np

from ..kernels.rules import rules as rule_kernels
from ..kernels.rules.rules import State
from .mission import Mission

Body = TypeVar("Body", int, str)
"""A body by number or by name."""


def as_it_is(mission: Mission, order: Iterable[Body]) -> tuple[Body, ...]:
    """The longest legal prefix of an order.

    Parameters
    ----------
    mission : Mission
    order : iterable of int or str
        Bodies in order, the station for refuelling; by number or name, and returned in the same
        form.
    """
    moves = tuple(order)
    return moves[: mission.time(moves).made]


def mended(mission: Mission, order: Iterable[Body]) -> tuple[Body, ...]:
    """The best of all simple ways to fly an order; its sequence of bodies is legal.

    They are: its legal beginning; and the order with and without its own refuelling stops, with
    and without keeping the way to the station open, where a move that is not legal is made after a
    refuelling stop, or else left out.

    Parameters
    ----------
    mission : Mission
    order : iterable of int or str
        Bodies in order, the station for refuelling; by number or name, and returned in the same
        form.
    """
    given = tuple(order)
    best = _best(mission, tuple(mission.numbers(given).tolist()))
    by_name = bool(given) and isinstance(given[0], str)
    found: Any = mission.named(best) if by_name else best
    return tuple(found)


def _best(mission: Mission, moves: tuple[int, ...]) -> tuple[int, ...]:
    bare = tuple(j for j in moves if not mission.rules.is_station[j])
    candidates = [as_it_is(mission, moves)]
    candidates += [_follow(mission, some, guard) for some in (moves, bare) for guard in (0, 1)]
    timings = [mission.time(candidate) for candidate in candidates]
    best = max(range(len(candidates)), key=lambda c: (timings[c].objective, -timings[c].cost))
    return candidates[best]


def _follow(mission: Mission, order: Iterable[int], guard: int) -> tuple[int, ...]:
    """Fly an order; where the next move is not legal, refuel, or else skip it.

    With ``guard`` a move to a target also counts as not legal if the station is out of reach
    after it; at the end the guard is dropped, as there is no need to return.
    """
    rules = mission.rules
    visited = np.zeros(len(mission.names), dtype=np.bool_)
    state = rule_kernels.beginning(rules)
    made: list[int] = []
    passed_by: list[int] = []

    def after(state: State, j: int) -> State | None:
        if not rule_kernels.may_go(rules, state, visited, j):
            return None
        legal, _, onward = rule_kernels.step(rules, state, j)
        return onward if legal else None

    def by_station(state: State) -> tuple[int, State] | None:
        ways = [(s, after(state, s)) for s in range(rules.stations)]
        reached = [(onward.resources.time, s, onward) for s, onward in ways if onward is not None]
        return min(reached)[1:] if reached else None

    def open_way(state: State | None) -> bool:
        return state is not None and (not guard or by_station(state) is not None)

    for j in order:
        direct = after(state, j)
        if direct is not None and (rules.is_station[j] or open_way(direct)):
            state = direct
            visited[j] = not rules.is_station[j]
            made.append(j)
            continue
        if rules.is_station[j]:
            continue
        refuelled = by_station(state)
        onward = None if refuelled is None else after(refuelled[1], j)
        if refuelled is not None and onward is not None and open_way(onward):
            state = onward
            visited[j] = True
            made += [refuelled[0], j]
        else:
            passed_by.append(j)
    for j in passed_by if guard else []:
        onward = after(state, j)
        if onward is not None:
            state = onward
            visited[j] = True
            made.append(j)
    return mission.closed(made)
