"""A run of CP-SAT that reports bounds and can be stopped."""

from __future__ import annotations

import math
import threading

from ortools.sat.python import cp_model

from .answer import Hear
from .cp_sat_solver import cp_sat

POLL_S = 0.05
"""Interval at which the stopping criterion is queried [s]."""


def run(
    model: cp_model.CpModel, unit: float, *, seed: int, hear: Hear, effort: float = math.inf
) -> tuple[cp_model.CpSolver, bool, float]:
    """Maximise a model.

    Parameters
    ----------
    model : CpModel
    unit : float
        What one step of the objective is worth.
    seed : int
    hear : Hear
    effort : float
        Limit in CP-SAT's deterministic time, about seconds: with it alone, the same answer on any
        machine.

    Returns
    -------
    solver : CpSolver
        Holds the values of the best solution.
    found : bool
        Whether there is one.
    upper_bound : float
        +inf if nothing was proven, −inf if there is no solution.
    """
    solver = cp_sat(seed, hear.remaining_s(), effort)
    solver.parameters.linearization_level = 2  # several times as quick as 1 here
    bounds = []

    def improved(bound: float) -> None:
        bounds.append(bound)
        if hear.bound(bound * unit):
            solver.stop_search()

    solver.best_bound_callback = improved
    done = threading.Event()

    def watch() -> None:
        while not done.wait(POLL_S):
            if hear.remaining_s() <= 0.0:
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
