"""Objective of the mixed-integer program."""

from __future__ import annotations

import numpy as np
import pyomo.environ as pyo

from ...models.solver_network import SolverNetwork
from .variables import MipVariables


class MipObjective:
    """The objective of the model: the sum of the prizes, in units.

    Parameters
    ----------
    block : pyomo.environ.ConcreteModel
        Gets the objective.
    network : SolverNetwork
    variables : MipVariables
    prize : (bodies,) float64
        In units.
    """

    def __init__(
        self,
        block: pyo.ConcreteModel,
        network: SolverNetwork,
        variables: MipVariables,
        prize: np.ndarray,
    ) -> None:
        self._block = block
        self._collect(variables, prize[network.destination].tolist())

    def _collect(self, variables: MipVariables, worth: list[float]) -> None:
        """Collect the prize of each body entered, which is non-zero only for targets."""
        self._block.prizes = pyo.Objective(
            expr=sum(prize * variables.move[leg] for leg, prize in enumerate(worth) if prize),
            sense=pyo.maximize,
        )
