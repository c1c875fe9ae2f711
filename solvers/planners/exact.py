"""The exact method: a plan, and a search for better ones that ends when none exists."""

from __future__ import annotations

from collections.abc import Iterable

from adr_opt.common.progress import Progress
from adr_opt.common.stop import Stop
from adr_opt.mission.mission import Mission
from adr_opt.mission.problem import Problem, problem_of
from adr_opt.mission.result import Result
from adr_opt.problem.rules import Follower
from adr_opt.problem.support import refuse

from ..methods import EXACT
from .engines import engine_for
from .options import ExactOptions

LEAST_COST = Follower("option cost", EXACT.follows - {"prizes that fall"}, "leave the option out")
"""Rules followed by proofs of the least ΔV or expense."""


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

    By the first of :data:`.engines.ENGINES` that serves the problem: label setting for one chaser,
    column generation for several.

    Parameters
    ----------
    start : sequence of sequences of int, optional
        A plan to begin with, a route for each chaser, compared with one found by beam search.
    """
    problem = problem_of(problem)
    if options.cost and problem.instance.objective.cost != "duration":
        refuse(problem.instance, LEAST_COST)
    return engine_for("exact", problem).plans["exact"](
        "exact", problem, seed=seed, stop=stop, progress=progress, start=start, options=options
    )
