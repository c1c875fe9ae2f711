"""Set packing with HiGHS: which of many columns to take, no target twice."""

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
"""Of more columns HiGHS takes far longer to find some that need not be looked at than it does
without, and does not look at the clock meanwhile."""

LEAST_S = 0.1
"""It is given as much time at least."""

LEAST_CARRY, MOST_CARRY = -2.0, 1e4
"""What is carried from a digit to the next: as many columns are taken as there are chasers."""

SOLVED, INFEASIBLE = 0, 2
"""How :func:`scipy.optimize.milp` says what became of it."""


class Packed(NamedTuple):
    """What became of a question for the cheapest columns.

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
    """The columns that keep to some constraints and cost least together.

    Parameters
    ----------
    costs : (columns,) float64
        HiGHS leaves an absolute gap of 10⁻⁶.
    constraints : sequence of LinearConstraint
    time_limit_s : float
    gap : float, optional
        Relative gap at which it may end; that of HiGHS by default.
    carries : int
        The last so many variables are no columns: see :mod:`.digits`.
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
    """No target on two of the columns taken, and no more of a kind than there are chasers.

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
