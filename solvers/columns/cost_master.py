"""Master of cost proofs: the cheapest combination of columns with sufficient worth."""

from __future__ import annotations

from typing import NamedTuple

import highspy
import numpy as np

from adr_opt.mission.problem import Problem

from ..routes.route_pool import Column


class Prices(NamedTuple):
    """A solution of the master.

    Attributes
    ----------
    cost : float
        No mixture of the columns that is worth enough costs less [m/s].
    worth : float
        λ [m/s].
    targets : (bodies,) float64
        π [m/s].
    kinds : (kinds,) float64
        What one more chaser of a kind would save [m/s].
    """

    cost: float
    worth: float
    targets: np.ndarray
    kinds: np.ndarray


class CostMaster:
    """Linear program: cheapest combination of routes with sufficient worth.

    Parameters
    ----------
    problem : Problem
    least_worth : float
    """

    def __init__(self, problem: Problem, least_worth: float) -> None:
        self._bodies = len(problem.names)
        # Worths in tens of thousands would leave the tolerances of the solver behind.
        self._scale = 1.0 / max(least_worth, 1e-300)
        self._highs = highspy.Highs()
        self._highs.setOptionValue("output_flag", False)
        self._highs.setOptionValue("threads", 1)
        none, nobody = np.empty(0), np.empty(0, dtype=np.int32)
        for _ in range(self._bodies):
            self._highs.addRow(-highspy.kHighsInf, 1.0, 0, nobody, none)
        for kind in problem.kinds:
            self._highs.addRow(-highspy.kHighsInf, float(len(kind.chasers)), 0, nobody, none)
        self._highs.addRow(least_worth * self._scale, highspy.kHighsInf, 0, nobody, none)
        self._last = self._bodies + len(problem.kinds)

    def add(self, columns: list[Column]) -> None:
        """Add columns."""
        for column in columns:
            rows = [*sorted(column.targets), self._bodies + column.kind, self._last]
            values = np.ones(len(rows))
            values[-1] = column.worth * self._scale
            self._highs.addCol(
                column.cost, 0.0, highspy.kHighsInf, len(rows), np.array(rows, dtype=np.int32),
                values,
            )  # fmt: skip

    def solve(self) -> Prices:
        """Solve the master."""
        self._highs.run()
        duals = np.array(self._highs.getSolution().row_dual)
        return Prices(
            float(self._highs.getInfo().objective_function_value),
            max(float(duals[self._last]), 0.0) * self._scale,
            np.maximum(-duals[: self._bodies], 0.0),
            np.maximum(-duals[self._bodies : self._last], 0.0),
        )
