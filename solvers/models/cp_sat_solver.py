"""Solvers of CP-SAT, all with the same settings."""

from __future__ import annotations

import math

from ortools.sat.python import cp_model

SEEDS = 2**31
"""Upper limit of CP-SAT's seeds."""


def cp_sat(seed: int, remaining_s: float, effort: float = math.inf) -> cp_model.CpSolver:
    """A solver with one thread, as several would make results depend on timing.

    Parameters
    ----------
    seed : int
    remaining_s : float
        Time limit; +inf for none [s].
    effort : float
        Limit in CP-SAT's deterministic time, about seconds: with it alone, the same answer on any
        machine.

    Returns
    -------
    CpSolver
    """
    solver = cp_model.CpSolver()
    settings = solver.parameters
    settings.num_workers = 1
    settings.random_seed = seed % SEEDS
    settings.catch_sigint_signal = False
    # An overflow in this part of presolving makes CP-SAT prove wrong optima: google/or-tools#5293.
    # Until that is mended it is left out.
    settings.presolve_inclusion_work_limit = 0
    if math.isfinite(effort):
        settings.max_deterministic_time = effort
    if math.isfinite(remaining_s):
        settings.max_time_in_seconds = max(0.0, remaining_s)
    return solver
