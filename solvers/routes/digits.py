"""Exact comparison of sums of large prizes with HiGHS, which resolves only a dozen digits.

A sum of whole numbers reaches a goal exactly if its digits do, from the last to the first, with
what is carried from each to the next: of digits S₀, S₁ … of the numbers summed, and g₀, g₁ … of the
goal, in base B, there are whole numbers t₀, t₁ … with

    S₀ − g₀ ≥ B t₀,      S₁ + t₀ − g₁ ≥ B t₁,      …,      S_L + t_{L−1} − g_L ≥ 0.

Each of these rows has small coefficients, so that no tolerance counts.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
from scipy.optimize import LinearConstraint
from scipy.sparse import csc_array, hstack

from adr_opt.mission.problem import Problem

BASE = 2**12
"""Base of the digits: a thousand columns, integral to 10⁻⁶, err in a sum by far less than 1."""

FEW = 1e6
"""Sums of numbers below this are compared directly."""

PARTS = 64
"""Units per smallest resolvable difference, for prizes without a common step."""

OFF = 0.25
"""Largest error in sums of integers."""


def has_large(problem: Problem) -> bool:
    """Whether prizes have too many steps for direct comparison of sums."""
    largest = float(problem.planning_prizes.max(initial=0.0))
    step = problem.prize_step
    return largest > 0.0 and (not step or largest > FEW * step)


def in_units(problem: Problem, worths: Sequence[float], goal: float) -> tuple[list[int], int]:
    """Worths and a goal as integers, rounded in favour of the worths if they have no step."""
    step = problem.prize_step
    if step:
        return [round(worth / step) for worth in worths], math.ceil(goal / step - OFF)
    unit = problem.prize_resolution / PARTS
    return [math.ceil(worth / unit) for worth in worths], math.floor(goal / unit)


def reaching(numbers: Sequence[int], goal: int) -> tuple[LinearConstraint, int]:
    """Constraints that columns sum to at least a goal, and the number of carry variables."""
    levels, largest = 1, max([goal, *numbers])
    while BASE**levels <= largest:
        levels += 1
    carries = levels - 1
    matrix = np.zeros((levels, len(numbers) + carries))
    least = np.empty(levels)
    for level in range(levels):
        place = BASE**level
        last = level == carries
        digits = [number // place % BASE for number in numbers]
        matrix[level, : len(numbers)] = digits
        if level:
            matrix[level, len(numbers) + level - 1] = 1.0
        if not last:
            matrix[level, len(numbers) + level] = -BASE
        least[level] = (goal // place if last else goal // place % BASE) - OFF
    return LinearConstraint(csc_array(matrix), least, np.inf), carries


def beside(constraint: LinearConstraint, carries: int) -> LinearConstraint:
    """A constraint on columns, extended by zeros for carry variables."""
    matrix = csc_array(constraint.A)
    wider = hstack([matrix, csc_array((matrix.shape[0], carries))], format="csc")
    return LinearConstraint(wider, constraint.lb, constraint.ub)
