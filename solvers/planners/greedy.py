"""Greedy planners: as published, and with a refuelling guard."""

from __future__ import annotations

import math
from dataclasses import dataclass
from itertools import chain

import numpy as np
import numpy.typing as npt

from adr_opt.common.clock import now_s
from adr_opt.common.options import Options, option
from adr_opt.common.progress import Progress
from adr_opt.common.stop import Stop
from adr_opt.mission.certified import certify_routes
from adr_opt.mission.mission import Mission
from adr_opt.mission.problem import Problem, problem_of
from adr_opt.mission.result import Result

from ..beams.greedy_order import GUARDED_BETA, greedy_sequence
from ..routes.one_chaser import one_after_another


@dataclass(frozen=True)
class GreedyOptions(Options, method="greedy"):
    """Options of the planner ``greedy``."""

    alpha: float = option(1.0, "Weight of ΔV in the cost of a move.", unit="per m/s", least=0.0)
    beta: float = option(
        0.0,
        "Weight of the time from ready to arrival in the cost of a move.",
        unit="per s",
        least=0.0,
    )
    time_value_m_s_per_h: float = option(
        -1.0,
        "Value of time: of all connections to a target, the one of least ΔV + value · (arrival − "
        "ready) is considered. Below 0: the default of the instance, 75.",
        unit="m/s per h",
    )


@dataclass(frozen=True)
class GuardedOptions(GreedyOptions, method="greedy-guarded"):
    """Options of the planner ``greedy-guarded``."""

    beta: float = option(
        -1.0,
        "Weight of the time from ready to arrival in the cost of a move. Below 0: 0.0125, which is "
        "45 m/s per hour, or less where planes drift.",
        unit="per s",
    )


def _order(name: str, mission: Mission, options: GreedyOptions) -> npt.NDArray[np.int64]:
    if options.time_value_m_s_per_h >= 0.0:
        mission = mission.with_time_value(options.time_value_m_s_per_h)
    beta = options.beta if options.beta >= 0.0 else GUARDED_BETA * mission.instance.hurry
    return greedy_sequence(
        mission, alpha=options.alpha, beta=beta, guarded=name == "greedy-guarded"
    )


def _plan(
    name: str, problem: Problem | Mission, seed: int, progress: Progress, options: GreedyOptions
) -> Result:
    start = now_s()
    problem = problem_of(problem)
    routes = one_after_another(problem, lambda each: _order(name, each, options))
    runtime = now_s() - start
    progress(float(problem.collected(chain.from_iterable(routes))), math.inf)
    return certify_routes(problem, name, routes, seed=seed, runtime_s=runtime)


def greedy(
    problem: Problem | Mission,
    *,
    seed: int,
    stop: Stop,
    progress: Progress,
    options: GreedyOptions = GreedyOptions(),
) -> Result:
    """The published greedy: the legal target with the least α·ΔV + β·T, or else a refuelling.

    It has no look-ahead for the way back to the station and strands itself. Of several chasers each
    goes for what those before have left. Deterministic; ends by itself within a millisecond and
    does not ask ``stop``.
    """
    return _plan("greedy", problem, seed, progress, options)


def greedy_guarded(
    problem: Problem | Mission,
    *,
    seed: int,
    stop: Stop,
    progress: Progress,
    options: GuardedOptions = GuardedOptions(),
) -> Result:
    """Greedy restricted to targets after which the chaser can refuel or need not.

    The same rule as :func:`greedy` with one guard and, by default, a price on time, so that a
    cheap transfer is not waited for while a zone is closed; as quick.
    """
    return _plan("greedy-guarded", problem, seed, progress, options)
