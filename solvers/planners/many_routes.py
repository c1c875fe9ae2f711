"""Planning for several chasers: rounds of search and concurrent proof."""

from __future__ import annotations

import math
from collections.abc import Iterable

import numpy as np

from adr_opt.common.progress import Progress, silent
from adr_opt.common.stop import Clock, Stop, TimeIsOver
from adr_opt.legs.families.registry import registered_of
from adr_opt.mission.problem import Problem, Routes
from adr_opt.mission.result import Result

from ..beams.timely_beams import first_width
from ..columns.all_sets import lacks_plan, settle
from ..columns.least_cost import prove_cost_by_columns
from ..columns.proof import ColumnProof
from ..progress.gap import GapTracker
from ..progress.halting import ShareOfTime
from ..progress.proof_size import fits_memory, proof_notes, set_up_s, sweep_s
from ..proof.cheapest import cheapest
from ..proof.concurrent_proof import LEAST_PROOF_S, LEAST_SET_UPS, ConcurrentProof
from ..proof.proof import ProofOptions
from ..routes.engine_rounds import EngineRounds
from ..routes.one_chaser import FloatArray
from ..routes.route_pool import RoutePool
from ..routes.route_search import RouteSearch
from ..routes.target_exchange import Exchanges
from ..walks.floors import floor_evidence
from .options import AutoOptions, ExactOptions, Goals
from .rounds import Task, run

FIRST_MOVES, MOST_MOVES = 20, 160
"""Moves of the search per round: the first number, doubled up to the second."""

USUAL_SWEEP_S = 0.017
"""Duration of a sweep of walks to which these numbers refer [s]."""

WIDTH = 100
"""Width of the beams of a move; the narrowest if rows are computed on demand."""

PACKING_S = 10.0
"""Longest time for packing routes per round [s]."""

FOR_COST = 0.2
"""Share of the remaining time for reducing the plan's cost."""

LAST_FOR_COST = 0.1
"""Share of all time reserved for reducing the cost if it is not ΔV."""

EXCHANGES = 30
"""Exchanges per serviced target that reduce the plan's cost; where planes drift also in each round,
to improve on first routes through a cloud."""


class _Prover(ConcurrentProof[ColumnProof]):
    """The proving half, with a route pool of its own."""

    def __init__(
        self,
        problem: Problem,
        certificate: GapTracker,
        pool: RoutePool,
        seed: int,
        stop: Stop,
        options: ProofOptions,
    ) -> None:
        own, self._shared_pool = GapTracker(problem, certificate.tell), pool
        self._pool = RoutePool(problem)
        self._nothing = np.zeros(len(problem.names))

        def made() -> ColumnProof | None:
            if stop.remaining_s() < max(LEAST_PROOF_S, LEAST_SET_UPS * set_up_s(problem)):
                return None
            try:
                return ColumnProof(problem, own, self._pool, seed, stop, options)
            except TimeIsOver:
                return None

        super().__init__(certificate, own, stop, made)

    def fetch(self) -> None:
        """Receive the incumbent and routes, before a round."""
        super().fetch()
        self._pool.add_all(self._shared_pool)

    def deliver(self) -> None:
        """Deliver the results of the round."""
        self._shared_pool.add_all(self._pool)
        super().deliver()

    @property
    def multipliers(self) -> FloatArray:
        """Dual price of each target, as far as known."""
        return self._nothing if self.proof is None else self.proof.multipliers


class _Search:
    """The searching half: ruin and recreate across routes, packing, and target exchange."""

    def __init__(
        self,
        problem: Problem,
        seed: int,
        stop: Stop,
        certificate: GapTracker,
        pool: RoutePool,
        cores: int,
    ) -> None:
        self._certificate, self._stop = certificate, stop
        self.routes = RouteSearch(problem, seed, stop, certificate, pool)
        self.exchanges = Exchanges(problem, seed, certificate, pool)
        self._engine = EngineRounds(problem, certificate, seed, Clock(stop), cores)
        self._drifts = problem.instance.transfer.may_drift
        self._moves, self._most_moves = FIRST_MOVES, MOST_MOVES
        self._width = first_width(problem.missions[0], WIDTH)

    def begin(self, start: Routes | None, scale: int) -> None:
        """Make the first plans; ``scale`` multiplies the number of moves per round."""
        self._moves, self._most_moves = scale * FIRST_MOVES, scale * MOST_MOVES
        if self._engine.serves:
            if start is not None:
                self._certificate.offer(*start)
            if self._certificate.routes is None:
                self._engine.at_first()
            self.routes.begin_again()
            return
        self.routes.begin(start)

    def beside(self, prover: _Prover | None, rounds: int) -> Task | None:
        """The proof, as long as it can progress."""
        return None if prover is None or prover.done else prover.advance

    def advance(self, prover: _Prover | None, rounds: int) -> None:
        """One round of all searches."""
        search, certificate = self.routes, self._certificate
        search.pack(PACKING_S)
        if self._engine.serves:
            self._engine.until(most=1)
            search.begin_again()
            return
        if self._drifts and self.exchange(self._stop):
            search.begin_again()
        for _ in range(self._moves):
            if certificate.proven or self._stop.remaining_s() <= 0.0:
                break
            search.move(self._width)
            if search.multipliers.any() and not certificate.proven:
                search.complete(self._width)

    def exchange(self, stop: Stop) -> bool:
        """Reduce the cost of the best plan; returns whether anything was found."""
        many = EXCHANGES * sum(map(len, self._certificate.routes or ()))
        return self.exchanges.anneal(many, stop)

    def meet(self, prover: _Prover | None) -> None:
        """Receive dual prices of targets, and increase the effort of the next round."""
        if prover is not None:
            self.routes.multipliers = prover.multipliers
        self._moves = min(2 * self._moves, self._most_moves)

    @property
    def counters(self) -> dict[str, float]:
        """Work counters."""
        engine = self._engine.counters if self._engine.serves else {}
        return {**engine, **self.routes.counters, **self.exchanges.counters}


def plan(
    method: str,
    problem: Problem,
    *,
    seed: int,
    stop: Stop,
    progress: Progress,
    start: Iterable[Iterable[int]] | None,
    options: AutoOptions | ExactOptions,
    goals: Goals | None = None,
) -> Result:
    """The best plan within the time, with a proof if one is found.

    Rounds, each with more effort than the one before: ruin and recreate across routes
    (:class:`solvers.routes.route_search.RouteSearch`) side by side with column generation
    (:class:`solvers.columns.proof.ColumnProof`); after each the best plan is put together from
    all routes that either of them has met. The same seed and the same number of rounds give the
    same plan. Where planes drift, targets change routes as well
    (:class:`solvers.routes.target_exchange.Exchanges`); where another cost than ΔV is asked for,
    the plan is made cheaper in that way at last.

    Parameters
    ----------
    method : str
        Whose result it is.
    problem, seed, stop, progress, start, options
        As planners take them.
    goals : Goals, optional
        By default those of the options.
    """
    goals = goals or options.goals
    certificate, pool = GapTracker(problem, progress), RoutePool(problem)
    asks_for_cost = problem.instance.objective.asks_for_more and not goals.prizes_alone
    within: Stop = ShareOfTime(stop, 1.0 - LAST_FOR_COST) if asks_for_cost else stop
    search = _Search(problem, seed, within, certificate, pool, options.cores)
    prover, scale = None, 1
    if goals.proves and fits_memory(problem):
        scale = max(1, round(sweep_s(problem) / USUAL_SWEEP_S))
        prover = _Prover(problem, certificate, pool, seed, within, options)
    search.begin(None if start is None else tuple(map(tuple, start)), scale)
    instance = problem.instance
    # Of others nobody but a prover knows floors, and what they close could not be verified.
    if goals.proves and instance.given is None and not registered_of(instance):
        certificate.lower(*floor_evidence(problem))
    lacking = lacks_plan(problem, certificate)
    rounds = 0
    infeasible = lacking and settle(problem, certificate, pool, stop)
    if not infeasible:
        rounds = run(
            certificate,
            search,
            prover,
            stop=stop,
            within=within,
            cores=options.cores,
            until_done=goals.until_done,
        )
    if goals.proves and problem.limits and not (lacking or certificate.proven):
        settle(problem, certificate, pool, stop)
        search.routes.pack(PACKING_S)
    if asks_for_cost or (goals.cost and certificate.proven):
        search.exchange(ShareOfTime(stop, FOR_COST) if goals.cost else stop)
    counters: dict[str, float] = {**search.counters, "rounds": rounds}
    if prover is not None:
        counters |= prover.counters
    cost_bound = None
    if goals.cost:
        cost_bound, counted = cheapest(
            problem,
            certificate,
            stop,
            lambda over: prove_cost_by_columns(problem, certificate, pool, stop, over, options),
            lambda sooner, within: plan(
                method,
                sooner,
                seed=seed,
                stop=within,
                progress=silent,
                start=None,
                options=options,
                goals=Goals(until_done=True, prizes_alone=True),
            ),
            by_rounds=not goals.until_done,
        )
        counters |= counted
    stated = certificate.stated
    return certificate.result(
        method,
        seed=seed,
        counters=counters,
        upper_bound=stated,
        cost_bound=cost_bound,
        notes=proof_notes(problem) if math.isfinite(stated) else (),
    )
