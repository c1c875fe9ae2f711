"""The default planner: an anytime search with a concurrent proof."""

from __future__ import annotations

from collections.abc import Iterable

from adr_opt.common.progress import Progress
from adr_opt.common.stop import Stop
from adr_opt.mission.mission import Mission
from adr_opt.mission.problem import Problem, problem_of
from adr_opt.mission.result import Result

from .engines import engine_for
from .options import AutoOptions


def auto(
    problem: Problem | Mission,
    *,
    seed: int,
    stop: Stop,
    progress: Progress,
    start: Iterable[Iterable[int]] | None = None,
    options: AutoOptions = AutoOptions(),
) -> Result:
    """The best plan within the time, with a proof if one is found.

    Plans by the first of :data:`.engines.ENGINES` that serves the problem. For most it begins with
    the guarded greedy plan and the searches of ``beam``, behind which it never falls for that
    reason. Then rounds, each with more effort than the one before, of search and of proof side by
    side. Ends when the incumbent meets the bound, or when ``stop`` says so. The same seed and the
    same number of iterations (rounds) give the same plan; ``jobs`` does not change it.

    Parameters
    ----------
    start : sequence of sequences of int, optional
        A plan to begin from: bodies in order, for each chaser.
    """
    problem = problem_of(problem)
    return engine_for("auto", problem).plans["auto"](
        "auto", problem, seed=seed, stop=stop, progress=progress, start=start, options=options
    )
