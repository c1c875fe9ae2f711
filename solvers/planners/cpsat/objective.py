"""Objective of the constraint-programming model."""

from __future__ import annotations

import numpy as np
from ortools.sat.python import cp_model

from .variables import CpSatVariables


class CpSatObjective:
    """The objective of the model: the sum of the prizes, in whole steps.

    Parameters
    ----------
    block : CpModel
        Gets the objective.
    variables : CpSatVariables
    worth : (bodies,) int64
        Prizes in steps.
    """

    def __init__(
        self, block: cp_model.CpModel, variables: CpSatVariables, worth: np.ndarray
    ) -> None:
        self._block = block
        self._collect(variables, worth.tolist())

    def _collect(self, variables: CpSatVariables, worth: list[int]) -> None:
        """Collect the prize of each serviced target."""
        visits = list(variables.visit.items())
        self._block.maximize(
            cp_model.LinearExpr.weighted_sum(
                [visit for _, visit in visits], [worth[target] for target, _ in visits]
            )
        )
