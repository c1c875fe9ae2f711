"""Rehearsals flown by a policy in training, whose decisions are kept."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import numpy.typing as npt

import adr_opt
from adr_opt.analysis.rehearse.flight import Situation, rehearsed
from adr_opt.analysis.rehearse.intended import Intended, intended
from adr_opt.analysis.rehearse.learned import Learned
from adr_opt.analysis.rehearse.mission_facts import MissionFacts
from adr_opt.learning.next_leg.choices import Choices
from adr_opt.learning.next_leg.features import LEG_FEATURES
from adr_opt.learning.next_leg.scorer import LegScorer
from adr_opt.problem.instance import Instance
from adr_opt.problem.uncertainty import Uncertainty
from adr_opt.problem.world import DrawnWorld

FloatArray = npt.NDArray[np.float64]
Scores = npt.NDArray[np.float32]

SLOTS = 72
"""Legs kept of a decision: stations, and the cheapest others."""

PLAN_S = 2.0
"""Limit of plans where beams make none: for several chasers, kits and tows [s]."""


class Seen(NamedTuple):
    """A decision as the network sees it, padded to :data:`SLOTS` legs.

    Attributes
    ----------
    legs : (SLOTS, LEG_FEATURES) float32
    mission : (MISSION_FEATURES,) float32
    count : int
        Legs, all of them legal.
    bodies : (count,) int64
        Where they lead.
    """

    legs: npt.NDArray[np.float32]
    mission: npt.NDArray[np.float32]
    count: int
    bodies: npt.NDArray[np.int64]


def cheapest_first(legs: FloatArray, legal: npt.NDArray[np.bool_]) -> npt.NDArray[np.int64]:
    """The legs that are kept of a decision."""
    at = np.flatnonzero(legal)
    keys = np.where(legs[at, 0] > 0.0, -np.inf, legs[at, 5])
    order: npt.NDArray[np.int64] = at[np.argsort(keys, kind="stable")[:SLOTS]]
    return order


class Kept(NamedTuple):
    """A mission that is flown more than once, in one model of uncertainty, and its plan."""

    facts: MissionFacts
    uncertainty: Uncertainty
    intended: Intended


def kept(instance: Instance, uncertainty: Uncertainty, *, width: int = 0) -> Kept:
    """A mission, with the plan of a beam of a width if that is not 0."""
    facts = MissionFacts(instance, cores=1)
    most = tuple(0 if each.loads is None else each.loads.full.size - 1 for each in facts.chasers)
    begun = Intended(None, ((),) * len(facts.chasers), most)
    if width:
        alone = len(facts.chasers) == 1 and facts.chasers[0].loads is None
        if alone:
            plan = adr_opt.solve(instance, "beam", width=width).plan
        else:
            plan = adr_opt.solve(instance, "auto", time_limit=PLAN_S).plan
        if plan is not None:
            begun = intended(facts, plan)
    return Kept(facts, uncertainty, begun)


class InTraining(Learned):
    """The learned policy, which tells what it sees and may be made to choose otherwise.

    Parameters
    ----------
    mission : Kept
    scorer : LegScorer
    """

    def __init__(self, mission: Kept, scorer: LegScorer) -> None:
        super().__init__(mission.facts, mission.intended, mission.uncertainty, 0, scorer)
        self._network = scorer

    def _scored(self, now: Situation, choices: Choices) -> Scores:
        legs, numbers = self._seen(now, choices)
        order = cheapest_first(legs, choices.legal)
        padded = np.zeros((SLOTS, LEG_FEATURES), dtype=np.float32)
        padded[: order.size] = legs[order]
        seen = Seen(padded, numbers.astype(np.float32), order.size, choices.bodies[order])
        scores = self._network.scores(legs, numbers, choices.legal)
        scores[order] = self.chosen_by(now, seen, scores[order])
        return scores

    def chosen_by(self, now: Situation, seen: Seen, scores: Scores) -> Scores:
        """Scores by which to choose, in place of those of the network."""
        return scores


def collected(mission: Kept, policy: Learned, seed: int) -> tuple[float, float]:
    """Prizes of a rehearsal by a policy: what it collects, and that without luck of captures."""
    world = DrawnWorld(mission.facts.instance, mission.uncertainty, seed)
    done = rehearsed(mission.facts, world, policy, mission.intended.kits)
    return done.prize, done.expected
