"""From a visiting order that somebody else made, at other costs, to one that is legal here.

Solvers for static matrices promise more than the mission keeps. :func:`as_it_is` says how much of
an order is legal when it is timed exactly, and :func:`mended` what can be saved of it by refuelling
where it must and leaving out what it cannot reach.
"""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np

from .kernels import rules as rule_kernels
from .kernels.constants import STATION
from .mission import Mission

State = tuple[int, float, float, int]
"""Body, time [s], ΔV left [m/s], targets since the last refuelling."""


def as_it_is(mission: Mission, order: Iterable[int]) -> tuple[int, ...]:
    """The legal beginning of an order.

    Parameters
    ----------
    mission : Mission
    order : iterable of int
        Bodies in order, the station for refuelling.
    """
    moves = tuple(order)
    return moves[: mission.time(moves).made]


def mended(mission: Mission, order: Iterable[int]) -> tuple[int, ...]:
    """The best of all simple ways to fly an order; its sequence of bodies is legal.

    They are: its legal beginning; and the order with and without its own refuelling stops, with
    and without keeping the way to the station open, where a move that is not legal is made after a
    refuelling stop, or else left out.

    Parameters
    ----------
    mission : Mission
    order : iterable of int
        Bodies in order, the station for refuelling.
    """
    moves = tuple(order)
    bare = tuple(j for j in moves if j != STATION)
    candidates = [as_it_is(mission, moves)]
    candidates += [_follow(mission, some, guard) for some in (moves, bare) for guard in (0, 1)]
    timings = [mission.time(candidate) for candidate in candidates]
    best = max(range(len(candidates)), key=lambda c: (timings[c].objective, -timings[c].delta_v))
    return candidates[best]


def _follow(mission: Mission, order: Iterable[int], guard: int) -> tuple[int, ...]:
    """Fly an order; refuel where the next move is not legal, else leave it out.

    With ``guard`` a move to a target also counts as not legal if the station is out of reach
    after it; at the end the guard is dropped, as nobody has to return.
    """
    rules = mission.rules
    visited = np.zeros(len(mission.names), dtype=np.bool_)
    state: State = (STATION, 0.0, rules.budget, 0)
    made: list[int] = []
    passed_by: list[int] = []

    def after(state: State, j: int) -> State | None:
        body, now, left, since = state
        if not rule_kernels.may_go(body, since, visited, j):
            return None
        legal, delta_v, end = rule_kernels.fits(rules, body, now, left, j)
        if not legal:
            return None
        if j == STATION:
            return j, end, rules.budget, 0
        return j, end, left - delta_v, since + 1

    def open_way(state: State | None) -> bool:
        return state is not None and (not guard or after(state, STATION) is not None)

    for j in order:
        direct = after(state, j)
        if direct is not None and (j == STATION or open_way(direct)):
            state = direct
            visited[j] = j != STATION
            made.append(j)
            continue
        if j == STATION:
            continue
        refuelled = after(state, STATION)
        onward = None if refuelled is None else after(refuelled, j)
        if onward is not None and open_way(onward):
            state = onward
            visited[j] = True
            made += [STATION, j]
        else:
            passed_by.append(j)
    for j in passed_by if guard else []:
        onward = after(state, j)
        if onward is not None:
            state = onward
            visited[j] = True
            made.append(j)
    while made and made[-1] == STATION:
        made.pop()
    return tuple(made)
