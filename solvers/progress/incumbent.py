"""The best plan so far: the one place where plans are compared (docs/model.md section 5)."""

from __future__ import annotations

import math
from collections.abc import Iterable

import numpy as np

from adr_opt.kernels.rules import rules as rule_kernels
from adr_opt.mission.problem import Mission


class Incumbent:
    """The best plan that was offered: most prize, then least cost.

    Parameters
    ----------
    mission : Mission
    by_choice : bool
        Cost is that of the connections that the mission's choice makes, for planners that come by
        plans more quickly than by their best schedules.

    Attributes
    ----------
    sequence : tuple of int or None
        Bodies in order; None before the first plan.
    objective : float
        Prizes, −inf before the first plan.
    cost : float
        What the plan costs at its best schedule, or by choice; +inf before the first plan.
    """

    def __init__(self, mission: Mission, *, by_choice: bool = False) -> None:
        self._mission = mission
        self._by_choice = by_choice
        self.sequence: tuple[int, ...] | None = None
        self.objective = -math.inf
        self.cost = math.inf

    def offer(self, sequence: Iterable[int]) -> bool:
        """A sequence that may be the best plan; whether it is.

        It is closed first (:meth:`adr_opt.mission.problem.Mission.closed`). What cannot be flown to
        its end, or may not end there, is no plan.
        """
        mission = self._mission
        moves = tuple(int(j) for j in sequence)
        prizes = mission.collected(moves)
        if prizes < self.objective or moves == self.sequence:
            return False
        tie = prizes == self.objective
        if tie and not self._by_choice and mission.schedules.least_cost(moves) >= self.cost:
            return False
        moves = mission.closed(moves)
        cost = self._cost_of(moves) if mission.may_stop(moves) else math.inf
        if cost == math.inf or (tie and cost >= self.cost):
            return False
        self.sequence, self.objective, self.cost = moves, prizes, cost
        return True

    def _cost_of(self, moves: tuple[int, ...]) -> float:
        """What a sequence costs; +inf if it cannot be flown to its end."""
        mission = self._mission
        if not self._by_choice:
            schedule = mission.time(moves)
            return schedule.cost if schedule.made == len(moves) else math.inf
        rules = mission.rules
        made, delta_v, state = rule_kernels.replay(
            rules,
            np.array(moves, dtype=np.int64),
            rule_kernels.beginning(rules),
            np.zeros(rules.service.size, dtype=np.bool_),
            *np.empty((2, len(moves))),
        )
        if made < len(moves):
            return math.inf
        if mission.instance.objective.cost == "duration":
            return float(state.time)
        paid = mission.instance.time_m_s_per_s * (state.time - rules.ready)
        return float(delta_v + paid) if made else 0.0
