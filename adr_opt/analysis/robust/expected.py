"""Plans that maximise the expected prize when followed (docs/model.md section 13.5).

What following a plan collects on average is no sum over its legs, so no planner has it as its
prize. It is taken from drawn worlds, the same for all plans. Plans to choose from come from
ordinary missions (:mod:`.careful_problem`) that expect more or less of the uncertainty: stays that
last longer than planned by a multiple of their mean delay, and legs that are charged for what they
may cost more. Both cautions are varied, one at a time, from the best plan so far.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass, replace
from hashlib import sha256
from typing import Any, NamedTuple

import numpy as np

from ...common.clock import now_s
from ...common.errors import InputError
from ...common.progress import Progress, silent
from ...common.stop import Stop
from ...mission.problem import Problem
from ...mission.result import Result
from ...plan.plan import ExpectedPrize, Plan, Status
from ...problem.instance import AnyInstance, Instance
from ...problem.support import followed
from ...problem.uncertainty import Uncertainty
from ...run.front import DEFAULT_METHOD, DEFAULT_TIME_LIMIT_S, RunOptions, run
from ...run.methods import PLANNERS
from ..rehearse.intended import intended
from ..rehearse.mission_facts import PROMISED, MissionFacts
from ..rehearse.outlook import FloatArray, Outlook, is_better
from ..rehearse.service_delays import mean_delays_s
from ..rehearse.tries import mean_worths
from .careful_problem import Levels, as_it_is, careful_problem, risk_charge

STAYS = (0.0, 0.5, 1.0, 1.5, 2.0, 3.0)
"""Multiples of the mean delay of a stay added to planned stays."""

TANKS = (None, 0.5, 0.8, 0.95, 0.99)
"""Required chances that each tank suffices for its legs; None: planned ΔV without reserve."""

LEVEL_OF_LAUNCH = 0.8
"""Quantile of slips after which launches are planned, at any level of caution."""

CHOSEN = range(3 * 10**9, 3 * 10**9 + 300)
"""Seeds of the worlds in which plans are chosen, far from those of users."""

TOLD = range(4 * 10**9, 4 * 10**9 + 1000)
"""Seeds of the worlds in which the chosen plan is judged, not used for choosing."""

LEAST_SHARE, LEFT_SHARE = 0.1, 0.25
"""Least share of the time limit for a plan, and share of the time left for it."""


class Prudence(NamedTuple):
    """Levels of caution of a plan: indices into :data:`STAYS` and :data:`TANKS`."""

    stays: int
    tank: int


@dataclass(frozen=True)
class ExpectedPlan:
    """A plan for the expected prize.

    Attributes
    ----------
    plan : Plan or None
        Of the instance as it is, with what it collects on average in new worlds.
    plain : float
        Mean prize, in the same worlds, of the plan made without regard to the uncertainty; 0
        without one.
    tried : int
        Number of plans that were chosen from.
    status : str
        Of the mission as planned: "infeasible" if it is proven that there is no plan at all.
    method : str
    seed : int
    runtime_s : float
    """

    plan: Plan | None
    plain: float
    tried: int
    status: Status
    method: str
    seed: int
    runtime_s: float

    @property
    def result(self) -> Result:
        """The plan as the result of a planner; nothing is proven of it."""
        made = Result(self.method, seed=self.seed, runtime_s=self.runtime_s)
        plan = self.plan
        if plan is None:
            return replace(made, status=self.status)
        return replace(
            made, plan=plan, objective=plan.objective, status=plan.status, notes=plan.notes
        )


def expected(
    instance: AnyInstance,
    uncertainty: Uncertainty,
    method: str = DEFAULT_METHOD,
    *,
    time_limit: float = DEFAULT_TIME_LIMIT_S,
    seed: int = 0,
    jobs: int | None = None,
    stop: Stop | None = None,
    progress: Progress = silent,
    **method_options: Any,
) -> ExpectedPlan:
    """Plan a mission for the largest mean prize when the plan is followed.

    Parameters
    ----------
    instance : Instance, path or dict
    uncertainty : Uncertainty
        What may deviate from the plan.
    method : str
        Name of an installed planner.
    time_limit : float
        Wall time of all plans together [s].
    seed, jobs, **method_options
        As :func:`adr_opt.solve` takes them.
    stop : Stop, optional
        A further criterion.
    progress : callable
        Called with the expected prize whenever it improves; no bound is known.

    Returns
    -------
    ExpectedPlan

    Raises
    ------
    InputError
        The mission has a rule that rehearsals do not follow, or as :func:`adr_opt.solve` raises it.
    """
    instance = followed(instance, PROMISED)
    uncertainty = uncertainty.of(instance)
    wanted = RunOptions(time_limit, seed, None, jobs=jobs, options=method_options)
    return _Search(instance, uncertainty, method, wanted, stop, progress).run()


class _Made(NamedTuple):
    """A plan of the instance, with the prize of following it in each world."""

    plan: Plan
    worths: FloatArray


class _Search:
    """The search for the level of caution whose plan collects most."""

    def __init__(
        self,
        instance: Instance,
        uncertainty: Uncertainty,
        method: str,
        wanted: RunOptions,
        stop: Stop | None,
        progress: Progress,
    ) -> None:
        self._facts, self._uncertainty = MissionFacts(instance), uncertainty
        self._whole = Problem(instance, connecting=self._facts.finder)
        self._outlook = Outlook(self._facts, uncertainty)
        self._delays_s = mean_delays_s(self._facts, uncertainty)
        self._method, self._wanted, self._stop = method, wanted, stop
        self._progress = progress
        self._began = now_s()
        self._end = self._began + wanted.time_limit
        slips = any(uncertainty.slip_of(chaser.name) for chaser in instance.chasers)
        self._is_plain = not (mean_worths(instance, uncertainty) or slips)
        self._plain: _Made | None = None
        self._tried: dict[Prudence, _Made | None] = {}
        self._best: tuple[Prudence, _Made] | None = None
        self._status: Status = "unknown"

    def run(self) -> ExpectedPlan:
        """Try the mission without caution, then one level after another from the best so far."""
        result = self._planned(self._whole)
        self._status = result.status
        if result.plan is not None:
            self._plain = _Made(result.plan, self._followed(result.plan, CHOSEN))
            self._keep(Prudence(0, 0), self._plain)
        if result.status != "infeasible":
            for prudence in self._next():
                self._tried[prudence] = made = self._made(prudence)
                if made is not None:
                    self._keep(prudence, made)
        return ExpectedPlan(
            None if self._best is None else self._told(self._best[1].plan),
            0.0 if self._plain is None else self._mean(self._followed(self._plain.plan, TOLD)),
            sum(made is not None for made in (self._plain, *self._tried.values())),
            self._status,
            self._method,
            self._wanted.seed,
            now_s() - self._began,
        )

    def _keep(self, prudence: Prudence, made: _Made) -> None:
        """Keep a plan that is better than the best so far."""
        if self._best is None or is_better(made.worths, self._best[1].worths):
            self._best = prudence, made
            self._progress(self._mean(made.worths), math.inf)

    def _mean(self, worths: FloatArray) -> float:
        return float(self._outlook.prizes(worths).mean())

    def _next(self) -> Iterator[Prudence]:
        """The next level of caution: means first, then untried neighbours of the best."""
        most = self._most
        first = [Prudence(0, 0)] * (not self._is_plain)
        first += [Prudence(min(2, most.stays), min(tank, most.tank)) for tank in (1, 2)]
        while (new := next((each for each in first if self._is_open(each)), None)) is not None:
            yield new
        while self._best is not None:
            stays, tank = self._best[0]
            near = [
                Prudence(stays + 1, tank),
                Prudence(stays, tank + 1),
                Prudence(stays - 1, tank),
                Prudence(stays, tank - 1),
            ]
            inside = [
                each
                for each in near
                if 0 <= each.stays <= most.stays and 0 <= each.tank <= most.tank
            ]
            if (new := next(filter(self._is_open, inside), None)) is None:
                return
            yield new

    def _is_open(self, prudence: Prudence) -> bool:
        """Whether time is left for an untried level."""
        if self._end <= now_s() or (self._stop is not None and self._stop.remaining_s() <= 0.0):
            return False
        is_known = self._is_plain and prudence == Prudence(0, 0)
        return not is_known and prudence not in self._tried

    @property
    def _most(self) -> Prudence:
        """The highest level of caution that has an effect."""
        uncertainty = self._uncertainty
        is_dear = risk_charge(self._facts, uncertainty, TANKS[-1] or 0.5) is not None
        stays = len(STAYS) - 1 if (self._delays_s > 0.0).any() else 0
        return Prudence(stays, len(TANKS) - 1 if is_dear else 0)

    def _planned(self, problem: Problem) -> Result:
        """The plan of a mission, within a share of the time left."""
        left_s = max(self._end - now_s(), 0.0)
        limit_s = min(left_s, max(LEAST_SHARE * self._wanted.time_limit, LEFT_SHARE * left_s))
        wanted = replace(self._wanted, time_limit=limit_s)
        return run(PLANNERS, problem, self._method, wanted, stop=self._stop, progress=silent)

    def _made(self, prudence: Prudence) -> _Made | None:
        """The plan at a level of caution, restated for the instance and followed."""
        facts, share = self._facts, STAYS[prudence.stays]
        planned_s = facts.chasers[0].limits.service - [
            facts.tow_s.get(body, 0.0) for body in range(len(facts.names))
        ]
        services_s = {
            facts.names[body]: float(planned_s[body] + share * self._delays_s[body])
            for body in np.flatnonzero(share * self._delays_s > 0.0).tolist()
        }
        levels = Levels(TANKS[prudence.tank], LEVEL_OF_LAUNCH, LEVEL_OF_LAUNCH)
        try:
            result = self._planned(
                careful_problem(facts, self._uncertainty, levels, services_s=services_s)
            )
        except InputError:  # no tank holds anything with such a chance
            return None
        if result.plan is None:
            return None
        plan = as_it_is(self._whole, result.plan)
        return _Made(plan, self._followed(plan, CHOSEN))

    def _followed(self, plan: Plan, worlds: range) -> FloatArray:
        """Prize of following a plan in each world."""
        return self._outlook.of_plan(intended(self._facts, plan), worlds)

    def _told(self, plan: Plan) -> Plan:
        """The plan with its mean prize, and how it was found."""
        prizes = self._outlook.prizes(self._followed(plan, TOLD))
        mean, error = float(prizes.mean()), float(prizes.std(ddof=1)) / math.sqrt(len(TOLD))
        note = (
            f"made for its expected prize: followed, it collects {mean:.4g} ± {error:.2g} on "
            f"average in {len(TOLD)} rehearsals; the objective counts all planned targets"
        )
        return plan.replace(
            expected=ExpectedPrize(
                prize=mean,
                standard_error=error,
                worlds=len(TOLD),
                uncertainty_sha256=sha256(self._uncertainty.to_json().encode()).hexdigest(),
            ),
            notes=(*plan.notes, note),
            method=self._method,
            seed=self._wanted.seed,
            runtime_s=now_s() - self._began,
        )
