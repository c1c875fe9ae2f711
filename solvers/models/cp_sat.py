"""Solvers of CP-SAT, all with the same settings, and a run that can be stopped."""

from __future__ import annotations

import math
import threading
from collections.abc import Callable

from ortools.sat.python import cp_model

SEEDS = 2**31
"""Upper limit of CP-SAT's seeds."""

POLL_S = 0.05
"""Interval at which the stopping criterion is queried [s]."""


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


def run(
    model: cp_model.CpModel,
    unit: float,
    *,
    seed: int,
    hear: Callable[[float], bool],
    remaining_s: Callable[[], float],
    effort: float,
) -> tuple[cp_model.CpSolver, bool, float]:
    """Maximise a model.

    Parameters
    ----------
    model : CpModel
    unit : float
        What one step of the objective is worth.
    seed : int
    hear : callable
        Told of a proven bound; says whether to stop.
    remaining_s : callable
        Seconds that may still be used.
    effort : float
        As :func:`cp_sat` takes it.

    Returns
    -------
    solver : CpSolver
        Holds the values of the best solution.
    found : bool
        Whether there is one.
    upper_bound : float
        +inf if nothing was proven, −inf if there is no solution.
    """
    solver = cp_sat(seed, remaining_s(), effort)
    solver.parameters.linearization_level = 2  # several times as quick as 1 here
    bounds = []

    def improved(bound: float) -> None:
        bounds.append(bound)
        if hear(bound * unit):
            solver.stop_search()

    solver.best_bound_callback = improved
    done = threading.Event()

    def watch() -> None:
        while not done.wait(POLL_S):
            if remaining_s() <= 0.0:
                solver.stop_search()

    watcher = threading.Thread(target=watch, name="cp-sat watch", daemon=True)
    watcher.start()
    try:
        status = solver.solve(model)
    finally:
        done.set()
        watcher.join()
    found = status in (cp_model.OPTIMAL, cp_model.FEASIBLE)
    if found:
        bounds.append(solver.best_objective_bound)
    elif status == cp_model.INFEASIBLE:
        bounds.append(-math.inf)
    return solver, found, min(bounds, default=math.inf) * unit
