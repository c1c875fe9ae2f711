"""The exact method: label setting on exact times, with ng-route memory augmented on demand.

A beam finds a plan; :class:`solvers.proof.proof.Proof` asks, exhaustively, for a better one.
Its searches set labels forwards over the departure events themselves, with exact times and exact
ΔV, pruned by completion values and by dominance, and remember visited targets only as far as
earlier walks have shown that they must (decremental state-space relaxation: Righini and Salani
2008; ng-routes: Baldacci, Mingozzi and Roberti 2011). Where the best walk repeats no target it is a
plan.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, replace

import numpy as np

from adr_opt.common.options import option
from adr_opt.common.progress import Progress, silent
from adr_opt.common.stop import Clock, Stop
from adr_opt.mission.mission import Mission
from adr_opt.mission.problem import Problem, problem_of
from adr_opt.mission.result import Result
from adr_opt.problem.rules import Follower
from adr_opt.problem.support import refuse
from adr_opt.problem.tours import tour_obstacle

from ..beams.beams import usual_settings, with_time_value
from ..beams.greedy_order import guarded_sequence
from ..beams.timely_beams import Beams, pilots
from ..beams.varied_beams import varied
from ..methods import EXACT
from ..progress.gap import GapTracker
from ..progress.proof_size import proof_notes
from ..proof.least_end import prove_end
from ..proof.proof import MOST_LABELS, ProofOptions, prove, prove_cost
from ..tours import planners as tours
from ..walks.latest_times import Latest
from . import many_routes, timed_sets

WIDTH = 2000
"""Width of the guided beams before each round of proof."""

FIRST_BEAMS, MOST_BEAMS = 8, 16
"""Number of beams before the first round, doubled in each further one up to the second number."""

COST_SLOT_M_S = 12.5
"""Slot of ΔV in cost proofs, for walks that do not pay for it [m/s]."""


@dataclass(frozen=True)
class ExactOptions(ProofOptions, method="exact"):
    """Options of the method ``exact``."""

    most_labels: int = option(50_000_000, MOST_LABELS, least=1)
    cost: bool = option(
        False,
        "After the prizes, also prove the least cost among plans of equal prize: ΔV, the end of "
        "the last service, or the expense of a campaign.",
    )


LEAST_COST = Follower("option cost", EXACT.follows - {"prizes that fall"}, "leave the option out")
"""Proofs of the least ΔV or expense."""


def exact(
    problem: Problem | Mission,
    *,
    seed: int,
    stop: Stop,
    progress: Progress,
    start: Iterable[Iterable[int]] | None = None,
    options: ExactOptions = ExactOptions(),
) -> Result:
    """The optimal plan and its proof; at the limit, the best plan and bound so far.

    Of several chasers, and where loads, expense or limits of stations count, by column generation:
    see :func:`.many_routes.plan`.

    Parameters
    ----------
    start : sequence of sequences of int, optional
        A plan to begin with, a route for each chaser, compared with one found by beam search.
    """
    problem = problem_of(problem)
    if options.cost and problem.instance.objective.cost != "duration":
        refuse(problem.instance, LEAST_COST)
    if tour_obstacle(problem.instance) is None:
        return tours.exact(problem, seed=seed, stop=stop, progress=progress, cores=options.cores)
    if problem.alone is not None and problem.alone.has_functions:
        return timed_sets.plan(
            "exact",
            problem.alone,
            seed=seed,
            stop=stop,
            progress=progress,
            start=None if start is None else next(iter(start)),
            options=options,
        )
    if problem.alone is not None:
        return _one_route(problem.alone, seed, stop, progress, start, options)
    return many_routes.plan(
        "exact",
        problem,
        seed=seed,
        stop=stop,
        progress=progress,
        start=start,
        options=options,
        goals=many_routes.Goals(until_done=True, cost=options.cost),
    )


def _one_route(
    mission: Mission,
    seed: int,
    stop: Stop,
    progress: Progress,
    start: Iterable[Iterable[int]] | None,
    options: ExactOptions,
) -> Result:
    """The optimal plan of one chaser, with its proof."""
    certificate = GapTracker(mission, progress)
    if start is not None:
        certificate.offer(*start)

    def enough() -> bool:
        return stop(certificate.incumbent, certificate.bound)

    beams, rng = Beams(mission, Clock(stop)), np.random.default_rng(seed)
    if not certificate.proven and not enough():
        certificate.offer(guarded_sequence(mission))
    if not certificate.proven and not enough():
        layer = with_time_value(mission)
        first = pilots(mission)
        for width in first if mission.timetable.is_on_demand else (*first, WIDTH):
            certificate.offer(beams.search(usual_settings(layer, width), mission=layer))

    number = FIRST_BEAMS

    def search(latest: Latest) -> None:
        nonlocal number
        goal = certificate.goal
        for _ in range(number):
            if certificate.incumbent >= goal or stop.remaining_s() <= 0.0:
                break
            layer, settings, noise = varied(mission, WIDTH, rng)
            guide = latest._replace(goal=goal)
            certificate.offer(beams.search(settings, guide=guide, seed=noise, mission=layer))
        number = min(2 * number, MOST_BEAMS)

    counters = prove(mission, certificate, stop, enough, options, search=search)
    cost_bound = None
    if options.cost and certificate.proven and certificate.sequence is not None:
        if mission.instance.objective.cost == "duration":
            cost_bound, counted = prove_end(
                Problem.of(mission),
                certificate,
                stop,
                lambda sooner, within: exact(
                    sooner,
                    seed=seed,
                    stop=within,
                    progress=silent,
                    options=replace(options, cost=False),
                ),
                lambda found: certificate.offer(*found.routes),
            )
        else:
            cost_bound, counted = prove_cost(
                mission, certificate, stop, replace(options, delta_v_slot_m_s=COST_SLOT_M_S)
            )
        counters |= counted
    return certificate.result(
        "exact",
        seed=seed,
        counters=counters,
        cost_bound=cost_bound,
        notes=proof_notes(mission),
        otherwise=((),),
    )
