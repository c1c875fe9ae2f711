"""Policies to compare with: guarded greedy and beams on demand, asked anew for every leg."""

from __future__ import annotations

from collections.abc import Callable
from typing import ClassVar

import numpy as np
import numpy.typing as npt

from adr_opt.analysis.rehearse.flight import Halt, Situation
from adr_opt.analysis.rehearse.flying_chasers import FINISHED, full_of, refused
from adr_opt.analysis.rehearse.learned import kept_m_s
from adr_opt.analysis.rehearse.mission_facts import Hop, MissionFacts
from adr_opt.kernels.rules import rules as rule_kernels
from adr_opt.legs.nearest_pairs import neighbours
from adr_opt.mission.mission import Mission
from adr_opt.run.table_budget import RANKS
from solvers.beams.greedy_order import GUARDED_BETA, MoveCost, greedy_next

from .asked import beam_from, state_of

FloatArray = npt.NDArray[np.float64]
Chooser = Callable[[Mission, rule_kernels.State, npt.NDArray[np.bool_]], int]
"""The next body from a state with targets that are done; −1 for none."""


def on_demand(ground: MissionFacts, ranks: int = RANKS) -> Mission:
    """The mission of the only chaser, with connections computed on demand as planners do."""
    mission = Mission(ground.instance, connecting=ground.finder)
    mission.ask(neighbours(ground.instance, ranks))
    return mission


def guarded_next(mission: Mission, state: rule_kernels.State, done: npt.NDArray[np.bool_]) -> int:
    """The choice of the planner ``greedy-guarded``."""
    costs = MoveCost(1.0, GUARDED_BETA * mission.instance.hurry)
    return int(
        greedy_next(mission.rules, mission.is_required, state, done, costs, True, False, False)
    )


def beam_next(width: int) -> Chooser:
    """The first leg of the plan of a beam of a width."""

    def chosen(mission: Mission, state: rule_kernels.State, done: npt.NDArray[np.bool_]) -> int:
        found = beam_from(mission, state, done, width)[0]
        return int(found[0]) if found.size else -1

    return chosen


class AskedAnew:
    """A policy that asks a planner for the next leg, of tanks with a reserve for dear legs.

    Parameters
    ----------
    ground : MissionFacts
    mission : Mission
    chooser : callable
    reserve : float
        Share of a full tank.
    """

    def __init__(
        self, ground: MissionFacts, mission: Mission, chooser: Chooser, reserve: float
    ) -> None:
        self._ground, self._mission, self._chooser = ground, mission, chooser
        self._reserve = reserve

    def next_leg(self, now: Situation) -> Hop | Halt:
        """The leg that the planner begins with; without the reserve if there is none."""
        craft, ground = now.craft, self._ground
        full = full_of(ground.chasers[craft.chaser], craft.kits)
        done = np.zeros(len(ground.names), dtype=np.bool_)
        done[list(now.closed)] = True
        kept = kept_m_s(self._reserve * full, craft.left, full)
        for left in {craft.left - kept: None, craft.left: None}:
            state = state_of(craft, left)
            j = self._chooser(self._mission, state, done)
            hop = None if j < 0 else ground.best(craft.body, j, craft.free_s, towed=craft.towed)
            if hop is not None and not refused(ground, craft, hop):
                return hop
        return Halt(FINISHED)

    def tries_again(self, now: Situation, target: int, tries: int) -> bool:
        """As often as it is allowed."""
        return True


class CheapestLegs:
    """In place of the network: the cheapest leg by hours and ΔV, or a station if there is none."""

    facts: ClassVar[dict[str, object]] = {}

    def scores(
        self, legs: FloatArray, mission: FloatArray, legal: npt.NDArray[np.bool_]
    ) -> npt.NDArray[np.float32]:
        """Scores of legs, −inf of those that are not legal."""
        cost = np.where(legal, -legs[:, 5] - 1e3 * legs[:, 0], -np.inf)
        return cost.astype(np.float32)
