"""Planning one chaser exactly: label setting on exact times, with ng-route memory that grows.

A beam finds a plan; :class:`solvers.proof.proof.Proof` asks, exhaustively, for a better one.
Its searches set labels forwards over the departure events themselves, with exact times and exact
ΔV, pruned by completion values and by dominance, and remember visited targets only as far as
earlier walks have shown that they must (decremental state-space relaxation: Righini and Salani
2008; ng-routes: Baldacci, Mingozzi and Roberti 2011). Where the best walk repeats no target it is a
plan.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import replace

import numpy as np

from adr_opt.common.progress import Progress, silent
from adr_opt.common.stop import Clock, Stop
from adr_opt.mission.mission import Mission
from adr_opt.mission.problem import Problem
from adr_opt.mission.result import Result

from ..beams.beams import usual_settings, with_time_value
from ..beams.greedy_order import guarded_sequence
from ..beams.timely_beams import Beams, pilots
from ..beams.varied_beams import varied
from ..progress.gap import GapTracker
from ..progress.proof_size import proof_notes
from ..proof.cheapest import cheapest
from ..proof.proof import ProofOptions, prove, prove_cost
from ..walks.latest_times import Latest
from .options import ExactOptions

WIDTH = 2000
"""Width of the guided beams before each round of proof."""

FIRST_BEAMS, MOST_BEAMS = 8, 16
"""Number of beams before the first round, doubled in each further one up to the second number."""

COST_SLOT_M_S = 12.5
"""Slot of ΔV in cost proofs, for walks that do not pay for it [m/s]."""


def plan(
    method: str,
    problem: Problem,
    *,
    seed: int,
    stop: Stop,
    progress: Progress,
    start: Iterable[Iterable[int]] | None,
    options: ExactOptions,
) -> Result:
    """The optimal plan of one chaser, with its proof.

    Parameters
    ----------
    method : str
        Whose result it is.
    problem : Problem
        With a mission that is :attr:`~.Problem.alone`.
    seed, stop, progress, start, options
        As planners take them.
    """
    mission = problem.alone
    assert mission is not None
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
    if options.cost:
        cost_bound, counted = least_cost(
            method, mission, certificate, stop, seed=seed, options=options, by_rounds=False
        )
        counters |= counted
    return certificate.result(
        method,
        seed=seed,
        counters=counters,
        cost_bound=cost_bound,
        notes=proof_notes(mission),
        otherwise=((),),
    )


def least_cost(
    method: str,
    mission: Mission,
    certificate: GapTracker,
    stop: Stop,
    *,
    seed: int,
    options: ProofOptions,
    by_rounds: bool,
) -> tuple[float | None, dict[str, float]]:
    """Lower the cost of the plan of one chaser, see :func:`.cheapest.cheapest`.

    Parameters
    ----------
    method, seed, options
        As :func:`plan` takes them.
    mission : Mission
    certificate, stop, by_rounds
        As :func:`.cheapest.cheapest` takes them.
    """
    finer = replace(options, delta_v_slot_m_s=COST_SLOT_M_S)
    alike = ExactOptions(options.jobs, options.delta_v_slot_m_s, options.most_labels)

    def again(sooner: Problem, within: Stop) -> Result:
        return plan(
            method, sooner, seed=seed, stop=within, progress=silent, start=None, options=alike
        )

    return cheapest(
        Problem.of(mission),
        certificate,
        stop,
        lambda over: prove_cost(mission, certificate, stop, over, finer),
        again,
        by_rounds=by_rounds,
    )
