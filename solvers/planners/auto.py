"""The default planner: an anytime search with a concurrent proof."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

from adr_opt.common.options import option
from adr_opt.common.progress import Progress
from adr_opt.common.stop import Stop
from adr_opt.mission.mission import Mission
from adr_opt.mission.problem import Problem, problem_of
from adr_opt.mission.result import Result
from adr_opt.problem.tours import tour_obstacle

from ..beams.beams import USUAL
from ..proof.proof import ProofOptions
from ..tours import planners as tours
from . import least_end, many_routes, one_route, timed_sets
from .many_routes import Goals


@dataclass(frozen=True)
class AutoOptions(ProofOptions, method="auto"):
    """Options of the planner ``auto``."""

    prove: bool = option(
        True, "Work on the bound as well; otherwise only beams and local search run."
    )
    time_value_m_s_per_h: float = option(USUAL, "As for `beam`.", unit="m/s per h")


def auto(
    problem: Problem | Mission,
    *,
    seed: int,
    stop: Stop,
    progress: Progress,
    start: Iterable[Iterable[int]] | None = None,
    options: AutoOptions = AutoOptions(),
) -> Result:
    """The best plan that the time allows, with a proof if one is found.

    Begins with the guarded greedy plan and the searches of ``beam``, behind which it never falls
    for that reason. Then rounds, each with more effort than the one before, of search and of proof
    side by side: for one chaser see :func:`.one_route.plan`, for several and where loads, expense
    or limits of stations count :func:`.many_routes.plan`. Ends when the incumbent meets the bound,
    or when ``stop`` says so. The same seed and the same number of iterations (rounds) give the same
    plan; ``jobs`` does not change it. Where all targets of given connections are to be done as
    early as possible, see :func:`.least_end.plan`.

    Parameters
    ----------
    start : sequence of sequences of int, optional
        A plan to begin from: bodies in order, for each chaser.
    """
    problem = problem_of(problem)
    if tour_obstacle(problem.instance) is None:
        return tours.auto(problem, seed=seed, stop=stop, progress=progress, cores=options.cores)
    if problem.alone is not None and problem.alone.has_functions:
        return timed_sets.plan(
            "auto",
            problem.alone,
            seed=seed,
            stop=stop,
            progress=progress,
            start=None if start is None else next(iter(start)),
            options=options,
        )
    if problem.asks_for_least_end:
        return least_end.plan(
            "auto",
            problem,
            seed=seed,
            stop=stop,
            progress=progress,
            start=None if start is None else next(iter(start)),
            cores=options.cores,
        )
    if problem.alone is not None:
        return one_route.plan(
            problem.alone,
            seed=seed,
            stop=stop,
            progress=progress,
            start=None if start is None else next(iter(start)),
            options=options,
            proves=options.prove,
            time_value_m_s_per_h=options.time_value_m_s_per_h,
        )
    return many_routes.plan(
        "auto",
        problem,
        seed=seed,
        stop=stop,
        progress=progress,
        start=start,
        options=options,
        goals=Goals(proves=options.prove),
    )
