"""Set packing with HiGHS: a choice of columns with no target twice."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from scipy.optimize import Bounds, LinearConstraint, milp
from scipy.sparse import csc_array

from adr_opt.mission.problem import Problem
from adr_opt.plan.station_limits import Use

from .one_chaser import FloatArray

PRESOLVED = 2_000
"""Maximum number of columns with presolve. Beyond it, HiGHS's presolve takes far longer than it
saves, and ignores the time limit."""

LEAST_S = 0.1
"""Least time limit [s]."""

LEAST_CARRY, MOST_CARRY = -2.0, 1e4
"""Range of carries between digits: at most one column per chaser is taken."""

SOLVED, INFEASIBLE = 0, 2
"""Status values of :func:`scipy.optimize.milp`."""


class Packed(NamedTuple):
    """Outcome of a search for the cheapest columns.

    Attributes
    ----------
    taken : list of int or None
        Numbers of columns, the cheapest that were found; None if none were.
    least : float
        Proven: no choice costs less, up to the tolerances of HiGHS; −inf if nothing is, and +inf
        where there is no choice.
    solved : bool
        Whether nothing is left to find out.
    """

    taken: list[int] | None
    least: float
    solved: bool


def cheapest_of(
    costs: FloatArray,
    constraints: Sequence[LinearConstraint],
    time_limit_s: float,
    gap: float | None = None,
    carries: int = 0,
) -> Packed:
    """The cheapest columns that satisfy some constraints.

    Parameters
    ----------
    costs : (columns,) float64
        HiGHS leaves an absolute gap of 10⁻⁶.
    constraints : sequence of LinearConstraint
    time_limit_s : float
    gap : float, optional
        Relative gap at which it may end; that of HiGHS by default.
    carries : int
        Number of trailing variables that are no columns: see :mod:`.digits`.
    """
    columns = costs.size - carries
    least_each = np.append(np.zeros(columns), np.full(carries, LEAST_CARRY))
    most_each = np.append(np.ones(columns), np.full(carries, MOST_CARRY))
    options = {"time_limit": max(time_limit_s, LEAST_S), "presolve": costs.size <= PRESOLVED}
    if gap is not None:
        options["mip_rel_gap"] = gap
    found = milp(
        costs,
        integrality=np.ones(costs.size),
        bounds=Bounds(least_each, most_each),
        constraints=constraints,
        options=options,
    )
    if found.x is None:
        none = found.status == INFEASIBLE
        return Packed(None, math.inf if none else -math.inf, none)
    least = -math.inf if found.mip_dual_bound is None else float(found.mip_dual_bound)
    taken = np.flatnonzero(found.x[:columns] > 0.5).tolist()
    return Packed(taken, least, found.status == SOLVED)


def packing(
    problem: Problem,
    columns: Sequence[tuple[int, frozenset[int]]],
    uses: Sequence[Use] | None = None,
    *,
    all_flown: bool = False,
) -> LinearConstraint:
    """Constraints: no target on two chosen columns, and at most as many of a type as chasers.

    Parameters
    ----------
    problem : Problem
    columns : sequence of (kind, targets)
    uses : sequence of tuple of float, optional
        What they take of stations, which is no more than there is; not asked about by default.
    all_flown : bool
        Whether one is taken for each chaser that has to fly, because it does not start at its end.
    """
    bodies, kinds, limits = len(problem.names), len(problem.kinds), problem.limits.most.size
    rows, values, ends = [], [], [0]
    for at, (kind, targets) in enumerate(columns):
        rows += [*sorted(targets), bodies + kind]
        values += [1.0] * (len(targets) + 1)
        if uses is not None:
            rows += range(bodies + kinds, bodies + kinds + limits)
            values += uses[at]
        ends.append(len(rows))
    matrix = csc_array(
        (np.array(values), np.array(rows), np.array(ends)),
        shape=(bodies + kinds + limits, len(columns)),
    )
    most = np.ones(bodies + kinds + limits)
    most[bodies : bodies + kinds] = [len(kind.chasers) for kind in problem.kinds]
    most[bodies + kinds :] = problem.limits.most
    least = np.full(most.size, -np.inf)
    if all_flown:
        for number, group in enumerate(problem.kinds):
            if not group.mission.may_stop(()):
                least[bodies + number] = len(group.chasers)
    return LinearConstraint(matrix, least, most)
