"""Master of column generation: the best combination of routes, with dual prices of targets."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import highspy
import numpy as np

from adr_opt.mission.problem import Problem

from ..routes.route_pool import Column
from .subset_rows import Rows, times_paid


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
    cuts : (cuts,) float64
        And for each cut.
    shares : (columns,) float64
        The mixture.
    """

    value: float
    targets: np.ndarray
    kinds: np.ndarray
    cuts: np.ndarray
    shares: np.ndarray


class Master:
    """Linear program: most worth of a combination of routes, each target and chaser at most once.

    And no station refuels more often than it may. What propellant it has is not asked about.

    Parameters
    ----------
    problem : Problem

    Attributes
    ----------
    columns : list of Column
    """

    def __init__(self, problem: Problem) -> None:
        self.columns: list[Column] = []
        self._cuts: list[Rows] = []
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
        self._first_cut = self._highs.getNumRow()

    def add(self, columns: Sequence[Column]) -> None:
        """Add columns."""
        for column in columns:
            taken = column.taken
            cuts = {
                self._first_cut + at: float(times)
                for at, rows in enumerate(self._cuts)
                if (times := times_paid(rows, column.targets))
            }
            rows = np.array([*taken, self._bodies + column.kind, *cuts], dtype=np.int32)
            values = np.array([*taken.values(), 1.0, *cuts.values()])
            self._highs.addCol(column.worth, 0.0, highspy.kHighsInf, rows.size, rows, values)
            self.columns.append(column)

    def cut(self, cuts: Sequence[Rows]) -> None:
        """Add subset-row cuts."""
        for rows in cuts:
            times = np.array([times_paid(rows, column.targets) for column in self.columns])
            at = np.flatnonzero(times).astype(np.int32)
            self._highs.addRow(-highspy.kHighsInf, 1.0, at.size, at, times[at].astype(float))
            self._cuts.append(rows)

    def solve(self) -> Duals:
        """Solve the master."""
        self._highs.run()
        solution = self._highs.getSolution()
        duals = np.array(solution.row_dual)
        return Duals(
            float(self._highs.getInfo().objective_function_value),
            np.maximum(duals[: self._bodies], 0.0),
            np.maximum(duals[self._bodies : self._first_cut], 0.0),
            np.maximum(duals[self._first_cut :], 0.0),
            np.array(solution.col_value),
        )
