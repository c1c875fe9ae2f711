"""The network as a constraint programming model for OR-Tools CP-SAT."""

from __future__ import annotations

import math
import threading

import numpy as np
from ortools.sat.python import cp_model

from ..exact_models.answer import Answer, Hear
from ..exact_models.network import Network, bodies_along
from .constraints import Constraints
from .objective import Objective
from .variables import Variables

STEPS_PER_M_S = 1e5
"""ΔV is counted in steps of 0.01 mm/s. Those of a leg are rounded down and the budget up, so that
no plan is lost; that is a relaxation by less than a step per leg, and paths are re-timed."""

PRIZE_STEPS = 2**40
"""Prizes are counted in steps of about their sum divided by this, rounded up, unless the unit
given counts them exactly."""

POLL_S = 0.05
"""How often CP-SAT is asked whether it shall stop."""

SEEDS = 2**31
"""CP-SAT takes seeds below this."""


class Model:
    """The best path of a network, as a constraint programming model.

    Parameters
    ----------
    network : Network
    prize : (bodies,) float64
    unit : float
        The objective is counted in multiples of this.
    budget : float
        [m/s].
    start : list of int or None
        Arcs of a plan to begin from.
    """

    def __init__(
        self,
        network: Network,
        prize: np.ndarray,
        unit: float,
        budget: float,
        start: list[int] | None,
    ) -> None:
        self._network = network
        steps = math.ceil(budget * STEPS_PER_M_S)
        cost = np.floor(network.delta_v * STEPS_PER_M_S).astype(np.int64)
        self._unit = unit
        if np.any(prize % unit) or prize.sum() / unit > PRIZE_STEPS:
            self._unit = max(float(prize.sum()), unit) / PRIZE_STEPS
        worth = np.ceil(prize / self._unit).astype(np.int64)
        self._block = cp_model.CpModel()
        self._variables = Variables(self._block, network, steps)
        self._constraints = Constraints(self._block, network, self._variables, cost, steps)
        self._objective = Objective(self._block, self._variables, worth)
        if start is not None:
            self._variables.begin_from(self._block, network, start, cost)

    def solve(self, *, seed: int, jobs: int, hear: Hear) -> Answer:
        """Solve the model.

        Parameters
        ----------
        seed : int
        jobs : int
            Threads, 0 for all cores.
        hear : Hear
            Told of bounds and asked for the time left.
        """
        solver = cp_model.CpSolver()
        settings = solver.parameters
        settings.num_workers = int(__import__('os').environ.get('W','1'))
        settings.interleave_search = 'I' in __import__('os').environ
        settings.linearization_level=int(__import__('os').environ.get('L','1'))
        settings.random_seed = seed % SEEDS
        settings.catch_sigint_signal = False
        if math.isfinite(hear.remaining_s()):
            settings.max_time_in_seconds = max(0.0, hear.remaining_s())

        def improved(bound: float) -> None:
            if hear.bound(bound * self._unit):
                solver.stop_search()

        solver.best_bound_callback = improved
        done = threading.Event()

        def watch() -> None:
            while not done.wait(POLL_S):
                if hear.remaining_s() <= 0.0:
                    solver.stop_search()

        watcher = threading.Thread(target=watch, daemon=True)
        watcher.start()
        try:
            status = solver.solve(self._block)
        finally:
            done.set()
            watcher.join()
        sequence, bound = None, math.inf
        if status in (cp_model.OPTIMAL, cp_model.FEASIBLE):
            bound = solver.best_objective_bound * self._unit
            chosen = [
                arc
                for arc, move in enumerate(self._variables.move)
                if solver.boolean_value(move)
            ]
            sequence = bodies_along(self._network, chosen)
        return Answer(sequence, bound, int(solver.num_branches))
