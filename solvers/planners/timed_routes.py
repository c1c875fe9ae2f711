"""Planning where only arrivals matter: functions of time, and ends of given connections.

The route engine first, for as much work as it gains by (:mod:`..routes.route_engine`). Then the
proof: where a tour of all targets by one chaser is to end first, by sets of targets
(:mod:`..timed_tours.earliest_end`); of all else that has functions of time, by the engines of given
connections on optimistic ones (:mod:`..timed_tours.optimistic`). What time that leaves is the route
engine's; where `auto` looks at all routes that is a part in any case.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import replace

import numpy as np

from adr_opt.common.memory import available_bytes
from adr_opt.common.progress import Progress, silent
from adr_opt.common.stop import Stop
from adr_opt.mission.problem import Problem
from adr_opt.mission.result import Result

from ..progress.cost_rounds import is_least
from ..progress.gap import GapTracker
from ..progress.halting import ShareOfTime
from ..proof.proof import ProofOptions
from ..routes.engine_rounds import EngineRounds
from ..timed_tours.earliest_end import LABEL_BYTES, EarliestEnd
from ..timed_tours.optimistic import OptimisticLegs
from ..timed_tours.tour import TimedTour, sequence_of, tour_of
from . import label_setting, many_routes
from .options import AutoOptions, ExactOptions

OF_LISTS = 0.3
"""Share of the remaining time for the proof over given connections, which seldom succeeds."""

OF_ROUTES = 0.5
"""Share of the remaining time in `auto` for the proof over all routes."""

MEMORY_SHARE = 0.4
"""Share of free memory that labels may take."""


def plan(
    method: str,
    problem: Problem,
    *,
    seed: int,
    stop: Stop,
    progress: Progress,
    start: Iterable[Iterable[int]] | None,
    options: AutoOptions | ExactOptions,
) -> Result:
    """The best plan so far and its proof: both of the prizes and of the cost.

    A tour of all targets that ends first is a question of its own, asked first where it may be the
    answer (:mod:`..timed_tours.earliest_end`).

    Parameters
    ----------
    method : str
        Whose result it is.
    problem : Problem
        With functions of time, or one that :attr:`~.Problem.asks_for_least_end`.
    seed, stop, progress, start, options
        As planners take them.
    """
    certificate = GapTracker(problem, progress)
    if start is not None:
        certificate.offer(*start)
    searching = EngineRounds(problem, certificate, seed, stop, options.cores)
    searching.at_first()
    within: Stop = stop if problem.missions[0].has_functions else ShareOfTime(stop, OF_LISTS)
    proof = _Proof(problem, certificate, within, seed, options)
    proves, tour = options.goals.proves, None
    if proves and problem.alone is not None and problem.total_worth > 0.0:
        tour = tour_of(problem.alone)
    if tour is not None:
        proof.earliest_end(tour)
    if proves and not proof.answered and problem.missions[0].has_functions:
        proof.all_routes(1.0 if method == "exact" else OF_ROUTES)
    if not (proof.complete or stop.remaining_s() <= 0.0):
        searching.until()
    cost_bound = proof.cost_bound
    return certificate.result(
        method,
        seed=seed,
        counters={"labels": proof.labels, "optimistic": proof.asked, **searching.counters},
        cost_bound=None if cost_bound is None else min(cost_bound, certificate.cost),
        upper_bound=certificate.stated,
        otherwise=tuple(() for _ in problem.missions),
    )


class _Asked(ShareOfTime):
    """A share of the time, in which the criterion is queried with the true plan and bound."""

    def __init__(self, stop: Stop, share: float, certificate: GapTracker) -> None:
        super().__init__(stop, share)
        self._certificate = certificate

    def __call__(self, incumbent: float, bound: float) -> bool:
        """Whether to stop."""
        known = self._certificate
        return self._stop(known.incumbent, known.bound) or self.remaining_s() <= 0.0


class _Proof:
    """Proofs that share an incumbent.

    Attributes
    ----------
    answered : bool
        Whether nothing is left to be asked.
    complete : bool
        Whether no better plan exists.
    cost_bound : float or None
        What no plan worth as much as the best one costs less than, if anything is known.
    labels : int
    asked : int
        How many optimistic missions were planned.
    """

    def __init__(
        self,
        problem: Problem,
        certificate: GapTracker,
        stop: Stop,
        seed: int,
        options: ProofOptions,
    ) -> None:
        self._problem, self._certificate, self._stop = problem, certificate, stop
        self._seed, self._options = seed, options
        self.answered, self.complete, self.labels, self.asked = False, False, 0, 0
        self.cost_bound: float | None = None

    def _over(self) -> bool:
        return self._stop.remaining_s() <= 0.0

    def earliest_end(self, tour: TimedTour) -> None:
        """Search the tour of all targets that ends first."""
        mission, certificate = self._problem.missions[0], self._certificate
        every = mission.total_worth
        search = EarliestEnd(
            tour,
            self._over,
            jobs=self._options.cores,
            most_labels=int(min(MEMORY_SHARE * available_bytes() / LABEL_BYTES, 2**30)),
            known_s=certificate.cost if certificate.incumbent >= every else np.inf,
        )
        offered: object = None
        for _ in search.rounds():
            if search.order is not None and search.order is not offered:
                offered = search.order
                certificate.offer(sequence_of(mission, tour, search.order))
            if self._stop(certificate.incumbent, certificate.bound) and not search.proven:
                break
        self.labels = search.labels
        required = all(target.required for target in mission.instance.targets)
        if search.order is not None or certificate.incumbent >= every:
            self.answered, self.complete = True, search.proven
            certificate.lower(every)
            self.cost_bound = search.bound_s
        elif search.proven and required:
            self.answered = self.complete = True
            certificate.lower(-np.inf)
        else:
            self.answered = required or self._over()

    def all_routes(self, share: float) -> None:
        """Prove prizes, then the cost, on optimistic connections refined by their plans."""
        problem, certificate = self._problem, self._certificate
        # Worths that are offered, and services that take longer, are no part of an instance.
        own = Problem(problem.instance).planning_prizes
        if problem.connecting.corrections or not np.array_equal(own, problem.planning_prizes):
            return
        legs, within = OptimisticLegs(problem), _Asked(self._stop, share, certificate)
        options = ExactOptions(self._options.jobs, self._options.delta_v_slot_m_s)
        while within.remaining_s() > 0.0:
            proven = certificate.proven
            if proven and certificate.cost <= 0.0:  # no plan costs less than nothing
                self.cost_bound, self.complete = 0.0, True
                return
            instance = legs.instance()
            if instance is None:
                return
            optimistic = Problem(instance, margin=problem.margin)
            engine = label_setting if optimistic.alone is not None else many_routes
            found = engine.plan(
                "exact",
                optimistic,
                seed=self._seed,
                stop=within,
                progress=silent,
                start=certificate.routes,
                options=replace(options, cost=proven),
            )
            self.asked += 1
            self.labels += int(found.counters.get("labels", 0))
            certificate.lower(problem.worth(found.upper_bound))
            if found.plan is None:
                self.complete = found.status == "infeasible"
                return
            certificate.offer(*found.routes)
            least = found.plan.cost_bound
            if least is not None and problem.worth(found.objective) == certificate.incumbent:
                self.cost_bound = max(least, self.cost_bound or 0.0)
                self.complete = is_least(certificate.cost, self.cost_bound)
            if self.complete:
                return
            asks = certificate.proven and not proven
            if found.status != "optimal":
                return
            if not (legs.refine(found.plan) or asks):
                self.complete = certificate.proven  # but for rounding
                return
