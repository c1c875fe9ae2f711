"""Planning and bounding of campaigns that are tours through time."""

from __future__ import annotations

import math
from collections.abc import Iterable

from adr_opt.common.clock import now_s
from adr_opt.common.progress import Progress
from adr_opt.common.stop import Stop
from adr_opt.mission.problem import Problem
from adr_opt.mission.result import Result

from ..progress.halting import ShareOfTime
from ..proof.proof import ProofOptions
from ..tours.campaign import Campaign, certified_tour, plan_tours
from ..tours.least_expense import LeastExpense, cell_length_s

FOR_PLAN = 0.15
"""Share of the time for the plan where its cost is to be bounded."""


def search(
    method: str,
    problem: Problem,
    *,
    seed: int,
    stop: Stop,
    progress: Progress,
    start: Iterable[Iterable[int]] | None,
    options: ProofOptions,
) -> Result:
    """The best campaign within the time, without a start plan or a proof of its cost."""
    began_s = now_s()
    planned = plan_tours(problem, seed=seed, stop=stop, progress=progress, cores=options.cores)
    return certified_tour(method, problem, planned, seed=seed, began_s=began_s)


def prove(
    method: str,
    problem: Problem,
    *,
    seed: int,
    stop: Stop,
    progress: Progress,
    start: Iterable[Iterable[int]] | None,
    options: ProofOptions,
) -> Result:
    """A campaign, and a bound on the cost of all campaigns if it is an expense by mass.

    Without a limit of legs, or with very short services, nothing is proven of the cost. No
    ``start`` is used.
    """
    began_s = now_s()
    within: Stop = stop
    can_bound = Campaign(problem).weighs and problem.instance.transfer.max_leg_s is not None
    can_bound = can_bound and cell_length_s(problem) is not None
    if can_bound and math.isfinite(stop.remaining_s()):
        within = ShareOfTime(stop, FOR_PLAN)
    planned = plan_tours(problem, seed=seed, stop=within, progress=progress, cores=options.cores)
    if not can_bound:
        return certified_tour(method, problem, planned, seed=seed, began_s=began_s)
    least, everything = LeastExpense(problem, cores=options.cores), problem.total_worth
    while True:
        least.advance(stop.remaining_s())
        if stop.remaining_s() <= 0.0 or stop(everything, everything):
            break
    return certified_tour(
        method,
        problem,
        planned,
        seed=seed,
        began_s=began_s,
        cost_bound=least.value,
        counters={"rounds": float(least.rounds)},
    )
