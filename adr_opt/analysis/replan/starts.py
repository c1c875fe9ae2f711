"""Possible starts of what remains of a mission: chasers as they are, or refuelled first.

A chaser that is still to tow an object starts there. An instance cannot name the chaser for a
target, so times have to: the target's window is that of one service, and only one chaser is there
in time.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import replace
from itertools import product

import numpy as np

from ...common.constants import SLACK_M_S
from ...legs.service_limits import limits_of
from ...mission.build_legs import transfer_leg
from ...mission.mission import Mission
from ...mission.result import Result
from ...plan.plan import Plan
from ...plan.routes import weighed
from ...problem.instance import Instance
from .chaser_states import ChaserState, heavier, put_s

MOMENT_S = 1e-3
"""Delay that clearly exceeds the slack of the model [s]."""

NEAR_EMPTY = 0.5
"""Share of a tank below which refuelling first is tried."""

Former = Mapping[str, tuple[str, ...]]
"""Pending bodies of each chaser, by name."""

Remaining = Callable[[tuple[ChaserState, ...]], Instance | None]
"""The remaining instance after some states; None if stations do not allow it."""


def in_order(instance: Instance, states: tuple[ChaserState, ...]) -> tuple[ChaserState, ...]:
    """States in order of their starts, with launches kept apart and resumptions at distinct times.

    Where launches are kept apart, they are made in the order of the file. Of those that are put
    somewhere no two begin at once: no other chaser reaches the first one's target in time, so
    that it is put there, nor that of the second one, and so on.
    """
    if not any(state.is_put for state in states):
        return states
    order, last_s, found = [chaser.name for chaser in instance.chasers], -math.inf, []
    apart_s = instance.mission.launch_separation_s
    for state in sorted(states, key=lambda state: order.index(state.chaser.name)):
        if state.body is None and apart_s is not None:
            state = replace(state, free_s=max(state.free_s, last_s))
            last_s = state.free_s + apart_s
        found.append(state)
    last_s = -math.inf
    for at, state in sorted(enumerate(found), key=lambda each: _begins_s(instance, each[1])):
        if state.is_put:
            late_s = max(last_s + MOMENT_S - _begins_s(instance, state), 0.0)
            found[at] = replace(state, free_s=state.free_s + late_s)
            last_s = _begins_s(instance, found[at])
    return tuple(sorted(found, key=lambda state: _begins_s(instance, state)))


def _begins_s(instance: Instance, state: ChaserState) -> float:
    """Start of a chaser's remaining mission [s]."""
    return put_s(instance, state)[0] if state.is_put else state.free_s


def is_usurped(states: Sequence[ChaserState], made: Result) -> bool:
    """Whether another chaser reaches the target of a resuming chaser first.

    The instance cannot say which chaser has to be put there, so that the resuming one would be free
    to do something better.
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


def former_orders(plan: Plan, states: Sequence[ChaserState]) -> Former:
    """Bodies that the plan would have visited after its fixed legs."""
    flown = {route.chaser: route.legs for route in plan.routes}
    if len(states) == 1:
        flown = {states[0].chaser.name: plan.legs}
    fixed = {state.chaser.name: len(state.legs) for state in states}
    return {
        name: tuple(leg.destination for leg in flown.get(name, ())[count:])
        for name, count in fixed.items()
    }


def possible_starts(
    remaining: Remaining, states: tuple[ChaserState, ...], former: Former
) -> Iterator[tuple[Instance, tuple[ChaserState, ...]]]:
    """Instances of what remains with their states: chasers as they are, or refuelled first.

    Where stations allow no other, that of all chasers as they are.

    Parameters
    ----------
    remaining : callable
    states : tuple of ChaserState
        Where the chasers are.
    former : mapping
        What they were about to do.
    """
    as_they_are = remaining(states)
    assert as_they_are is not None  # what is flown kept to the limits
    ways = []
    for number, state in enumerate(states):
        order = former[state.chaser.name]
        about_to = bool(order) and order[0] in as_they_are.station_names
        low = not order or state.left_m_s < NEAR_EMPTY * state.chaser.tank.delta_v_m_s
        may = about_to or low or state.has_to_return
        more = list(_refuelled(as_they_are, state, number)) if may else []
        ways.append(more if about_to and more else [state, *more])
    found = 0
    for chosen in product(*ways):
        beginning = as_they_are if chosen == states else remaining(chosen)
        if beginning is not None:
            yield beginning, chosen
            found += 1
    if not found:
        yield as_they_are, states


def _refuelled(instance: Instance, state: ChaserState, number: int) -> Iterator[ChaserState]:
    """The chaser after refuelling first, for each station that it can reach."""
    if not state.is_at_target or not (instance.targets or state.has_to_return):
        return
    if state.is_put:  # it may refuel at once by the rules of what remains
        return
    mission = Mission(instance, chaser=number)
    connecting, limits = mission.connecting, limits_of(instance, number)
    i, chaser = instance.starts[number], heavier(instance.chasers[number], state.weighed_kits)
    full_m_s = chaser.tank.delta_v_m_s
    for station, name in enumerate(instance.station_names):
        found = connecting.of_pair(i, station, connecting.planning_resolution_m_s)
        found = found.after(state.free_s)
        delta_v = found.delta_v - connecting.spent_m_s(i)
        paid = delta_v <= state.left_m_s + SLACK_M_S
        ends = np.where(paid, found.arrival, math.inf) + limits.service[station]
        if not ends.size or ends.min() > limits.duration:
            continue
        taken = int(np.lexsort((found.delta_v, ends))[0])
        leg = transfer_leg(mission, (i, station), state.legs[-1].free_s, found, taken).replace(
            origin=state.body or chaser.name, end_s=float(ends[taken]), delta_v_left_m_s=full_m_s
        )
        (leg,) = weighed(instance, chaser.replace(kits=None), [leg])
        yield replace(
            state,
            legs=(*state.legs, leg),
            body=name,
            free_s=leg.end_s,
            left_m_s=full_m_s,
            propellant_kg=None,
            since_refuelling=0,
        )


def orders_left(
    beginning: Instance,
    former: Former,
    states: tuple[ChaserState, ...],
    before: tuple[ChaserState, ...],
) -> list[list[str]]:
    """The former orders without missing bodies, and without a stop already made.

    It begins with the target that a chaser is put onto.
    """
    names, stations = set(beginning.names), beginning.station_names
    orders = []
    for state, former_state in zip(states, before, strict=True):
        left = [name for name in former[state.chaser.name] if name in names]
        if state is not former_state and left and left[0] in stations:
            left = left[1:]
        orders.append([state.body, *left] if state.is_put and state.body else left)
    return orders
