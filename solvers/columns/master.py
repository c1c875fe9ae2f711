"""Master of column generation: the best combination of routes, with dual prices of targets."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import highspy
import numpy as np

from adr_opt.mission.problem import Problem

from ..routes.route_pool import Column


class Duals(NamedTuple):
    """A solution of the master.

    Attributes
    ----------
    value : float
        No mixture of the columns is worth more.
    targets : (bodies,) float64
        What is paid for one more of each target, and for one more refuelling at each station.
    kinds : (kinds,) float64
        And for one more chaser of each kind.
    """

    value: float
    targets: np.ndarray
    kinds: np.ndarray


class Master:
    """Linear program: most worth of a combination of routes, each target and chaser at most once.

    And no station refuels more often than it may. What propellant it has is not asked about.

    Parameters
    ----------
    problem : Problem
    """

    def __init__(self, problem: Problem) -> None:
        self._bodies = len(problem.names)
        self._highs = highspy.Highs()
        self._highs.setOptionValue("output_flag", False)
        self._highs.setOptionValue("threads", 1)
        self._highs.changeObjectiveSense(highspy.ObjSense.kMaximize)
        none = np.empty(0)
        for most in problem.limits.of_body:
            self._highs.addRow(-highspy.kHighsInf, float(most), 0, none.astype(np.int32), none)
        for kind in problem.kinds:
            most = float(len(kind.chasers))
            self._highs.addRow(-highspy.kHighsInf, most, 0, none.astype(np.int32), none)

    def add(self, columns: Sequence[Column]) -> None:
        """Add columns."""
        for column in columns:
            taken = column.taken
            rows = np.array([*taken, self._bodies + column.kind], dtype=np.int32)
            values = np.array([*taken.values(), 1.0])
            self._highs.addCol(column.worth, 0.0, highspy.kHighsInf, rows.size, rows, values)

    def solve(self) -> Duals:
        """Solve the master."""
        self._highs.run()
        solution = self._highs.getSolution()
        duals = np.array(solution.row_dual)
        return Duals(
            float(self._highs.getInfo().objective_function_value),
            np.maximum(duals[: self._bodies], 0.0),
            np.maximum(duals[self._bodies :], 0.0),
        )
