"""What a plan is worth."""

from __future__ import annotations

import numpy as np
import pyomo.environ as pyo

from ...models.network import Network
from .variables import Variables


class Objective:
    """The objective of the model: the sum of the prizes, in units.

    Parameters
    ----------
    block : pyomo.environ.ConcreteModel
        Gets the objective.
    network : Network
    variables : Variables
    prize : (bodies,) float64
        In units.
    """

    def __init__(
        self,
        block: pyo.ConcreteModel,
        network: Network,
        variables: Variables,
        prize: np.ndarray,
    ) -> None:
        self._block = block
        self._collect(variables, prize[network.destination].tolist())

    def _collect(self, variables: Variables, worth: list[float]) -> None:
        """Collect the prize of each body that is moved to; only those of targets are not 0."""
        self._block.prizes = pyo.Objective(
            expr=sum(prize * variables.move[leg] for leg, prize in enumerate(worth) if prize),
            sense=pyo.maximize,
        )
