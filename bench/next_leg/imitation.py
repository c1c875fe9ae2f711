"""Flights whose decisions are judged: what is imitated."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from adr_opt.analysis.rehearse.flight import Situation
from adr_opt.learning.next_leg.scorer import LegScorer

from . import flights
from .drawn import drawn_instance, drawn_uncertainty
from .flights import SLOTS, InTraining, Kept, Scores, Seen
from .judging import PLAN_WIDTH, Judge
from .rivals import CheapestLegs

TRIED = 5
"""Moves judged by cost, and again as many by the present scores."""

PLANNED = 0.4
"""Share of missions that begin with a plan."""

MOST_PLANNED = 100
"""Number of targets up to which missions have a plan."""

WORLDS = 3
"""Number of worlds in which each mission is flown."""

LABELLED, ASTRAY = 0.5, 0.1
"""Shares of decisions that are judged, and of moves that are drawn."""

BY_JUDGE = 0.4
"""Share of judged decisions, once there is a policy, in which the best move is made."""


class Decision(NamedTuple):
    """A judged decision.

    Attributes
    ----------
    seen : Seen
    worth : (SLOTS,) float32
        Of each leg with what follows, over the mean prize; NaN where it was not judged.
    """

    seen: Seen
    worth: npt.NDArray[np.float32]


class Judged(InTraining):
    """The policy of the last round, which goes astray now and then, and whose moves are judged."""

    def __init__(
        self, mission: Kept, scorer: LegScorer | None, judge: Judge, rng: np.random.Generator
    ) -> None:
        super().__init__(mission, scorer or CheapestLegs())  # type: ignore[arg-type]
        self._is_first, self._judge, self._rng = scorer is None, judge, rng
        self.decisions: list[Decision] = []

    def chosen_by(self, now: Situation, seen: Seen, scores: Scores) -> Scores:
        """Scores of the policy, or such that a judged or a drawn move is the best."""
        rng, chosen = self._rng, scores.copy()
        if seen.count > 1 and rng.random() < LABELLED:
            worth = self._worths(now, seen, scores)
            if np.isfinite(worth).any():
                self.decisions.append(Decision(seen, worth))
                if self._is_first or rng.random() < BY_JUDGE:
                    chosen[np.nanargmax(worth[: seen.count])] = np.inf
        if rng.random() < ASTRAY:
            chosen[rng.integers(0, min(6, seen.count))] = np.inf
        return chosen

    def _worths(self, now: Situation, seen: Seen, scores: Scores) -> npt.NDArray[np.float32]:
        chaser = now.craft.chaser
        tried = set(np.flatnonzero((seen.legs[:, 0] > 0.0) | (seen.legs[:, 21] > 0.0)).tolist())
        tried |= set(np.flatnonzero(seen.legs[: seen.count, 0] == 0.0)[:TRIED].tolist())
        tried |= set(np.argsort(-scores)[:TRIED].tolist())
        at = np.array(sorted(tried))
        theirs = {
            each.hop.destination
            for other, route in enumerate(self._routes)
            for each in route
            if other != chaser and each.hop.destination >= self._facts.stations
        }
        worth = np.full(SLOTS, np.nan, dtype=np.float32)
        worth[at] = self._judge.worths(now.craft, now.closed | theirs, seen.bodies[at])
        # A target to which another one plans to go adds nothing.
        taken = at[np.isin(seen.bodies[at], list(theirs))]
        if taken.size and np.isfinite(worth).any():
            worth[taken] = np.nanmax(worth) - 1.0
        return worth


class Gathered(NamedTuple):
    """Judged decisions, and how many of the missions were proven."""

    decisions: list[Decision]
    missions: int
    proven: int


def gathered(
    wanted: int, variant: str, rng: np.random.Generator, scorer: LegScorer | None
) -> Gathered:
    """At least as many judged decisions as are wanted, of drawn missions in drawn worlds."""
    found: list[Decision] = []
    missions = proven = 0
    while len(found) < wanted:
        instance = drawn_instance(rng, variant, dense=False)
        uncertainty = drawn_uncertainty(rng)
        with_plan = len(instance.targets) <= MOST_PLANNED and rng.random() < PLANNED
        mission = flights.kept(instance, uncertainty, width=PLAN_WIDTH if with_plan else 0)
        seed = int(rng.integers(2**31))
        routes = [[each.hop.destination for each in route] for route in mission.intended.routes]
        judge = Judge(mission.facts, uncertainty, seed, routes)
        missions, proven = missions + 1, proven + judge.is_proven
        for world in range(WORLDS):
            policy = Judged(mission, scorer, judge, rng)
            flights.collected(mission, policy, seed + world)
            found += policy.decisions
    return Gathered(found, missions, proven)
