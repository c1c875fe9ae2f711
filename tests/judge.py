"""Every plan that `check` accepts on a small instance: the yardstick of proofs.

Stands on none of the kernels that choose: visiting orders, departures near the moment when the
chaser is ready, and figures rounded in the plan's own favour are proposed, and `check` judges.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import NamedTuple

import adr_opt
from adr_opt.instance import Instance
from adr_opt.kernels import burns, orbits, transfer
from adr_opt.plan import Burn, InstanceReference, Leg, Plan, Route, Unvisited

NEAR_S = 2e-3
"""A departure is tried from so long before the chaser is ready: beyond what `check` tolerates."""

FAVOUR_S, FAVOUR_M_S = 0.9e-3, 0.9e-4
"""Times and ΔV may be stated better by this much than they are, within what `check` tolerates."""


class State(NamedTuple):
    """Where a chaser is, since when, and with how much ΔV."""

    body: int
    ready: float
    left: float


def accepted(instance: Instance) -> Plan:
    """A plan that collects the most of all to which `check` has no objection."""
    start = State(0, 0.0, instance.chaser.tank.delta_v_m_s)
    found = [plan for favour in (0.0, 1.0) for plan in _plans(instance, favour, (), start)]
    return max(found, key=lambda plan: plan.objective)


def _plans(
    instance: Instance, favour: float, legs: tuple[Leg, ...], state: State
) -> Iterator[Plan]:
    """The plans that begin with some legs and that `check` accepts."""
    plan = _plan(instance, legs)
    if adr_opt.check(instance, plan):
        return
    yield plan
    for j, name in enumerate(instance.names):
        if j != state.body and (j == 0 or name not in plan.destinations):
            for leg, after in _legs(instance, favour, state, j):
                yield from _plans(instance, favour, (*legs, leg), after)


def _legs(instance: Instance, favour: float, state: State, j: int) -> Iterator[tuple[Leg, State]]:
    """The legs to a body at the departures near the moment when the chaser is ready."""
    limits, rule, elements = instance.mission, instance.transfer_rule(), instance.orbits()
    i, ready, left = state
    extra = float(instance.eccentricity_delta_v()[i, j])
    pair = transfer.prepare(elements[i], elements[j], extra, rule)
    crossing = math.ceil((pair.phase_i + pair.rate_i * (ready - NEAR_S)) / math.pi)
    for half_turns in (crossing, crossing + 1):
        departure = (half_turns * math.pi - pair.phase_i) / pair.rate_i
        if half_turns > crossing and departure > ready + math.pi / pair.rate_i:
            return  # the one before was not too early
        lead = (pair.phase_j + pair.rate_j * departure - math.pi * half_turns) % (2.0 * math.pi)
        flown = transfer.best_sequence(pair, rule, departure, lead)
        if not math.isfinite(flown.delta_v):
            continue
        times, vectors, phases = burns.burns(
            elements[i], elements[j], pair, rule, departure, flown.revolutions,
            flown.phasing_radius,
        )  # fmt: skip
        period = orbits.period(elements[j, orbits.RADIUS])
        arrival = departure + flown.flight_time + rule.approach_revolutions * period
        end = arrival + (limits.service_revolutions if j else limits.refuel_revolutions) * period
        rest = left - flown.delta_v if j else instance.chaser.tank.delta_v_m_s
        leg = Leg(
            origin=instance.names[i],
            destination=instance.names[j],
            ready_s=ready - favour * FAVOUR_S,
            departure_s=departure,
            arrival_s=arrival - favour * FAVOUR_S,
            end_s=end - favour * FAVOUR_S,
            delta_v_m_s=flown.delta_v - favour * FAVOUR_M_S,
            delta_v_left_m_s=rest + favour * FAVOUR_M_S,
            phasing_revolutions=int(flown.revolutions),
            eccentricity_delta_v_m_s=extra,
            burns=tuple(
                Burn(
                    time_s=float(time),
                    delta_v_m_s=tuple(float(part) for part in vector),
                    phase=burns.PHASES[phase],
                )
                for time, vector, phase in zip(times, vectors, phases, strict=True)
            ),
        )
        yield leg, State(j, float(end), float(rest))


def _plan(instance: Instance, legs: tuple[Leg, ...]) -> Plan:
    """A plan of some legs, with all that has to be stated about them."""
    visited = {leg.destination for leg in legs}
    collected = sum(target.prize for target in instance.targets if target.name in visited)
    total = sum(target.prize for target in instance.targets)
    return Plan(
        instance=InstanceReference(name=instance.name, sha256=instance.sha256),
        method="judge",
        seed=0,
        status="optimal" if math.isclose(collected, total) else "feasible",
        objective=collected,
        cost=sum(leg.delta_v_m_s for leg in legs),
        runtime_s=0.0,
        routes=(Route(chaser=instance.chaser.name, legs=legs),),
        unvisited=tuple(
            Unvisited(target=target.name, reason="not-worth-it")
            for target in instance.targets
            if target.name not in visited
        ),
    )
