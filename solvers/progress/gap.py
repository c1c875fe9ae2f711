"""Incumbent and bound of a running proof, and its next goal."""

from __future__ import annotations

import math
import threading
from collections.abc import Iterable, Mapping
from dataclasses import replace

import numpy as np

from adr_opt.common.clock import now_s
from adr_opt.common.progress import Progress, show_plan
from adr_opt.common.tolerance import rounded_up
from adr_opt.mission.certified import certify_routes
from adr_opt.mission.evidence import USUAL_SLOT_M_S, CostEvidence, Evidence
from adr_opt.mission.mission import Mission
from adr_opt.mission.problem import Problem, Routes, problem_of
from adr_opt.mission.result import Result

from .incumbent import Incumbent

STRIDE = 0.01
"""Distance of the next goal below the bound (relative)."""


class GapTracker:
    """Incumbent and bound of a problem, with progress reports and the final result.

    Parameters
    ----------
    problem : Problem or Mission
    progress : Progress
    """

    def __init__(self, problem: Problem | Mission, progress: Progress) -> None:
        self._began = now_s()
        self._problem = problem_of(problem)
        self._progress = progress
        self._telling = threading.RLock()
        self._told = (-math.inf, math.inf)
        self._best = Incumbent(self._problem)
        self.bound = math.inf
        self.evidence: Evidence | None = None
        self.cost_evidence: CostEvidence | None = None
        self.lower(self._problem.total_worth)

    @property
    def routes(self) -> Routes | None:
        """The best plan: bodies in order for each chaser; None before the first one."""
        return self._best.routes

    @property
    def sequence(self) -> tuple[int, ...] | None:
        """Route of the only chaser in the best plan; None before the first one."""
        return self._best.sequence

    @property
    def incumbent(self) -> float:
        """Worth of the best plan; −inf before the first one."""
        return self._best.objective

    @property
    def cost(self) -> float:
        """Cost of the best plan; +inf before the first one."""
        return self._best.cost

    def offer(self, *routes: Iterable[int]) -> bool:
        """Offer a plan; returns whether it is the best so far: see :class:`Incumbent`."""
        before = self.incumbent
        better = self._best.offer(*routes)
        if better and self.routes is not None:
            show_plan(self._progress, *self.routes)
        if self.incumbent > before:
            self.tell(self.incumbent, self.bound)
        return better

    def tell(self, incumbent: float, bound: float) -> None:
        """Report an incumbent or a bound, possibly found elsewhere.

        Two threads may tell at once, and neither knows all that the other has told; what is heard
        never gets worse all the same.
        """
        with self._telling:
            told = (max(incumbent, self._told[0]), min(bound, self._told[1]))
            if told != self._told:
                self._told = told
                self._progress(*told)

    def lower(self, bound: float, evidence: Evidence | None = None) -> None:
        """Lower the bound, rounded down to the step of the prizes; −inf if there is no plan.

        The evidence is kept; without any, that of the last bound with evidence.
        """
        bound = max(self._problem.rounded_down(bound), self.incumbent)
        if bound < 0.0:
            bound = -math.inf  # every plan is worth at least nothing, so there is none
        if bound < self.bound:
            self.bound = bound
            self.evidence = evidence or self.evidence
            self.tell(self.incumbent, self.bound)

    def result(
        self,
        method: str,
        *,
        seed: int,
        counters: Mapping[str, float],
        upper_bound: float | None = None,
        cost_bound: float | None = None,
        notes: Iterable[str] = (),
        otherwise: Routes | None = None,
    ) -> Result:
        """The best plan and the bound as a method's result, with the evidence.

        Parameters
        ----------
        method : str
        seed : int
        counters, notes
            As in :class:`adr_opt.mission.result.Result`.
        upper_bound : float, optional
            What to state; :attr:`bound` by default.
        cost_bound : float, optional
            As :func:`adr_opt.mission.certified.certify` takes it.
        otherwise : tuple of tuple of int, optional
            The routes where there is no plan; none by default.
        """
        return certify_routes(
            self._problem,
            method,
            otherwise if self.routes is None else self.routes,
            seed=seed,
            runtime_s=now_s() - self._began,
            upper_bound=self.bound if upper_bound is None else upper_bound,
            cost_bound=cost_bound,
            evidence=self._stated_evidence(),
            counters=counters,
            notes=notes,
        )

    def _stated_evidence(self) -> Evidence | None:
        """The evidence with that of the cost."""
        if self.cost_evidence is None:
            return self.evidence
        # Where all prizes are collected they are no question, and their bound has no evidence.
        bodies = len(self._problem.planning_prizes)
        evidence = self.evidence or Evidence(np.zeros(bodies), (), USUAL_SLOT_M_S)
        return replace(evidence, cost=self.cost_evidence)

    @property
    def proven(self) -> bool:
        """Whether the incumbent meets the bound, or no plan has all required targets."""
        none = self._problem.shown(self.bound) == -math.inf
        return none or self._problem.meets(self.incumbent, self.bound)

    @property
    def stated(self) -> float:
        """The bound if it is less than the sum of all prizes, else +inf.

        No more is collected than the largest prizes of as many targets as may be serviced.
        """
        problem = self._problem
        bound = min(self.bound, problem.total_worth)
        says = bound < problem.all_worth or problem.shown(bound) < problem.all_prize
        return bound if says else math.inf

    @property
    def goal(self) -> float:
        """Least worth of a better plan."""
        return self.incumbent + (self._problem.prize_step or self._problem.prize_resolution)

    @property
    def next_goal(self) -> float:
        """Least worth of a better plan, halved without a step so that none is within tolerance."""
        return self.goal if self._problem.prize_step else 0.5 * (self.incumbent + self.goal)

    def below(self, goal: float) -> float:
        """Upper bound if no plan reaches :attr:`next_goal`."""
        return self.incumbent if self._problem.prize_step else goal

    @property
    def threshold(self) -> float:
        """Threshold of the next search: above the incumbent, at most the bound."""
        step = self._problem.prize_step
        value = min(self.bound, rounded_up((1.0 - STRIDE) * self.bound, step))
        if step:
            return max(value, self.incumbent + step) - self._problem.step_margin * step
        return max(value, self.incumbent + 0.5 * self._problem.prize_resolution)
