"""The learned policy: follows the plan where it can be flown, else scores the next legs."""

from __future__ import annotations

import math

import numpy as np
import numpy.typing as npt

from ...learning.policy import Policy, load_policy
from ...problem.uncertainty import Uncertainty
from .expectation import CAUTION
from .flight import Halt, Situation
from .flying_chasers import FINISHED, FlyingChaser, as_planned, refused
from .intended import Intended
from .mission_facts import Hop, MissionFacts
from .replanning import AtDeviations
from .visible_legs import Seen, VisibleLegs

PLANNED, PLANNED_DECAY = 2.0, 0.7
"""Bonus on the score of the next planned leg, and its decay for each later one; targets that other
chasers plan to visit lose the bonus, required ones gain it."""


class Learned(AtDeviations):
    """Follows the plan as `replan` does, and otherwise chooses the next leg by the learned policy.

    No plan is made in flight: the policy sees the connections of the present body at the present
    time, and what may come of the legs. A chaser does not go where it could no longer refuel,
    unless nothing else is left or nothing could be serviced afterwards.

    Parameters
    ----------
    facts : MissionFacts
    intended : Intended
    uncertainty : Uncertainty
    seed : int
        Not used: scores are not drawn.
    policy : Policy, optional
        The one that comes with the package by default.
    """

    def __init__(
        self,
        facts: MissionFacts,
        intended: Intended,
        uncertainty: Uncertainty,
        seed: int = 0,
        policy: Policy | None = None,
    ) -> None:
        super().__init__(facts, intended, uncertainty, seed)
        self._policy = load_policy() if policy is None else policy
        self._visible = visible_legs_of(facts, uncertainty)

    def next_leg(self, now: Situation) -> Hop | Halt:
        """The planned leg, or the one with the best score among those that may begin."""
        craft = now.craft
        self._pass_what_is_done(now)
        route = self._routes[craft.chaser]
        if route and not self._has_changed(now) and self._is_prudent(craft, route[0].hop):
            hop = route.pop(0).hop
        else:
            found = self._best_scored(now)
            if found is None:
                return Halt(FINISHED)
            hop = found
        self._forecast[craft.chaser] = as_planned(self._facts, craft, hop)
        return hop

    def _is_prudent(self, craft: FlyingChaser, hop: Hop) -> bool:
        """Whether a planned leg leaves a way to refuel even if its service is late."""
        return self._visible.late_s[hop.destination] == 0.0 or self._is_guarded(craft, hop)

    def _pass_what_is_done(self, now: Situation) -> None:
        """Drop planned legs to closed targets and to stations that are of no use now."""
        craft, stations = now.craft, self._facts.stations
        route = self._routes[craft.chaser]
        while route:
            j = route[0].hop.destination
            used = j < stations and (craft.since == 0 or j == craft.body)
            if not (used or j in now.closed):
                return
            route.pop(0)

    def _best_scored(self, now: Situation) -> Hop | None:
        """The best-scored leg that may begin and, if any does, leaves a way to refuel."""
        facts, craft, visible = self._facts, now.craft, self._visible
        route = self._routes[craft.chaser]
        planned = [each.hop.destination for each in route]
        planned_by_others = {
            each.hop.destination
            for chaser, routed in enumerate(self._routes)
            for each in routed
            if chaser != craft.chaser
        }
        own = None
        if route and (route[0].origin, route[0].towed) == (craft.body, craft.towed):
            own = route[0].hop if route[0].departs(craft.free_s) else None
        seen = visible.seen(craft, now.closed, planned, own)
        if not seen.legal.any():
            return None
        scores = self._scored(seen, planned, planned_by_others)
        unguarded: Hop | None = None
        for at in np.argsort(-scores):
            if not seen.legal[at]:
                break
            j = int(seen.bodies[at])
            is_own = own is not None and own.destination == j
            hop = own if is_own else visible.hop(craft, j, seen.arrival[at], seen.delta_v[at])
            if hop is None or refused(facts, craft, hop):
                continue
            if self._is_guarded(craft, hop):
                return hop
            unguarded = unguarded or hop
        return unguarded

    def _scored(
        self, seen: Seen, planned: list[int], planned_by_others: set[int]
    ) -> npt.NDArray[np.float32]:
        """Scores of legs: those of the policy, with bonuses for plans and required targets."""
        scores = self._policy.scores(seen.moves, seen.mission)[0]
        gain = np.zeros(len(self._facts.names), dtype=np.float32)
        gain[self._visible.required] = PLANNED
        for rank, j in reversed(list(enumerate(planned))):
            gain[j] += PLANNED * PLANNED_DECAY**rank
        gain[list(planned_by_others)] -= PLANNED
        scored: npt.NDArray[np.float32] = scores + gain[seen.bodies]
        return scored

    def _is_guarded(self, craft: FlyingChaser, hop: Hop) -> bool:
        """Whether a leg leaves a way to refuel even if it is expensive and its service long."""
        facts, j = self._facts, hop.destination
        if j < facts.stations or not facts.stations:
            return True
        after, visible = as_planned(facts, craft, hop), self._visible
        ways = [
            visible.way_back_m_s(craft, j, after.free_s + late_s)
            for late_s in {visible.later_s[j], visible.late_s[j]}
        ]
        spread = CAUTION * self._expectation.sigma(hop) * math.hypot(hop.delta_v, max(ways))
        return min(ways) == 0.0 or max(ways) + spread <= after.left


def visible_legs_of(facts: MissionFacts, uncertainty: Uncertainty) -> VisibleLegs:
    """The legs visible to policies in a mission, shared by its rehearsals."""
    known = facts.visible_legs
    if known is None or known[0] is not uncertainty:
        known = facts.visible_legs = uncertainty, VisibleLegs(facts, uncertainty)
    made: VisibleLegs = known[1]
    return made
