"""Incumbent and bound of a proof under way, and what to ask for next."""

from __future__ import annotations

import math
import threading
from collections.abc import Iterable
from typing import Any, Generic, Protocol, TypeVar

from adr_opt.common.progress import Progress
from adr_opt.common.tolerance import rounded_up
from adr_opt.mission.evidence import Evidence
from adr_opt.mission.prizes import Prizes
from adr_opt.mission.problem import Mission

from .incumbent import Incumbent

STRIDE = 0.01
"""Ask for a plan worth so much less than the bound (relative)."""


Found = TypeVar("Found", bound=Iterable[Any])


class Best(Protocol[Found]):
    """The best plan that was offered."""

    sequence: Found | None
    objective: float
    cost: float

    def offer(self, sequence: Any) -> bool:
        """A plan that may be the best one; whether it is."""
        ...


class CertificateOf(Generic[Found]):
    """Incumbent and bound, and who is told of them.

    Parameters
    ----------
    problem : Mission or Campaign
    progress : Progress
    best : Best
        Compares plans.
    """

    def __init__(self, problem: Prizes, progress: Progress, best: Best[Found]) -> None:
        self._mission = problem
        self._progress = progress
        self._telling = threading.RLock()
        self._told = (-math.inf, math.inf)
        self._best = best
        self.bound = math.inf
        self.evidence: Evidence | None = None
        self.lower(problem.total_worth)

    @property
    def sequence(self) -> Found | None:
        """The best plan; None before the first."""
        return self._best.sequence

    @property
    def incumbent(self) -> float:
        """What it is worth; −inf before the first."""
        return self._best.objective

    @property
    def cost(self) -> float:
        """What it costs; +inf before the first."""
        return self._best.cost

    def offer(self, sequence: Iterable[Any]) -> bool:
        """What may be the best plan so far; whether it is: see :class:`Incumbent`."""
        before = self.incumbent
        better = self._best.offer(sequence)
        if self.incumbent > before:
            self.tell(self.incumbent, self.bound)
        return better

    def tell(self, incumbent: float, bound: float) -> None:
        """Report what was found here, or elsewhere and is still to be offered here.

        Two threads may tell at once, and neither knows all that the other has told; what is heard
        never gets worse all the same.
        """
        with self._telling:
            told = (max(incumbent, self._told[0]), min(bound, self._told[1]))
            if told != self._told:
                self._told = told
                self._progress(*told)

    def lower(self, bound: float, evidence: Evidence | None = None) -> None:
        """A bound that was proven, rounded down to the step of the prizes; −inf for no plan.

        What it rests on is kept; where nobody can tell, that of the last bound of which it is
        known.
        """
        bound = max(self._mission.rounded_down(bound), self.incumbent)
        if bound < 0.0:
            bound = -math.inf  # every plan is worth at least nothing, so there is none
        if bound < self.bound:
            self.bound = bound
            self.evidence = evidence or self.evidence
            self.tell(self.incumbent, self.bound)

    @property
    def proven(self) -> bool:
        """Whether the incumbent meets the bound, or no plan has all that is required."""
        none = self._mission.shown(self.bound) == -math.inf
        return none or self._mission.meets(self.incumbent, self.bound)

    @property
    def stated(self) -> float:
        """The bound if it says more than that nothing beyond all prizes is collected, else +inf.

        No more is collected than the largest prizes of as many targets as may be serviced.
        """
        problem = self._mission
        bound = min(self.bound, problem.total_worth)
        says = bound < problem.all_worth or problem.shown(bound) < problem.all_prize
        return bound if says else math.inf

    @property
    def goal(self) -> float:
        """What the next plan has to be worth to be better."""
        return self.incumbent + (self._mission.prize_step or self._mission.prize_resolution)

    @property
    def next_goal(self) -> float:
        """The same, but half of it where prizes have no step, so that none is within tolerance."""
        return self.goal if self._mission.prize_step else 0.5 * (self.incumbent + self.goal)

    def below(self, goal: float) -> float:
        """What no plan is worth more than if none is worth :attr:`next_goal`."""
        return self.incumbent if self._mission.prize_step else goal

    @property
    def threshold(self) -> float:
        """What to ask for next: more than the incumbent, at most the bound."""
        step = self._mission.prize_step
        value = min(self.bound, rounded_up((1.0 - STRIDE) * self.bound, step))
        if step:
            return max(value, self.incumbent + step) - self._mission.step_margin * step
        return max(value, self.incumbent + 0.5 * self._mission.prize_resolution)


class GapTracker(CertificateOf[tuple[int, ...]]):
    """Incumbent and bound of one chaser's mission, and who is told of them."""

    def __init__(self, mission: Mission, progress: Progress) -> None:
        super().__init__(mission, progress, Incumbent(mission))
