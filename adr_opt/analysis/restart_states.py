"""Possible starts of the rest of a mission: chasers as they are, or refuelled first."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import replace
from itertools import product

import numpy as np

from ..common.constants import SLACK_M_S
from ..legs.service_limits import limits_of
from ..mission.build_legs import transfer_leg
from ..mission.mission import Mission
from ..plan.plan import Plan
from ..plan.routes import weighed
from ..problem.instance import Instance
from .state import ChaserState, heavier

NEAR_EMPTY = 0.5
"""Share of a tank below which refuelling first is tried."""

Former = Mapping[str, tuple[str, ...]]
"""Pending bodies of each chaser, by name."""


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


def restart_states(
    left: Callable[[tuple[ChaserState, ...]], Instance | None],
    states: tuple[ChaserState, ...],
    former: Former,
) -> Iterator[tuple[Instance, tuple[ChaserState, ...]]]:
    """Possible instances of the rest: chasers as they are, or refuelled first.

    The last one is that of chasers as they are, where no other one is possible.

    Parameters
    ----------
    left : callable
        The instance that is left with chasers so; None where stations do not allow it.
    states : tuple of ChaserState
        Where the chasers are.
    former : mapping
        What they were about to do.
    """
    rest = left(states)
    assert rest is not None  # what is flown kept to the limits
    ways = []
    for number, state in enumerate(states):
        order = former[state.chaser.name]
        about_to = bool(order) and order[0] in rest.station_names
        low = not order or state.left_m_s < NEAR_EMPTY * state.chaser.tank.delta_v_m_s
        may = about_to or low or state.has_to_return
        more = list(_refuelled(rest, state, number)) if may else []
        ways.append(more if about_to and more else [state, *more])
    found = 0
    for chosen in product(*ways):
        beginning = rest if chosen == states else left(chosen)
        if beginning is not None:
            yield beginning, chosen
            found += 1
    if not found:
        yield rest, states


def _refuelled(rest: Instance, state: ChaserState, number: int) -> Iterator[ChaserState]:
    """The chaser after refuelling first, for each station that it can reach."""
    if not state.is_at_target or not (rest.targets or state.has_to_return):
        return
    if state.is_put:  # by the rules of the rest it may refuel at once
        return
    mission = Mission(rest, chaser=number)
    connecting, limits = mission.connecting, limits_of(rest, number)
    i, chaser = rest.starts[number], heavier(rest.chasers[number], state.weighed_kits)
    full_m_s = chaser.tank.delta_v_m_s
    for station, name in enumerate(rest.station_names):
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
        (leg,) = weighed(rest, chaser.replace(kits=None), [leg])
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
