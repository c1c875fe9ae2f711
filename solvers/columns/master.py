"""Master of column generation: the best combination of routes, with its dual prices.

That is the one with the most worth; or, where a least worth is asked for, the cheapest one of those
that have it.
"""

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
        No mixture of the columns is worth more; or, if worth is asked for, costs less.
    worth : float
        Cost of one more unit of the worth that is asked for.
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
    worth: float
    targets: np.ndarray
    kinds: np.ndarray
    cuts: np.ndarray
    shares: np.ndarray


class Master:
    """Linear program: a combination of routes, each target and chaser at most once.

    And no station refuels more often than it may, where worth is maximised; what propellant it has
    is not asked about, and where cost is minimised neither are refuellings.

    Parameters
    ----------
    problem : Problem
    least_worth : float, optional
        What a mixture has to be worth, at least cost; by default its worth is maximised.

    Attributes
    ----------
    columns : list of Column
    """

    def __init__(self, problem: Problem, least_worth: float | None = None) -> None:
        self.columns: list[Column] = []
        self._cuts: list[Rows] = []
        self._bodies, self._minimises = len(problem.names), least_worth is not None
        self._highs = highspy.Highs()
        self._highs.setOptionValue("output_flag", False)
        self._highs.setOptionValue("threads", 1)
        if not self._minimises:
            self._highs.changeObjectiveSense(highspy.ObjSense.kMaximize)
        most = [*problem.limits.of_body, *(len(kind.chasers) for kind in problem.kinds)]
        none, nobody = np.empty(0), np.empty(0, dtype=np.int32)
        for each in most:
            self._highs.addRow(-highspy.kHighsInf, float(each), 0, nobody, none)
        # Worths in tens of thousands would leave the tolerances of the solver behind.
        self._scale = 1.0 / max(least_worth or 1.0, 1e-300)
        self._first_cut = self._worth_row = len(most)
        if least_worth is not None:
            least = least_worth * self._scale
            self._highs.addRow(least, highspy.kHighsInf, 0, nobody, none)
            self._first_cut += 1

    def add(self, columns: Sequence[Column]) -> None:
        """Add columns."""
        for column in columns:
            taken = dict.fromkeys(sorted(column.targets), 1.0) if self._minimises else column.taken
            rows = {**taken, self._bodies + column.kind: 1.0}
            if self._minimises:
                rows[self._worth_row] = column.worth * self._scale
            rows |= {
                self._first_cut + at: float(times)
                for at, cut in enumerate(self._cuts)
                if (times := times_paid(cut, column.targets))
            }
            self._highs.addCol(
                column.cost if self._minimises else column.worth,
                0.0,
                highspy.kHighsInf,
                len(rows),
                np.array([*rows], dtype=np.int32),
                np.array([*rows.values()]),
            )
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
        worth = 0.0
        if self._minimises:
            worth = max(float(duals[self._worth_row]), 0.0) * self._scale
            duals = -duals  # of rows that have an upper limit
        return Duals(
            float(self._highs.getInfo().objective_function_value),
            worth,
            np.maximum(duals[: self._bodies], 0.0),
            np.maximum(duals[self._bodies : self._worth_row], 0.0),
            np.maximum(duals[self._first_cut :], 0.0),
            np.array(solution.col_value),
        )
