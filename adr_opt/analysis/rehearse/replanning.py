"""Policies that replan the rest of a mission in flight.

A new plan is flown only if it is worth more than the one at hand, both followed in the same drawn
worlds. By induction over the decisions, what is flown is then worth no less on average than to
follow the first plan (docs/model.md section 13.5).

Planners run under a limit of wall time. Where one reaches it, as the planner of several chasers
may, what it finds depends on the machine and its load, so that such a rehearsal is not a function
of the seed alone.
"""

from __future__ import annotations

import math

import numpy as np

from ...common.constants import HOUR_S, SLACK_M_S, SLACK_S
from ...plan.leg_kinds import leg_kinds
from ...plan.plan import Leg, Tow
from ...problem.chasers import TankByMass
from ...problem.instance import Instance
from ...problem.uncertainty import Uncertainty
from ..replan.chaser_states import ChaserState
from ..replan.remaining_instance import remaining_instance
from ..replan.remaining_plan import PlannerChoice, plan_remaining
from ..replan.starts import in_order
from .expectation import expectation_of
from .flight import Halt, Situation
from .flying_chasers import (
    DRY,
    FAILED,
    FINISHED,
    GONE,
    LATE,
    SERVICED,
    FlyingChaser,
    Made,
    as_planned,
    beginning,
    refused,
)
from .intended import Intended, PlannedHop, hops_of
from .mission_facts import Hop, MissionFacts, hop_of
from .outlook import FIRST_WORLD, WORLDS, Outlook, is_better
from .planned_order import planned_hop

SLIGHT_S = HOUR_S
"""Lateness below which a plan is kept [s]."""

SLIGHT_SHARE = 0.01
"""Share of a tank by which it may differ from the plan before the rest is replanned."""

TIME_LIMIT_S = 2.0
"""Limit of the wall time of a planner [s]."""


Routes = list[list[PlannedHop]]
"""The rest of each chaser's plan."""


class AtEveryService:
    """Replans the rest whenever a chaser is free, and keeps the better plan."""

    def __init__(
        self, facts: MissionFacts, intended: Intended, uncertainty: Uncertainty, seed: int = 0
    ) -> None:
        self._facts, self._seed = facts, seed
        self._expectation = expectation_of(facts, intended, uncertainty)
        self._outlook, self._worlds = Outlook(facts, uncertainty), FIRST_WORLD
        self._routes: Routes = [list(route) for route in intended.routes]
        self._forecast = [
            beginning(facts, chaser, intended.kits[chaser], what.limits.ready, 1.0)
            for chaser, what in enumerate(facts.chasers)
        ]

    def next_leg(self, now: Situation) -> Hop | Halt:
        """The first leg of the new plan."""
        craft = now.craft
        if self._has_changed(now) or not self._routes[craft.chaser]:
            self._choose(now)
        route = self._routes[craft.chaser]
        if not route:
            return Halt(FINISHED)
        found = planned_hop(now, route, 0)
        route.pop(0)
        if found is None:
            return Halt("duration")
        hop = self._earlier(craft, found)
        self._forecast[craft.chaser] = as_planned(self._facts, craft, hop)
        return hop

    def tries_again(self, now: Situation, target: int, tries: int) -> bool:
        """Tries again as often as allowed."""
        return True

    def _has_changed(self, now: Situation) -> bool:
        """Whether to replan: always, except at the start of a mission without uncertainty."""
        return bool(now.craft.made) or self._expectation.differs or self._differs(now.craft)

    def _differs(self, craft: FlyingChaser) -> bool:
        """Whether the chaser deviates in time or resources by more than a tolerance."""
        ahead, what = self._forecast[craft.chaser], self._facts.chasers[craft.chaser]
        differs = abs(craft.left - ahead.left) > SLIGHT_SHARE * what.budget
        return differs or abs(craft.free_s - ahead.free_s) > SLIGHT_S

    def _earlier(self, craft: FlyingChaser, hop: Hop) -> Hop:
        """The earliest arrival at the same body that takes no more ΔV.

        Neither as planned, nor by a kind of leg that may cost more than planned by a larger factor.
        """
        if self._facts.chasers[craft.chaser].is_launched and not craft.made:
            return hop
        rows = self._facts.rows(craft.body, hop.destination, towed=craft.towed)
        first = int(np.searchsorted(rows.departure, craft.free_s - SLACK_S))
        last = int(np.searchsorted(rows.departure, hop.departure))
        could = first + np.flatnonzero(rows.delta_v[first:last] <= hop.delta_v)
        if not could.size:
            return hop
        row = int(could[np.argmin(rows.arrival[could])])
        found = hop_of(hop.destination, rows, row)
        is_as_certain = self._expectation.sigma(found) <= self._expectation.sigma(hop)
        return found if found.arrival < hop.arrival and is_as_certain else hop

    def _choose(self, now: Situation) -> None:
        """Plan the rest with and without reserves, and keep the best plan."""
        worlds = range(self._worlds, self._worlds + WORLDS)
        self._worlds = worlds.stop
        best = None
        for cautious in (True, False) if self._expectation.is_cautious else (False,):
            found = self._planned(now, cautious=cautious)
            if found is None or found == self._routes:
                continue
            if best is None:
                best = self._outlook.worths(now, self._routes, worlds)
            worths = self._outlook.worths(now, found, worlds)
            if is_better(worths, best):
                self._routes, best = found, worths

    def _planned(self, now: Situation, *, cautious: bool) -> Routes | None:
        """A plan of the rest for all chasers, from their present or next free positions."""
        facts, at_s = self._facts, now.craft.free_s
        flying = [craft for craft in now.chasers if craft is now.craft or not craft.ended]
        states = in_order(facts.instance, tuple(_state(facts, craft, at_s) for craft in flying))
        former = {
            facts.chasers[craft.chaser].name: tuple(
                facts.names[each.hop.destination] for each in self._routes[craft.chaser]
            )
            for craft in flying
        }
        visited = {leg.destination for state in states for leg in state.legs}
        lost = [facts.names[j] for j in sorted(now.closed)]
        gone = tuple(name for name in lost if name not in visited)
        choice = PlannerChoice(None, TIME_LIMIT_S, self._seed, None, facts.cores)
        for wanted in (facts.instance, facts.without_required):

            def left(
                known: tuple[ChaserState, ...], instance: Instance = wanted
            ) -> Instance | None:
                missed = [name for state in known for name in state.missed]
                rest = remaining_instance(instance, known, gone, at_s, missed)
                return None if rest is None else self._expectation.expected(rest, cautious=cautious)

            rest = plan_remaining(wanted, left, states, former, choice)
            if rest.result.plan is not None:
                break
        else:
            return None
        flown = {route.chaser: route.legs for route in rest.result.plan.routes}
        here = {facts.chasers[craft.chaser].name: craft for craft in flying}
        before = {state.chaser.name: len(state.legs) for state in states}
        found: Routes = [list(route) for route in self._routes]
        for state in rest.states:
            name = state.chaser.name
            craft = here[name]
            more = (*state.legs[before[name] :], *state.onward(flown.get(name, ())))
            found[craft.chaser] = list(hops_of(facts, more, craft.body, towed=craft.towed))
        return found


class AtDeviations(AtEveryService):
    """Replans the rest when a chaser deviates from the plan, and follows the plan otherwise."""

    def _has_changed(self, now: Situation) -> bool:
        craft = now.craft
        if self._differs(craft) or (not craft.made and self._expectation.differs):
            return True
        if craft.made and craft.made[-1].outcome in (FAILED, GONE):
            what = self._facts.chasers[craft.chaser]
            if what.loads is not None or what.most_targets is not None:
                return True
        return not self._is_flyable(craft)

    def _is_flyable(self, craft: FlyingChaser) -> bool:
        """Whether the rest of the plan can be flown as planned."""
        ahead, hops = craft.copied(), [each.hop for each in self._routes[craft.chaser]]
        ahead.left -= self._expectation.spread_m_s(hops)
        for each in self._routes[craft.chaser]:
            if each.origin != ahead.body or each.towed != ahead.towed:
                return False
            if refused(self._facts, ahead, each.hop):
                return False
            ahead = as_planned(self._facts, ahead, each.hop)
        return True


def _state(facts: MissionFacts, craft: FlyingChaser, at_s: float) -> ChaserState:
    """State of a chaser for replanning, with the object that it still has to tow, if any."""
    chaser = facts.instance.chasers[craft.chaser]
    legs = tuple(_leg(facts, made) for made in craft.made)
    is_put = craft.towed
    left = max((craft.made[-1].untowed if is_put else craft.left) - SLACK_M_S, 0.0)
    free_s = craft.made[-1].end_s if is_put else craft.free_s
    propellant = None
    if isinstance(chaser.tank, TankByMass):
        empty_kg = chaser.tank.dry_mass_kg + craft.kits * chaser.kit_mass_kg
        propellant = empty_kg * math.expm1(left / chaser.tank.exhaust_m_s)
    kits = chaser.kits
    takers = sum(
        made.outcome == SERVICED and facts.takes_kit(made.hop.destination) for made in craft.made
    )
    if legs and chaser.kit_mass_kg > 0.0:
        kits = craft.kits
    elif kits is not None:
        kits -= takers
    missed = tuple(
        facts.names[made.hop.destination]
        for made in craft.made
        if made.outcome in (FAILED, GONE, LATE, DRY)
    )
    return ChaserState(
        chaser,
        legs,
        legs[-1].destination if legs else _start(facts, craft),
        max(free_s, at_s if not is_put else free_s),
        left,
        propellant,
        kits,
        craft.since,
        facts.chasers[craft.chaser].limits.ready,
        is_put=is_put,
        missed=missed,
    )


def _start(facts: MissionFacts, craft: FlyingChaser) -> str | None:
    return None if facts.chasers[craft.chaser].is_launched else facts.names[craft.body]


def _leg(facts: MissionFacts, made: Made) -> Leg:
    """A flown leg, reduced to the fields that replanning reads."""
    j = made.hop.destination
    tow = None
    if made.outcome == SERVICED and j in facts.tow_s:
        tow = Tow(start_s=made.end_s, end_s=made.free_s, delta_v_m_s=0.0, burns=())
    return Leg(
        kind=leg_kinds()[made.hop.family].name,
        origin=facts.names[made.origin],
        destination=facts.names[j],
        ready_s=made.ready_s,
        departure_s=made.hop.departure,
        arrival_s=made.hop.arrival,
        end_s=made.end_s,
        delta_v_m_s=made.delta_v,
        delta_v_left_m_s=made.left,
        phasing_revolutions=0,
        burns=(),
        tow=tow,
    )
