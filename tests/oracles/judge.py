"""The best plan that `check` accepts on a small instance: the yardstick of proofs.

Stands on none of the kernels that choose: any crossing of a node from the moment when the chaser is
ready, and any (k, m), are proposed. Where it is clear that a leg keeps to the rules nothing is
asked; in all cases that rounding could decide, and about the plan as a whole, `check` judges, with
true figures and with figures rounded in the plan's own favour. For one chaser, one station and no
windows.
"""

from __future__ import annotations

import itertools
from collections import defaultdict
from collections.abc import Sequence
from typing import NamedTuple

import every_sequence
import numpy as np
from every_sequence import Flown

import adr_opt
from adr_opt.kernels.legs import burns
from adr_opt.kernels.orbits import columns, ephemeris
from adr_opt.plan.plan import Burn, InstanceReference, Leg, Plan, Route, Unvisited
from adr_opt.problem.instance import Instance

NEAR_S, NEAR_M_S = 2e-3, 1e-3
"""Margins by which a rule is met or missed that are left to ``check``."""

FAVOUR_S, FAVOUR_M_S = 0.9e-3, 0.9e-4
"""Improvements of stated times and ΔV that ``check`` tolerates."""

Way = tuple[tuple[int, int, Flown], ...]


class Label(NamedTuple):
    """Since when a chaser is somewhere, with how much ΔV, and how it came there."""

    ready: float
    left: float
    way: Way


def accepted(instance: Instance) -> Plan:
    """A plan that collects the most of all to which `check` has no objection."""
    return max((_best(instance, favour) for favour in (0.0, 1.0)), key=lambda plan: plan.objective)


def _best(instance: Instance, favour: float) -> Plan:
    """The best of all plans whose figures are true, or flattering."""
    bodies, prizes = len(instance.names), [target.prize for target in instance.targets]
    legs = {(i, j): _legs(instance, i, j) for i, j in itertools.permutations(range(bodies), 2)}
    fronts: dict[tuple[frozenset[int], int], list[Label]] = defaultdict(list)
    fronts[frozenset(), 0].append(Label(0.0, instance.chaser.tank.delta_v_m_s, ()))
    best, most = plan_of(instance, (), favour), 0.0
    targets = range(1, bodies)
    for size in range(bodies):
        for done in map(frozenset, itertools.combinations(targets, size)):
            # From targets one comes to the station without doing another one, so it is last.
            for i in (*targets, 0):
                for label in fronts[done, i]:
                    value = sum(prizes[j - 1] for j in done)
                    if value > most:
                        plan = plan_of(instance, label.way, favour)
                        assert adr_opt.check(instance, plan) == ()
                        best, most = plan, value
                    for j in range(bodies):
                        if j == i or j in done or (j == 0 and i == 0):
                            continue
                        front = fronts[done | {j} if j else done, j]
                        _extend(instance, favour, label, (i, j, legs[i, j]), front)
    return best


def _extend(
    instance: Instance,
    favour: float,
    label: Label,
    move: tuple[int, int, list[Flown]],
    front: list[Label],
) -> None:
    """Fly all legs of a move that may be flown, as far as no other way is earlier and richer."""
    i, j, legs = move
    last = instance.mission.duration_s
    service = _service_s(instance, j)
    for leg in legs:
        ready, left = leg.arrival + service, label.left - leg.delta_v
        waits, rest = leg.departure - label.ready, last - ready
        if waits < -NEAR_S or left < -NEAR_M_S or rest < -NEAR_S:
            continue
        after = left if j else instance.chaser.tank.delta_v_m_s
        if any(other.ready <= ready and other.left >= after for other in front):
            continue
        way = (*label.way, (i, j, leg))
        doubtful = waits < NEAR_S or left < NEAR_M_S or rest < NEAR_S
        if doubtful and adr_opt.check(instance, plan_of(instance, way, favour)):
            continue
        front[:] = [other for other in front if other.ready < ready or other.left > after]
        front.append(Label(ready, after, way))


def _legs(instance: Instance, i: int, j: int) -> list[Flown]:
    """The sequences of a pair that no zone forbids, but those that another one dominates."""
    last = instance.mission.duration_s
    open_everywhere = instance.replace(keep_out_zones=())
    events = every_sequence.of_pair(open_everywhere, i, j, -NEAR_S, last)
    kept: list[Flown] = []
    for leg in sorted(itertools.chain(*events), key=lambda leg: (leg.arrival, leg.delta_v)):
        if leg.arrival > last + NEAR_S or any(
            other.departure >= leg.departure and other.delta_v <= leg.delta_v for other in kept
        ):
            continue
        if instance.keep_out_zones:
            violations = adr_opt.check(instance, plan_of(instance, ((i, j, leg),)))
            if any(violation.rule == "zone" for violation in violations):
                continue
        kept.append(leg)
    return kept


def _service_s(instance: Instance, j: int) -> float:
    """Length of a chaser's stay at a body."""
    revolutions = instance.mission.service_revolutions if j else instance.mission.refuel_revolutions
    return float((revolutions or 0.0) * ephemeris.period(instance.orbits()[j, columns.RADIUS]))


def plan_of(instance: Instance, way: Sequence[tuple[int, int, Flown]], favour: float = 0.0) -> Plan:
    """A plan of some legs, with all that has to be stated about them."""
    elements, rule = instance.orbits(), instance.transfer_rule()
    extra = instance.eccentricity_delta_v()
    ready, left = 0.0, instance.chaser.tank.delta_v_m_s
    legs = []
    for i, j, flown in way:
        times, vectors, phases = burns.burns_between(
            elements[i],
            elements[j],
            extra[i, j],
            rule,
            flown.departure,
            flown.arrival,
            flown.revolutions,
        )
        end = flown.arrival + _service_s(instance, j)
        left = left - flown.delta_v if j else instance.chaser.tank.delta_v_m_s
        leg = Leg(
            origin=instance.names[i],
            destination=instance.names[j],
            ready_s=ready - favour * FAVOUR_S * bool(legs),
            departure_s=flown.departure,
            arrival_s=flown.arrival - favour * FAVOUR_S,
            end_s=end - favour * FAVOUR_S,
            delta_v_m_s=flown.delta_v - favour * FAVOUR_M_S,
            delta_v_left_m_s=left + favour * FAVOUR_M_S,
            phasing_revolutions=flown.revolutions,
            eccentricity_delta_v_m_s=0.0
            if extra[i, j] == 0.0
            else max(0.0, flown.delta_v - float(np.linalg.norm(vectors, axis=1).sum())),
            burns=tuple(
                Burn(
                    time_s=float(time),
                    delta_v_m_s=tuple(float(part) for part in vector),
                    phase=burns.PHASES[phase],
                )
                for time, vector, phase in zip(times, vectors, phases, strict=True)
            ),
        )
        legs.append(leg)
        ready = end
    visited = {leg.destination for leg in legs}
    collected = sum(target.prize for target in instance.targets if target.name in visited)
    complete = all(target.name in visited or not target.prize for target in instance.targets)
    return Plan(
        instance=InstanceReference(name=instance.name, sha256=instance.sha256),
        method="judge",
        seed=0,
        status="optimal" if complete else "feasible",
        objective=collected,
        cost=sum(leg.delta_v_m_s for leg in legs),
        runtime_s=0.0,
        routes=(Route(chaser=instance.chaser.name, legs=tuple(legs)),),
        unvisited=tuple(
            Unvisited(target=target.name, reason="not-worth-it")
            for target in instance.targets
            if target.name not in visited
        ),
    )
