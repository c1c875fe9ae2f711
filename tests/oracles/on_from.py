"""Flown legs and a new rest as one mission, and the best rest by enumeration."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import NamedTuple

import numpy as np

import adr_opt
from adr_opt.analysis import Replanned, replan
from adr_opt.analysis.replan.chaser_states import states_at
from adr_opt.common.constants import SLACK_M_S, SLACK_S
from adr_opt.judge.check.violation import Violation
from adr_opt.plan.expense import cost_of_routes
from adr_opt.plan.plan import InstanceReference, Plan, Unvisited
from adr_opt.problem.instance import Instance

Rows = tuple[np.ndarray, np.ndarray, np.ndarray]


def violations(instance: Instance, made: Replanned, zones=()) -> tuple[Violation, ...]:
    """Violations of flown and replanned legs together, on the instance with new zones.

    Of what is proven nothing is stated, and nothing asked.
    """
    zoned = instance.replace(keep_out_zones=(*instance.keep_out_zones, *zones))
    routes = made.whole()
    legs = [leg for route in routes for leg in route.legs]
    visited = {leg.destination for leg in legs}
    objective = sum(target.prize for target in instance.targets if target.name in visited)
    whole = made.plan.replace(
        instance=InstanceReference(name=zoned.name, sha256=zoned.sha256),
        routes=routes,
        objective=objective,
        upper_bound=None,
        gap=None,
        status="feasible",
        cost_bound=None,
        cost_gap=None,
        cost_status=None,
        cost=cost_of_routes(zoned, routes),
        unvisited=tuple(
            Unvisited(target=target.name, reason="not-worth-it")
            for target in instance.targets
            if target.name not in visited
        ),
    )
    found = adr_opt.check(zoned, whole)
    return tuple(violation for violation in found if violation.rule != "status")


def rest_of(
    instance: Instance, plan: Plan, at_s: float, rng: np.random.Generator, case: object
) -> Replanned | None:
    """Plan the rest with legs kept and targets lost, and hold it: `check` passes, legs are kept.

    None where a target that is lost leaves no way to where a chaser has to end.
    """
    keep = int(rng.integers(3))
    states = states_at(instance, plan, at_s, keep=keep)
    done = {leg.destination for state in states for leg in state.legs}
    free = {target.name for target in instance.targets if not target.required}
    ahead = [name for name in plan.destinations if name in free - done]
    lost = ahead[:1] if rng.random() < 0.4 else []
    made = replan(instance, plan, at_s, lost=lost, keep=keep, time_limit=60.0)
    if made.plan is None:
        assert lost, case
        return None
    assert adr_opt.check(made.instance, made.plan) == (), case
    waiting = any("waits" in note for note in made.notes)
    carried = any(state.idle_kits for state in made.states)
    # Neither waiting on a disposal orbit nor carrying kits to the end is for the whole mission.
    assert waiting or carried or violations(instance, made) == (), case
    flown = {state.chaser.name: state.legs for state in states}
    for route in made.whole():
        legs = flown[route.chaser]
        kept = route.legs[: len(legs)]
        assert kept[:-1] == legs[:-1], case
        # The tow of the last one may be later than it was planned.
        assert [leg.replace(tow=None) for leg in kept] == [leg.replace(tow=None) for leg in legs]
    lacking = sum(target.prize for target in instance.targets if target.name in lost)
    assert made.prize_after >= made.prize_before - lacking - 1e-9, case
    return made


class Field(NamedTuple):
    """A mission of one chaser without stations, as enumeration takes it.

    Attributes
    ----------
    rows : callable
        Departures, arrivals [s] and costs [m/s] from a body to another one, by name.
    prizes : mapping of str to float
    stays : mapping of str to float
        How long a chaser is not free after it has come [s].
    last_s : float
    after : callable
        What is left after a target, of what was left on arrival [m/s].
    """

    rows: Callable[[str, str], Rows]
    prizes: Mapping[str, float]
    stays: Mapping[str, float]
    last_s: float
    after: Callable[[str, float], float]


def most(field: Field, body: str, ready_s: float, left_m_s: float, todo: frozenset[str]) -> float:
    """The most that can be collected on from a body, by trying every order and connection."""
    best = 0.0
    for name in sorted(todo):
        departure, arrival, cost = field.rows(body, name)
        can = (departure >= ready_s - SLACK_S) & (cost <= left_m_s + SLACK_M_S)
        can &= arrival + field.stays[name] <= field.last_s + SLACK_S
        cheapest = np.inf
        for at in np.lexsort((cost, arrival)):
            # One that arrives later is worth a look only if it is cheaper.
            if not can[at] or cost[at] >= cheapest:
                continue
            cheapest = cost[at]
            left = field.after(name, left_m_s - float(cost[at]))
            if left >= -SLACK_M_S:
                ready = float(arrival[at]) + field.stays[name]
                on = most(field, name, ready, left, todo - {name})
                best = max(best, field.prizes[name] + on)
    return best
