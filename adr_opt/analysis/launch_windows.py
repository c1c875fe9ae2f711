"""Start times of chasers that resume at an object they are still to tow.

An instance cannot name the chaser for a target, so times have to: the target's window is that of
one service, and only one chaser is there in time.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace

from ..mission.result import Result
from ..problem.instance import Instance
from .state import ChaserState, put_s

MOMENT_S = 1e-3
"""Delay that is definite within the slack of the model [s]."""


def in_order(zoned: Instance, states: tuple[ChaserState, ...]) -> tuple[ChaserState, ...]:
    """States in order of their starts, with launches kept apart and resumptions at distinct times.

    Where launches are kept apart, they are made in the order of the file. Of those that are put
    somewhere no two begin at once: no other chaser comes to the first one's target in time, so
    that it is put there, nor to that of the second one, and so on.
    """
    if not any(state.is_put for state in states):
        return states
    order, last_s, found = [chaser.name for chaser in zoned.chasers], -math.inf, []
    apart_s = zoned.mission.launch_separation_s
    for state in sorted(states, key=lambda state: order.index(state.chaser.name)):
        if state.body is None and apart_s is not None:
            state = replace(state, free_s=max(state.free_s, last_s))
            last_s = state.free_s + apart_s
        found.append(state)
    last_s = -math.inf
    for at, state in sorted(enumerate(found), key=lambda each: _begins_s(zoned, each[1])):
        if state.is_put:
            late_s = max(last_s + MOMENT_S - _begins_s(zoned, state), 0.0)
            found[at] = replace(state, free_s=state.free_s + late_s)
            last_s = _begins_s(zoned, found[at])
    return tuple(sorted(found, key=lambda state: _begins_s(zoned, state)))


def _begins_s(zoned: Instance, state: ChaserState) -> float:
    """Start of a chaser's remaining mission [s]."""
    return put_s(zoned, state)[0] if state.is_put else state.free_s


def is_usurped(states: Sequence[ChaserState], made: Result) -> bool:
    """Whether another chaser reaches the target of a resuming chaser first.

    That one is free for something better then, as nothing says who it is that has to be put there.
    """
    if made.plan is None:
        return False
    first = {route.chaser: route.legs[0].destination for route in made.plan.routes if route.legs}
    return any(state.is_put and first.get(state.chaser.name) != state.body for state in states)


def kept_waiting(states: tuple[ChaserState, ...]) -> tuple[ChaserState, ...]:
    """States in which all others wait until every resuming chaser has started.

    That costs the others some hours, so that it is only done where a target is usurped.
    """
    last_s = max(state.free_s for state in states if state.is_put) + MOMENT_S
    return tuple(
        state if state.is_put else replace(state, free_s=max(state.free_s, last_s))
        for state in states
    )
