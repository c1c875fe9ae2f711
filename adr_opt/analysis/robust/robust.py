"""Robust plans, which hold with a required confidence (docs/model.md section 13.4).

All tanks together hold what their legs take, and each stay and each launch is in time, with that
confidence; and so much of the plan is kept when it is followed in drawn worlds, where one delay
leads to others. How likely each part has to be kept depends on how many there are. A first plan
keeps each of them with the confidence itself, as every plan does that keeps its promise: what is
proven of it is proven of all. The next ones share out the risk, and take back what turns out not to
be needed.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass, replace
from typing import Any

from ...common.clock import now_s
from ...common.errors import InputError
from ...common.progress import Progress, silent
from ...common.stop import Stop
from ...common.tolerance import RELATIVE
from ...mission.problem import Problem
from ...mission.result import Result
from ...plan.plan import Plan
from ...problem.instance import AnyInstance, Instance
from ...problem.support import followed
from ...problem.uncertainty import Uncertainty
from ...run.front import DEFAULT_METHOD, DEFAULT_TIME_LIMIT_S, RunOptions, run, spec_of
from ...run.methods import PLANNERS
from ..rehearse.intended import Intended, intended
from ..rehearse.mission_facts import PROMISED, MissionFacts
from ..rehearse.sampling import Setting, flown_in
from ..rehearse.tries import common_share, mean_worths
from .careful_problem import Levels, as_it_is, between, careful_problem, equal, is_bounded, shared
from .promise import Promise, promise_of
from .robust_plan import Caution, RobustPlan

FIRST_SHARE = 0.4
"""Share of the time for the first plan and the bound on all."""

MOST_ROUNDS = 6
"""Maximum number of plans after the first."""

WORLDS, FIRST_WORLD = 1000, 10**9
"""Number of worlds in which a plan is followed, and their first seed, far from those of users."""

NEAR = 0.1
"""Difference of two levels of caution below which none between them is tried."""


def robust(  # noqa: PLR0913
    instance: AnyInstance,
    uncertainty: Uncertainty,
    confidence: float,
    method: str = DEFAULT_METHOD,
    *,
    time_limit: float = DEFAULT_TIME_LIMIT_S,
    seed: int = 0,
    bound: str | None = None,
    jobs: int | None = None,
    stop: Stop | None = None,
    progress: Progress = silent,
    **method_options: Any,
) -> RobustPlan:
    """Plan a mission so that the plan holds with a confidence.

    Parameters
    ----------
    instance : Instance, path or dict
    uncertainty : Uncertainty
        What may deviate from the plan.
    confidence : float
        Required probability, at least 0.5 and less than 1: that all tanks suffice, that the next
        leg departs in time after each stay or launch, and that the plan is kept when it is
        followed.
    method : str
        Name of an installed planner.
    time_limit : float
        Wall time of all plans together [s].
    seed, bound, jobs, **method_options
        As :func:`adr_opt.solve` takes them.
    stop : Stop, optional
        A further criterion.
    progress : callable
        Called with worth and bound of the first plan whenever one improves.

    Returns
    -------
    RobustPlan

    Raises
    ------
    InputError
        The confidence is out of range, the mission has a rule that rehearsals do not follow, or as
        :func:`adr_opt.solve` raises it.
    """
    if not 0.5 <= confidence < 1.0:
        raise InputError(f"confidence = {confidence!r}: must be at least 0.5 and below 1")
    instance = followed(instance, PROMISED)
    uncertainty = uncertainty.of(instance)
    wanted = RunOptions(time_limit, seed, None, jobs=jobs, bound=bound, options=method_options)
    return _Search(instance, uncertainty, confidence, method, wanted, stop).run(progress)


@dataclass(frozen=True)
class _Made:
    """A plan of the instance, with its worth and its promise."""

    plan: Plan
    worth: float
    promise: Promise
    kept: float

    @property
    def rank(self) -> tuple[float, float]:
        """Rank of a plan: by worth, then by less ΔV."""
        return self.worth, -self.plan.delta_v_m_s


class _Search:
    """The search for the levels at which the best plan keeps its promise."""

    def __init__(
        self,
        instance: Instance,
        uncertainty: Uncertainty,
        confidence: float,
        method: str,
        wanted: RunOptions,
        stop: Stop | None,
    ) -> None:
        self._facts = MissionFacts(instance)
        self._uncertainty, self._confidence = uncertainty, confidence
        self._method, self._wanted, self._stop = method, wanted, stop
        self._began = now_s()
        self._end = self._began + wanted.time_limit
        self._is_bounded = is_bounded(self._facts, uncertainty)
        self._whole = Problem(instance, connecting=self._facts.finder)
        self._worths = mean_worths(instance, uncertainty)
        # Prizes are planned with where all targets are worth as much of theirs.
        share = common_share(instance, uncertainty)
        self._share = 1.0 if share is None else share
        self._prizes = {target.name: target.prize for target in instance.targets}
        self._rounds: list[Caution] = []
        self._best: _Made | None = None

    def run(self, progress: Progress) -> RobustPlan:
        """Plan first for a bound on all plans, then with shared risks."""
        first = equal(self._confidence)
        result = self._result(first, FIRST_SHARE * self._wanted.time_limit, progress)
        upper = self._bound(result)
        made = self._adopt(first, result)
        if self._best is not None and not self._is_over(upper):
            # Nothing is gained by other levels: the same ones, with the rest of the time.
            longer = self._result(first, self._end - now_s(), progress, result.plan)
            upper = min(upper, self._bound(longer))
            self._adopt(first, longer)
        elif made is not None:
            for levels in self._cautions(first, made.promise):
                if self._is_over(upper):
                    break
                last = len(self._rounds) == MOST_ROUNDS
                limit_s = (self._end - now_s()) * (1.0 if last else 0.4)
                try:
                    self._adopt(levels, self._result(levels, limit_s, silent))
                except InputError:  # no tank holds anything, or no stay ends, with such a chance
                    self._rounds.append(Caution(levels, -math.inf, 0.0))
        best = self._best
        return RobustPlan(
            plan=None if best is None else best.plan,
            promise=None if best is None else best.promise,
            confidence=self._confidence,
            worth=-math.inf if best is None else self._share * best.worth,
            upper_bound=self._share * upper if math.isfinite(upper) else upper,
            infeasible=result.status == "infeasible" and self._is_bounded,
            kept=0.0 if best is None else best.kept,
            worlds=WORLDS,
            rounds=tuple(self._rounds),
            method=self._method,
            seed=self._wanted.seed,
            runtime_s=now_s() - self._began,
        )

    def _cautions(self, first: Levels, promise: Promise) -> Iterator[Levels]:
        """Levels to plan with: shared risks, more caution until a plan holds, then less."""
        full = shared(self._confidence, promise)
        low, high, caution = 0.0, math.inf, 1.0
        for _ in range(MOST_ROUNDS):
            yield between(first, full, caution)
            last = self._rounds[-1]
            if last.kept >= self._confidence or last.worth == -math.inf:
                high = caution
            else:
                low = caution
            if high - low < NEAR:
                return
            caution = 1.3 * caution if high == math.inf else 0.5 * (low + high)

    def _bound(self, result: Result) -> float:
        """Bound by a result on all plans that hold."""
        return result.upper_bound if self._is_bounded else math.inf

    def _is_over(self, upper: float) -> bool:
        """Whether no time is left, or nothing can be gained."""
        if self._end - now_s() <= 0.0 or (
            self._stop is not None and self._stop.remaining_s() <= 0.0
        ):
            return True
        if self._best is None:
            return False
        # Mean worths have no steps to which bounds could be rounded.
        return (
            self._best.worth >= upper - RELATIVE * upper
            if self._worths
            else self._whole.meets(self._best.worth, upper)
        )

    def _result(
        self, levels: Levels, limit_s: float, progress: Progress, start: Plan | None = None
    ) -> Result:
        problem = careful_problem(self._facts, self._uncertainty, levels)
        can_start = start is not None and spec_of(self._method).starts
        wanted = replace(
            self._wanted, time_limit=limit_s, start=start if can_start else None, repair=can_start
        )
        return run(PLANNERS, problem, self._method, wanted, stop=self._stop, progress=progress)

    def _adopt(self, levels: Levels, result: Result) -> _Made | None:
        """Restate the plan of a result for the instance, and keep it if its promise holds."""
        if result.plan is None:
            self._rounds.append(Caution(levels, -math.inf, 0.0))
            return None
        plan = as_it_is(self._whole, result.plan)
        planned = intended(self._facts, plan)
        promise, kept = promise_of(self._facts, planned, self._uncertainty), 0.0
        if promise.keeps(self._confidence):
            kept = self._kept(planned)
        made = _Made(plan, self._worth(plan), promise, kept)
        self._rounds.append(Caution(levels, self._share * made.worth, kept))
        if kept >= self._confidence and (self._best is None or made.rank > self._best.rank):
            self._best = made
        return made

    def _kept(self, planned: Intended) -> float:
        """Share of worlds in which a followed plan holds."""
        assert planned.plan is not None
        setting = Setting(self._facts.instance, planned.plan, self._uncertainty, "follow")
        worlds = range(FIRST_WORLD, FIRST_WORLD + WORLDS)
        outcomes = (flown_in(self._facts, planned, setting, seed)[1] for seed in worlds)
        return sum(each.as_planned for each in outcomes) / WORLDS

    def _worth(self, plan: Plan) -> float:
        prizes = self._worths or self._prizes
        return math.fsum(prizes[leg.destination] for leg in plan.legs if leg.destination in prizes)
