"""Incumbent and bound of a proof, and who is told of them."""

from __future__ import annotations

import math
from collections.abc import Iterable

from adr_opt.mission import Mission
from adr_opt.planner import Progress
from adr_opt.stop import Stop
from adr_opt.tolerance import meets, rounded_down, rounded_up, tolerance

STRIDE = 0.01
"""A goal is at most so much below the bound (relative)."""


class Standing:
    """What is known of the best plan.

    Parameters
    ----------
    mission : Mission
    stop, progress

    Attributes
    ----------
    sequence : tuple of int or None
        The best plan.
    incumbent, bound : float
    step : float
        All objectives are multiples of it; 0 where there is none.
    """

    def __init__(self, mission: Mission, stop: Stop, progress: Progress) -> None:
        self._mission = mission
        self._stop = stop
        self._progress = progress
        self._ended = False
        self.sequence: tuple[int, ...] | None = None
        self.incumbent = -math.inf
        self.bound = math.inf
        self.step = mission.prize_step
        self.lower(mission.total_prize)

    def offer(self, sequence: Iterable[int]) -> None:
        """A sequence whose legal beginning may be the best plan so far."""
        moves = tuple(int(j) for j in sequence)
        timing = self._mission.time(moves)
        if timing.objective > self.incumbent:
            self.incumbent, self.sequence = timing.objective, moves[: timing.made]
            self._progress(self.incumbent, self.bound)

    def lower(self, bound: float) -> None:
        """A bound that was proven, rounded down to a multiple of the step."""
        bound = max(rounded_down(bound, self.step), self.incumbent)
        if bound < self.bound:
            self.bound = bound
            self._progress(self.incumbent, self.bound)

    @property
    def proven(self) -> bool:
        """Whether the incumbent meets the bound."""
        return meets(self.incumbent, self.bound)

    def enough(self) -> bool:
        """Asks ``stop``, once per iteration."""
        self._ended = self._ended or self.proven or self._stop(self.incumbent, self.bound)
        return self._ended

    def remaining_s(self) -> float:
        """Seconds that may still be used."""
        return 0.0 if self._ended else self._stop.remaining_s()

    @property
    def goal(self) -> float:
        """What to ask for next: more than the incumbent, at most the bound."""
        aim = rounded_up((1.0 - STRIDE) * self.bound, self.step)
        if self.step:
            return min(self.bound, max(aim, self.incumbent + self.step))
        return max(aim, self.incumbent + 0.5 * tolerance(self.bound))

    def under(self, goal: float) -> float:
        """The most that a plan can be worth which is worth less than a goal."""
        return goal - self.step
