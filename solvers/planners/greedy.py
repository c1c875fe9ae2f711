"""Greedy planners: as published, and with the one guard that it lacks."""

from __future__ import annotations

import math
import time

import numpy as np

from adr_opt.errors import InputError
from adr_opt.kernels import rules as rule_kernels
from adr_opt.mission import Mission
from adr_opt.planner import Progress
from adr_opt.result import Result, certify
from adr_opt.stop import Stop

from ..search.greedy_order import greedy_sequence

THE_INSTANCES_OWN = -1.0
"""Stands for the instance's default time value."""

GUARDED_BETA = 0.0125
"""Default worth of time of the guarded planner: 45 m/s an hour [m/s per s]."""


def _plan(
    name: str,
    mission: Mission,
    seed: int,
    progress: Progress,
    alpha: float,
    beta: float,
    time_value_m_s_per_h: float,
) -> Result:
    for what, weight in (("alpha", alpha), ("beta", beta)):
        if not math.isfinite(weight) or weight < 0.0:
            raise InputError(f"option {what} = {weight!r} of method {name!r}: must be ≥ 0")
    start = time.perf_counter()
    # What is below 0 stands for the default; what is no number is for the mission to refuse.
    if not time_value_m_s_per_h < 0.0:
        mission = mission.with_time_value(time_value_m_s_per_h)
    rules = mission.rules
    nothing = np.empty(0, dtype=np.int64)
    sequence = greedy_sequence(rules, nothing, alpha, beta, name == "greedy-guarded")
    runtime = time.perf_counter() - start
    progress(float(rule_kernels.collected(rules, sequence)), math.inf)
    return certify(mission, name, sequence, seed=seed, runtime_s=runtime)


def greedy(
    mission: Mission,
    *,
    seed: int,
    stop: Stop,
    progress: Progress,
    alpha: float = 1.0,
    beta: float = 0.0,
    time_value_m_s_per_h: float = THE_INSTANCES_OWN,
) -> Result:
    """The published greedy: the legal target with the least α·ΔV + β·T; refuel if there is none.

    It has no look-ahead for the way back to the station and strands itself. Deterministic; ends
    by itself within a millisecond and does not ask ``stop``.

    Parameters
    ----------
    alpha, beta : float
        Weights of ΔV [per m/s] and of the time from ready to arrival [per s].
    time_value_m_s_per_h : float
        Of all connections to a target, the one with the least ΔV + value · (arrival − ready) is
        looked at. Below 0: the default of the instance, 75.
    """
    return _plan("greedy", mission, seed, progress, alpha, beta, time_value_m_s_per_h)


def greedy_guarded(
    mission: Mission,
    *,
    seed: int,
    stop: Stop,
    progress: Progress,
    alpha: float = 1.0,
    beta: float = GUARDED_BETA,
    time_value_m_s_per_h: float = THE_INSTANCES_OWN,
) -> Result:
    """Greedy that takes a target only if the chaser can refuel after it, or need not any more.

    The same rule as :func:`greedy` with one guard and, by default, a price on time, so that a
    cheap transfer is not waited for while a zone is closed; as quick.
    """
    return _plan("greedy-guarded", mission, seed, progress, alpha, beta, time_value_m_s_per_h)
