"""The learned policy: keeps to the plan where that can be flown, else scores the next legs."""

from __future__ import annotations

import math

import numpy as np
import numpy.typing as npt

from ...learning.next_leg.choices import Choices, Standing
from ...learning.next_leg.features import features
from ...learning.next_leg.scorer import LegScorer, shipped
from ...problem.uncertainty import Uncertainty
from .expectation import CAUTION
from .flight import Halt, Situation
from .flying_chasers import FINISHED, FlyingChaser, as_planned, beginning, full_of, refused
from .intended import Intended, PlannedHop
from .mission_facts import Hop, MissionFacts
from .replanning import AtDeviations
from .visible_legs import VisibleLegs

FloatArray = npt.NDArray[np.float64]

USUAL_LEGS = 8
"""Number of legs of a tank for which a reserve is kept where there is no plan."""


class Learned(AtDeviations):
    """Keeps to the plan as `replan` does, and chooses the next leg by a network otherwise.

    No plan is made in flight: the network sees the connections of the present body at the present
    time, what comes of the legs on average, and how the tank and the clock compare with the plan.
    A chaser does not go where it could no longer refuel, unless nothing else is left or nothing
    could be serviced afterwards.

    Parameters
    ----------
    facts : MissionFacts
    intended : Intended
    uncertainty : Uncertainty
    seed : int
        Not used: scores are not drawn.
    scorer : LegScorer, optional
        The one that comes with the package by default.
    """

    def __init__(
        self,
        facts: MissionFacts,
        intended: Intended,
        uncertainty: Uncertainty,
        seed: int = 0,
        scorer: LegScorer | None = None,
    ) -> None:
        super().__init__(facts, intended, uncertainty, seed)
        self._scorer = shipped() if scorer is None else scorer
        self._visible = visible_legs_of(facts, uncertainty)
        self._ahead = [
            _forecasts(facts, chaser, route, intended.kits[chaser])
            for chaser, route in enumerate(intended.routes)
        ]
        factor = uncertainty.legs.delta_v_factor
        self._sigma = 0.0 if factor is None else factor.lognormal_sigma

    def next_leg(self, now: Situation) -> Hop | Halt:
        """The planned leg, or the one that scores best among those that may begin."""
        craft = now.craft
        self._pass_what_is_done(now)
        route = self._routes[craft.chaser]
        if route and not self._has_changed(now) and self._is_prudent(craft, route[0].hop):
            hop = route.pop(0).hop
            self._ahead[craft.chaser].pop(0)
        else:
            found = self._best_scored(now)
            if found is None:
                return Halt(FINISHED)
            hop = found
        self._forecast[craft.chaser] = as_planned(self._facts, craft, hop)
        return hop

    def _is_prudent(self, craft: FlyingChaser, hop: Hop) -> bool:
        """Whether a planned leg leaves a way to refuel, where its service may be late."""
        return self._visible.late_s[hop.destination] == 0.0 or self._is_guarded(craft, hop)

    def _pass_what_is_done(self, now: Situation) -> None:
        """Drop planned legs to targets that are closed, and to stations that are of no use now."""
        craft, stations = now.craft, self._facts.stations
        route, ahead = self._routes[craft.chaser], self._ahead[craft.chaser]
        while route:
            j = route[0].hop.destination
            used = j < stations and (craft.since == 0 or j == craft.body)
            if not (used or j in now.closed):
                return
            route.pop(0)
            ahead.pop(0)

    def _best_scored(self, now: Situation) -> Hop | None:
        """The leg of the largest score that may begin and leaves a way to refuel, if one does."""
        facts, craft, visible = self._facts, now.craft, self._visible
        route = self._routes[craft.chaser]
        planned = [each.hop.destination for each in route]
        planned_by_others = {
            each.hop.destination
            for chaser, routed in enumerate(self._routes)
            for each in routed
            if chaser != craft.chaser
        }
        others = [each.body for each in now.chasers if each.chaser != craft.chaser]
        own = None
        if route and (route[0].origin, route[0].towed) == (craft.body, craft.towed):
            own = route[0].hop if route[0].departs(craft.free_s) else None
        choices = visible.choices(craft, now.closed, planned, planned_by_others, others, own)
        if not choices.legal.any():
            return None
        scores = self._scored(now, choices)
        unguarded: Hop | None = None
        for at in np.argsort(-scores):
            if not choices.legal[at]:
                break
            j = int(choices.bodies[at])
            is_own = own is not None and own.destination == j
            hop = own if is_own else visible.hop(craft, j, choices.arrival[at], choices.delta_v[at])
            if hop is None or refused(facts, craft, hop):
                continue
            if self._is_guarded(craft, hop):
                return hop
            unguarded = unguarded or hop
        return unguarded

    def _scored(self, now: Situation, choices: Choices) -> npt.NDArray[np.float32]:
        """Scores of legs."""
        legs, numbers = self._seen(now, choices)
        return self._scorer.scores(legs, numbers, choices.legal)

    def _seen(self, now: Situation, choices: Choices) -> tuple[FloatArray, FloatArray]:
        """What the network sees, of tanks that keep a reserve for dear legs."""
        facts, craft, visible = self._facts, now.craft, self._visible
        what, ahead = facts.chasers[craft.chaser], self._ahead[craft.chaser]
        full = full_of(what, craft.kits)
        reserve, kept = self._reserve_m_s(full), self._kept_m_s(craft, full)
        standing = Standing(
            craft.body,
            craft.free_s,
            what.limits.duration,
            craft.left - kept,
            full - reserve,
            craft.since,
            facts.stations,
            len(now.chasers),
            craft.left - kept - ahead[0].left if ahead else None,
            ahead[0].free_s - craft.free_s if ahead else None,
        )
        worths = visible.worths.copy()
        worths[list(now.closed)] = 0.0
        left = choices.left - np.where(choices.bodies < facts.stations, reserve, kept)
        choices = choices._replace(left=left)
        places, onward = visible.around.at(craft.free_s), visible.onward(craft, choices, worths)
        return features(standing, choices, onward, places, worths, visible.required)

    def _reserve_m_s(self, full: float) -> float:
        """Reserve of a full tank: that of the plan, or of usual legs without one [m/s]."""
        if self._expectation.reserve_m_s > 0.0 or not self._facts.stations:
            return min(self._expectation.reserve_m_s, 0.5 * full)
        return usual_reserve(self._sigma) * full

    def _kept_m_s(self, craft: FlyingChaser, full: float) -> float:
        """Reserve of the tank as it is now [m/s]."""
        return kept_m_s(self._reserve_m_s(full), craft.left, full)

    def _is_guarded(self, craft: FlyingChaser, hop: Hop) -> bool:
        """Whether a leg leaves a way to refuel, also if it is dear and the service long."""
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


def usual_reserve(sigma: float) -> float:
    """Share of a full tank that usual legs need besides, whose factor has a spread."""
    return min(CAUTION * sigma / math.sqrt(USUAL_LEGS), 0.5)


def kept_m_s(reserve_m_s: float, left_m_s: float, full_m_s: float) -> float:
    """What is left to keep of the reserve of a full tank: less, the fewer legs are left [m/s]."""
    if full_m_s <= 0.0:
        return 0.0
    return math.sqrt(min(max(left_m_s / full_m_s, 0.0), 1.0)) * reserve_m_s


def _forecasts(
    facts: MissionFacts, chaser: int, route: tuple[PlannedHop, ...], kits: int
) -> list[FlyingChaser]:
    """The chaser before each of its planned legs, if all goes as planned."""
    craft = beginning(facts, chaser, kits, facts.chasers[chaser].limits.ready, 1.0)
    found = []
    for each in route:
        found.append(craft)
        craft = as_planned(facts, craft, each.hop)
    return found


def visible_legs_of(facts: MissionFacts, uncertainty: Uncertainty) -> VisibleLegs:
    """What policies see of a mission, which its rehearsals share."""
    known = facts.visible_legs
    if known is None or known[0] is not uncertainty:
        known = facts.visible_legs = uncertainty, VisibleLegs(facts, uncertainty)
    made: VisibleLegs = known[1]
    return made
