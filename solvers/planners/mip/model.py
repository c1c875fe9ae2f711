"""The network as a mixed-integer program, written by Pyomo and solved by HiGHS."""

from __future__ import annotations

import math

import highspy
import numpy as np
import pyomo.environ as pyo
from pyomo.repn.plugins.standard_form import LinearStandardFormCompiler

from adr_opt.kernels.rules.rules import Rules

from ...models.course import Hear, SolverAnswer
from ...models.solver_network import SolverNetwork
from .constraints import MipConstraints
from .variables import MipVariables, collect_prizes

TOLERANCE = 1e-7
"""Tolerance of HiGHS, in units of the objective and shares of the budget."""

GUARD = 2.0 * TOLERANCE
"""Relative increase of HiGHS's bound, as it drops what is better than its best by its tolerance."""

SEEDS = 2**31
"""Upper limit of HiGHS's seeds."""


class MipModel:
    """The best path of a network, as a mixed-integer program.

    Pyomo's own interfaces to HiGHS redirect the output of the whole process while they solve, and
    the present one takes no start. So Pyomo compiles the model to a matrix, which HiGHS is given.

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
        self._unit = unit
        self._block = pyo.ConcreteModel()
        self._variables = MipVariables(self._block, network, rules)
        self._constraints = MipConstraints(self._block, network, self._variables, rules)
        collect_prizes(self._block, network, self._variables, rules.prize / unit)
        self._variables.begin_from(network, start, rules)

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
        form = LinearStandardFormCompiler().write(self._block, set_sense=None)
        solver = highspy.Highs()
        solver.silent()
        for name, value in {
            "random_seed": seed % SEEDS,
            "mip_rel_gap": 0.0,
            "mip_abs_gap": 0.0,
            "mip_feasibility_tolerance": TOLERANCE,
            "time_limit": min(max(0.0, hear.remaining_s()), highspy.kHighsInf),
        }.items():
            solver.setOptionValue(name, value)
        solver.passModel(_program(form))
        solution = highspy.HighsSolution()
        solution.col_value = [float(column.value) for column in form.columns]
        solver.setSolution(solution)

        def interrupt(event) -> None:
            if hear.bound(self._bound(event.data_out.mip_dual_bound)):
                event.interrupt()

        solver.cbMipInterrupt += interrupt
        solver.solve()
        info = solver.getInfo()
        if solver.getModelStatus() == highspy.HighsModelStatus.kInfeasible:
            return SolverAnswer(None, -math.inf, max(0, info.mip_node_count))
        legs = None
        if info.primal_solution_status == 2:
            values = solver.getSolution().col_value
            place = {id(column): number for number, column in enumerate(form.columns)}
            legs = tuple(
                leg for leg, move in self._variables.move.items() if values[place[id(move)]] > 0.5
            )
        return SolverAnswer(legs, self._bound(info.mip_dual_bound), max(0, info.mip_node_count))

    def _bound(self, dual_bound: float) -> float:
        """HiGHS's bound in prizes, on the safe side of its tolerances."""
        if not math.isfinite(dual_bound):
            return math.inf
        return self._unit * (dual_bound + GUARD * max(1.0, abs(dual_bound)))


def _program(form) -> highspy.HighsLp:
    """A compiled model in HiGHS's form."""
    program = highspy.HighsLp()
    columns, rows = form.A.shape[1], form.A.shape[0]
    program.num_col_, program.num_row_ = columns, rows
    program.sense_ = highspy.ObjSense.kMaximize
    program.col_cost_ = np.asarray(form.c.todense()).ravel()
    program.col_lower_ = np.zeros(columns)
    whole = [column.is_binary() for column in form.columns]
    program.col_upper_ = np.where(whole, 1.0, highspy.kHighsInf)
    program.integrality_ = [
        highspy.HighsVarType.kInteger if is_whole else highspy.HighsVarType.kContinuous
        for is_whole in whole
    ]
    program.row_lower_ = np.full(rows, -highspy.kHighsInf)
    program.row_upper_ = np.asarray(form.rhs, dtype=float)
    matrix = form.A.tocsc()
    program.a_matrix_.format_ = highspy.MatrixFormat.kColwise
    program.a_matrix_.start_ = matrix.indptr
    program.a_matrix_.index_ = matrix.indices
    program.a_matrix_.value_ = matrix.data
    return program
