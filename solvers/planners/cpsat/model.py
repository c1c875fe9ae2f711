"""The network as a constraint-programming model, solved by CP-SAT."""

from __future__ import annotations

import math

import numpy as np
from ortools.sat.python import cp_model

from adr_opt.kernels.rules.rules import Rules

from ...models.answer import Hear, SolverAnswer
from ...models.cp_sat_run import run
from ...models.network import SolverNetwork
from ...models.steps import in_steps
from .constraints import CpSatConstraints
from .objective import CpSatObjective
from .variables import CpSatVariables

STEPS_PER_M_S = 1e5
"""ΔV is counted in steps of 0.01 mm/s. Those of a leg are rounded down and the budget up, so that
no plan is lost; the relaxation is below a step per leg, and paths are re-timed."""


class CpSatModel:
    """The best path of a network, as a constraint programming model.

    Parameters
    ----------
    network : SolverNetwork
    rules : adr_opt.kernels.rules.rules.Rules
    unit : float
        The objective is counted in multiples of this.
    start : list of int
        Legs of a plan to begin from, from the start on.
    """

    def __init__(self, network: SolverNetwork, rules: Rules, unit: float, start: list[int]) -> None:
        steps = math.ceil(rules.budget * STEPS_PER_M_S)
        cost = np.floor(network.delta_v * STEPS_PER_M_S).astype(np.int64).tolist()
        worth, self._unit = in_steps(rules.prize, unit)
        self._block = cp_model.CpModel()
        self._variables = CpSatVariables(self._block, network, rules, steps)
        self._constraints = CpSatConstraints(
            self._block, network, self._variables, rules, cost, steps
        )
        self._objective = CpSatObjective(self._block, self._variables, worth)
        self._variables.begin_from(self._block, network, start, cost)

    def forbid(self, groups: list[list[int]]) -> None:
        """Forbid paths with a leg from each of these groups, from the next solve on."""
        self._constraints.forbid(groups)

    def solve(self, *, seed: int, hear: Hear) -> SolverAnswer:
        """Solve the model.

        Parameters
        ----------
        seed : int
        hear : Hear
            Told of bounds and asked for the time left.
        """
        solver, found, bound = run(self._block, self._unit, seed=seed, hear=hear)
        legs = None
        if found:
            legs = tuple(
                leg for leg, move in enumerate(self._variables.move) if solver.boolean_value(move)
            )
        return SolverAnswer(legs, bound, int(solver.num_branches))
