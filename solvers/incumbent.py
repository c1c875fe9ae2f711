"""The best plan so far: the one place where plans are compared (MODEL section 5)."""

from __future__ import annotations

import math
from collections.abc import Iterable

from adr_opt.mission import Mission


class Incumbent:
    """The best plan that was offered: most prize, then least cost.

    Parameters
    ----------
    mission : Mission

    Attributes
    ----------
    sequence : tuple of int or None
        Bodies in order; None before the first plan.
    objective : float
        Prizes, −inf before the first plan.
    cost : float
        What the plan costs at its best schedule, +inf before the first plan.
    """

    def __init__(self, mission: Mission) -> None:
        self._mission = mission
        self.sequence: tuple[int, ...] | None = None
        self.objective = -math.inf
        self.cost = math.inf

    def offer(self, sequence: Iterable[int]) -> bool:
        """A sequence that may be the best plan; whether it is.

        It is closed first (:meth:`adr_opt.mission.Mission.closed`). What cannot be flown to its
        end, or may not end there, is no plan.
        """
        mission = self._mission
        moves = tuple(int(j) for j in sequence)
        prizes = mission.collected(moves)
        if prizes < self.objective or moves == self.sequence:
            return False
        if prizes == self.objective and mission.schedules.least_cost(moves) >= self.cost:
            return False
        moves = mission.closed(moves)
        schedule = mission.time(moves)
        if schedule.made < len(moves) or not mission.may_stop(moves):
            return False
        if prizes == self.objective and schedule.cost >= self.cost:
            return False
        self.sequence, self.objective, self.cost = moves, prizes, schedule.cost
        return True
