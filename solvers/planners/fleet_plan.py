"""Planning for several chasers: search and proof side by side, round by round."""

from __future__ import annotations

import math
import time
from collections.abc import Iterable
from concurrent.futures import Future, ThreadPoolExecutor
from contextlib import closing, nullcontext

import numpy as np

from adr_opt.common.progress import Progress, silent
from adr_opt.common.stop import Stop
from adr_opt.mission.campaign import Campaign, Routes
from adr_opt.mission.certified import certify_routes
from adr_opt.mission.result import Result

from ..columns.all_sets import lacks_plan, settle
from ..columns.least_cost import prove_campaign_cost
from ..columns.proof import CampaignProof
from ..progress.campaign_incumbent import CampaignCertificate
from ..progress.halting import ShareOfTime
from ..progress.proof_size import fits_memory, proof_notes, set_up_s, sweep_s
from ..proof.concurrent_proof import LEAST_PROOF_S, LEAST_SET_UPS, ConcurrentProof
from ..proof.least_end import prove_end
from ..proof.proof import ProofOptions
from ..routes.one_chaser import FloatArray
from ..routes.route_pool import RoutePool
from ..routes.route_search import RouteSearch
from ..routes.target_exchange import Exchanges
from ..walks.floors import floor_bound

FIRST_MOVES, MOST_MOVES = 20, 160
"""Moves of the search in a round: twice as many in each; more where proofs take their time."""

USUAL_SWEEP_S = 0.017
"""What a sweep of the walks takes where so many moves are made."""

WIDTH = 100
"""Of the beams of a move."""

PACKING_S = 10.0
"""The longest that putting routes together may take in a round."""

FOR_COST = 0.2
"""Share of the time left that making the plan cheaper may take."""

LAST_FOR_COST = 0.1
"""Share of all time that is kept for it where another cost than ΔV is asked for."""

EXCHANGES = 30
"""Of targets, for each one that is serviced, by which the plan is made cheaper; also in each round
where planes drift, so that routes are more than a way through a cloud."""


class _Prover(ConcurrentProof[Routes, CampaignProof]):
    """The proving half: with a pool of its own as well."""

    def __init__(
        self,
        campaign: Campaign,
        certificate: CampaignCertificate,
        pool: RoutePool,
        seed: int,
        stop: Stop,
        options: ProofOptions,
    ) -> None:
        own, self._shared_pool = CampaignCertificate(campaign, certificate.tell), pool
        self._pool = RoutePool(campaign)
        self._nothing = np.zeros(len(campaign.names))

        def made() -> CampaignProof | None:
            if stop.remaining_s() < max(LEAST_PROOF_S, LEAST_SET_UPS * set_up_s(campaign)):
                own.lower(floor_bound(campaign))
                return None
            return CampaignProof(campaign, own, self._pool, seed, stop, options)

        super().__init__(certificate, own, stop, made)

    def fetch(self) -> None:
        """Hear of the incumbent and of routes, before a round."""
        super().fetch()
        self._pool.take(self._shared_pool)

    def deliver(self) -> None:
        """Tell what the round has found."""
        self._shared_pool.take(self._pool)
        super().deliver()

    @property
    def multipliers(self) -> FloatArray:
        """What one more of each target would be worth, as far as it is known."""
        return self._nothing if self.proof is None else self.proof.multipliers


def _many(certificate: CampaignCertificate) -> int:
    """So many exchanges are made at once."""
    return EXCHANGES * sum(map(len, certificate.sequence or ()))


def plan(
    method: str,
    campaign: Campaign,
    *,
    seed: int,
    stop: Stop,
    progress: Progress,
    start: Iterable[Iterable[int]] | None = None,
    options: ProofOptions,
    proves: bool = True,
    until_done: bool = False,
    cost: bool = False,
    prizes_alone: bool = False,
) -> Result:
    """The best plan that the time allows, and a proof where one is found.

    Rounds, each with more effort than the one before: ruin and recreate across routes
    (:class:`solvers.routes.route_search.RouteSearch`) side by side with column generation
    (:class:`solvers.columns.proof.CampaignProof`); after each the best plan is put together from
    all routes that either of them has met. The same seed and the same number of rounds give the
    same plan. Where planes drift, targets change routes as well
    (:class:`solvers.routes.target_exchange.Exchanges`); where another cost than ΔV is asked for,
    the plan is made cheaper in that way at last.

    Parameters
    ----------
    method : str
        Whose result it is.
    start : sequence of sequences of int, optional
        Routes to begin from.
    proves : bool
        Whether to work on the bound.
    until_done : bool
        End when the proof can do no more.
    cost : bool
        Go on to the least cost of plans that collect as much, once the prizes are proven, with the
        plan made cheaper first.
    prizes_alone : bool
        The plan need not be cheap: no time is kept for that.
    """
    began = time.perf_counter()
    certificate, pool = CampaignCertificate(campaign, progress), RoutePool(campaign)
    asks_for_cost = campaign.instance.objective.asks_for_more and not prizes_alone
    within: Stop = ShareOfTime(stop, 1.0 - LAST_FOR_COST) if asks_for_cost else stop
    search = RouteSearch(campaign, seed, within, certificate, pool)
    exchanges = Exchanges(campaign, seed, certificate, pool)
    drifts = campaign.instance.transfer.may_drift
    search.begin(None if start is None else tuple(map(tuple, start)))
    lacking = lacks_plan(campaign, certificate)
    infeasible = lacking and settle(campaign, certificate, pool, stop)
    prover = None
    if proves and fits_memory(campaign):
        prover = _Prover(campaign, certificate, pool, seed, within, options)
    elif proves:
        certificate.lower(floor_bound(campaign))

    def is_over() -> bool:
        ended = until_done and (prover is None or prover.done)
        return (
            ended
            or infeasible
            or certificate.proven
            or stop(certificate.incumbent, certificate.bound)
            or within.remaining_s() <= 0.0
        )

    rounds, most = 0, 1 if prover is None else max(1, round(sweep_s(campaign) / USUAL_SWEEP_S))
    moves = FIRST_MOVES * most
    with nullcontext() if prover is None else closing(prover), ThreadPoolExecutor(1) as threads:
        while not is_over():
            rounds += 1
            advancing: Future[None] | None = None
            if prover is not None and not prover.done:
                prover.fetch()
                if options.cores > 1:
                    advancing = threads.submit(prover.advance)
                else:
                    prover.advance()
            search.pack(PACKING_S)
            if drifts and exchanges.anneal(_many(certificate), within):
                search.begin_again()
            for _ in range(moves):
                if certificate.proven or within.remaining_s() <= 0.0:
                    break
                search.move(WIDTH)
                if search.multipliers.any() and not certificate.proven:
                    search.complete(WIDTH)
            if advancing is not None:
                advancing.result()
            if prover is not None:
                prover.deliver()
                search.multipliers = prover.multipliers
            moves = min(2 * moves, MOST_MOVES * most)
    if proves and campaign.limits and not (lacking or certificate.proven):
        settle(campaign, certificate, pool, stop)
        search.pack(PACKING_S)
    if asks_for_cost or (cost and certificate.proven):
        exchanges.anneal(_many(certificate), ShareOfTime(stop, FOR_COST) if cost else stop)
    counters: dict[str, float] = {"rounds": rounds, **search.counters, **exchanges.counters}
    if prover is not None:
        counters |= prover.counters
    cost_bound = None
    if cost and certificate.proven and certificate.sequence is not None:
        if campaign.instance.objective.cost == "duration":
            cost_bound, counted = prove_end(
                campaign, certificate, stop,
                lambda sooner, within: plan(
                    method, sooner, seed=seed, stop=within, progress=silent, options=options,
                    until_done=True, prizes_alone=True,
                ),
                lambda found: certificate.offer(found.routes),
            )  # fmt: skip
        else:
            cost_bound, counted = prove_campaign_cost(campaign, certificate, pool, stop, options)
        counters |= counted
    return certify_routes(
        campaign,
        method,
        certificate.sequence,
        seed=seed,
        runtime_s=time.perf_counter() - began,
        upper_bound=certificate.stated,
        cost_bound=cost_bound,
        evidence=certificate.evidence,
        counters=counters,
        notes=proof_notes(campaign) if math.isfinite(certificate.stated) else (),
    )
