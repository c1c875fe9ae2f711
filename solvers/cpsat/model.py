"""The network as a constraint programming model: CP-SAT solves it."""

from __future__ import annotations

import math

import numpy as np
from ortools.sat.python import cp_model

from ..exact_models.answer import Answer, Hear
from ..exact_models.cp_sat_run import run
from ..exact_models.network import Network, bodies_along
from ..exact_models.steps import in_steps
from .constraints import Constraints
from .objective import Objective
from .variables import Variables

STEPS_PER_M_S = 1e5
"""ΔV is counted in steps of 0.01 mm/s. Those of a leg are rounded down and the budget up, so that
no plan is lost; that is a relaxation by less than a step per leg, and paths are re-timed."""


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
    start : list of int
        Arcs of a plan to begin from, from the start on.
    """

    def __init__(
        self,
        network: Network,
        prize: np.ndarray,
        unit: float,
        budget: float,
        start: list[int],
    ) -> None:
        self._network = network
        steps = math.ceil(budget * STEPS_PER_M_S)
        cost = np.floor(network.delta_v * STEPS_PER_M_S).astype(np.int64)
        worth, self._unit = in_steps(prize, unit)
        self._block = cp_model.CpModel()
        self._variables = Variables(self._block, network, steps)
        self._constraints = Constraints(self._block, network, self._variables, cost, steps)
        self._objective = Objective(self._block, self._variables, worth)
        self._variables.begin_from(self._block, network, start, cost)

    def forbid(self, arcs: list[int]) -> None:
        """Let no path use all of these arcs, from the next solve on."""
        self._constraints.forbid(arcs)

    def solve(self, *, seed: int, hear: Hear) -> Answer:
        """Solve the model.

        Parameters
        ----------
        seed : int
        hear : Hear
            Told of bounds and asked for the time left.
        """
        solver, found, bound = run(self._block, self._unit, seed=seed, hear=hear)
        sequence = None
        if found:
            chosen = [
                arc for arc, move in enumerate(self._variables.move) if solver.boolean_value(move)
            ]
            sequence = bodies_along(self._network, chosen)
        return Answer(sequence, bound, int(solver.num_branches))
