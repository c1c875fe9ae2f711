"""Policies to compare with: guarded greedy and beams on demand, asked anew for every leg."""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np
import numpy.typing as npt

from adr_opt.analysis.rehearse.crafts import FINISHED, full_of, refused
from adr_opt.analysis.rehearse.flight import Halt, Situation
from adr_opt.analysis.rehearse.ground import Ground, Hop
from adr_opt.kernels.core.compile import kernel
from adr_opt.kernels.core.memory import borrowed
from adr_opt.kernels.rules import rules as rule_kernels
from adr_opt.kernels.rules.resources import Resources
from adr_opt.legs.nearest_pairs import neighbours
from adr_opt.mission.mission import Mission
from adr_opt.run.table_budget import RANKS
from solvers.beams.beams import beam_kernel, usual_settings
from solvers.beams.greedy_order import GUARDED_BETA
from solvers.beams.levels import Weights
from solvers.walks.completion_times import no_latest

Chooser = Callable[[Mission, rule_kernels.State, npt.NDArray[np.bool_]], int]
"""The next body from a state with targets that are done; −1 for none."""


def on_demand(ground: Ground, ranks: int = RANKS) -> Mission:
    """The mission of the only chaser, with connections computed on demand as planners do."""
    mission = Mission(ground.instance, connecting=ground.finder)
    mission.ask(neighbours(ground.instance, ranks))
    return mission


@kernel
def _greedy_next(rules, state, done, beta):
    """The cheapest legal target after which the chaser can refuel, else a station, else any."""
    rules = borrowed(rules)
    best, best_cost, safe, safe_cost, station, station_cost = -1, 1e300, -1, 1e300, -1, 1e300
    for place in range(rule_kernels.looked_at(rules)):
        j = rule_kernels.destination(rules, state.body, state.resources.time, place)
        if not rule_kernels.may_go(rules, state, done, j):
            continue
        legal, delta_v, after = rule_kernels.step(rules, state, j)
        if not legal:
            continue
        cost = delta_v + beta * (after.resources.time - rules.service[j] - state.resources.time)
        if j < rules.stations:
            if cost < station_cost:
                station, station_cost = j, cost
            continue
        if cost < best_cost:
            best, best_cost = j, cost
        if cost < safe_cost and rule_kernels.has_way_back(rules, after):
            safe, safe_cost = j, cost
    if safe >= 0:
        return safe
    return best if station < 0 else station


def greedy_next(mission: Mission, state: rule_kernels.State, done: npt.NDArray[np.bool_]) -> int:
    """The choice of the planner ``greedy-guarded``."""
    return int(_greedy_next(mission.rules, state, done, GUARDED_BETA * mission.instance.hurry))


def beam_next(width: int) -> Chooser:
    """The first leg of the plan of a beam of a width."""

    def chosen(mission: Mission, state: rule_kernels.State, done: npt.NDArray[np.bool_]) -> int:
        usual, has = usual_settings(mission, width), state.resources
        weights = Weights(
            width, usual.time_weight / 3600.0, usual.delta_v_weight / 1000.0, usual.crowding, 0.0,
            usual.guarded, 0,
        )  # fmt: skip
        first = (
            int(state.body), int(has.since), np.array([has.kits]), np.array([has.time]),
            np.array([has.left]), np.zeros(1), np.zeros(1),
        )  # fmt: skip
        halt = np.zeros(1, dtype=np.bool_)
        found = beam_kernel(
            mission.rules, done.copy(), first, no_latest(), False, weights, halt
        )[0]  # fmt: skip
        return int(found[0]) if found.size else -1

    return chosen


class AskedAnew:
    """A policy that asks a planner for the next leg, of tanks with a reserve for dear legs.

    Parameters
    ----------
    ground : Ground
    mission : Mission
    chooser : callable
    reserve : float
        Share of a full tank.
    """

    def __init__(self, ground: Ground, mission: Mission, chooser: Chooser, reserve: float) -> None:
        self._ground, self._mission, self._chooser = ground, mission, chooser
        self._reserve = reserve

    def next_leg(self, now: Situation) -> Hop | Halt:
        """The leg that the planner begins with; without the reserve if there is none."""
        craft, ground = now.craft, self._ground
        full = full_of(ground.chasers[craft.chaser], craft.kits)
        done = np.zeros(len(ground.names), dtype=np.bool_)
        done[list(now.closed)] = True
        kept = self._reserve * full * math.sqrt(max(craft.left, 0.0) / full)
        for left in {craft.left - kept: None, craft.left: None}:
            has = Resources(
                craft.free_s, left, np.int64(craft.since), np.int64(craft.serviced),
                np.int64(craft.kits),
            )  # fmt: skip
            state = rule_kernels.State(np.int64(craft.body), has)
            j = self._chooser(self._mission, state, done)
            hop = None if j < 0 else ground.best(craft.body, j, craft.free_s, towed=craft.towed)
            if hop is not None and not refused(ground, craft, hop):
                return hop
        return Halt(FINISHED)

    def tries_again(self, now: Situation, target: int, tries: int) -> bool:
        """As often as it is allowed."""
        return True
