"""Costs of a tour: legs on a time grid, and the expense of missions by carried mass."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from adr_opt.kernels.core.compile import inlined, kernel

FORBIDDEN = 65535
"""ΔV units of a forbidden leg."""

BLOCK = 32
"""Number of grid times combined by :func:`nearby`."""

FAR = np.float32(1e30)
"""Cost of an impossible way."""

Costs = npt.NDArray[np.uint16]


class TimeGrid(NamedTuple):
    """The grid of times.

    Attributes
    ----------
    least_gap : int
        Steps from an arrival to the next one in the first place of the costs.
    apart : int
        Least steps from the last arrival of a mission to the launch of the next one.
    unit_m_s : float
        ΔV of one unit of the costs [m/s].
    """

    least_gap: int
    apart: int
    unit_m_s: float


@dataclass(frozen=True)
class Tour:
    """All missions of a campaign.

    Attributes
    ----------
    order : (targets,) int64
    begins : (targets,) bool
        Whether a mission begins with a target.
    at : (targets,) int64
        When each is reached [steps of the grid].
    expense : float
        On the grid; infinite where there is no way through.
    """

    order: npt.NDArray[np.int64]
    begins: npt.NDArray[np.bool_]
    at: npt.NDArray[np.int64]
    expense: float


class TourCosts(NamedTuple):
    """Costs of legs.

    Attributes
    ----------
    legs : (targets, targets, gaps, times) uint16
        By the two targets, the gap from arrival to arrival, and the earlier arrival.
    least : (targets, targets, blocks) uint16
        The least of each pair about each block of times, see :func:`nearby`.
    """

    legs: Costs
    least: Costs


class TourRows(NamedTuple):
    """A tour as rows, with storage for one additional target.

    Attributes
    ----------
    order : (targets + 1,) int64
    begins : (targets + 1,) bool
        Whether a mission begins with a target.
    at : (targets + 1,) int64
        About which time each is reached.
    slope : (targets + 1,) float32
        What another unit costs on the leg to it.
    kit : (targets + 1,) float64
        What one more target costs in its mission, besides legs.
    """

    order: npt.NDArray[np.int64]
    begins: npt.NDArray[np.bool_]
    at: npt.NDArray[np.int64]
    slope: npt.NDArray[np.float32]
    kit: npt.NDArray[np.float64]


class TourExpense(NamedTuple):
    """Expense of a mission by the chaser's mass at launch.

    That is ``fixed + per_kg c + per_kg_squared c²`` with c the kits and the least propellant [kg].

    Attributes
    ----------
    fixed, per_kg, per_kg_squared : float
    dry_kg, kit_kg : float
        Mass of an empty chaser; mass that it leaves at every target.
    exhaust_m_s : float
        Specific impulse times g₀.
    most_propellant_kg : float
    most_missions : int
    """

    fixed: float
    per_kg: float
    per_kg_squared: float
    dry_kg: float
    kit_kg: float
    exhaust_m_s: float
    most_propellant_kg: float
    most_missions: int


OVERWEIGHT = 0.1
"""Penalty per kilogram of propellant beyond the tank, in a plan that is not legal yet."""


@inlined
def expense_of(expense, carried, kits):
    """Expense of a mission, and its increase per kilogram.

    Parameters
    ----------
    expense : TourExpense
    carried : float
        Kits and propellant [kg].
    kits : int
    """
    marginal = expense.per_kg + 2.0 * expense.per_kg_squared * carried
    total = expense.fixed + expense.per_kg * carried + expense.per_kg_squared * carried * carried
    excess = carried - kits * expense.kit_kg - expense.most_propellant_kg
    if excess > 0.0:
        total += OVERWEIGHT * excess
        marginal += OVERWEIGHT
    return total, marginal


@kernel
def nearby(cost, least):
    """Least cost of each pair near each block of times.

    Parameters
    ----------
    cost : (targets, targets, gaps, times) uint16
    least : (targets, targets, blocks) uint16
        Is filled: from half a block before to half a block after.
    """
    targets, _, gaps, times = cost.shape
    for i in range(targets):
        for j in range(targets):
            for block in range(least.shape[2]):
                found = FORBIDDEN
                begin = max(0, block * BLOCK - BLOCK // 2)
                end = min(times, (block + 1) * BLOCK + BLOCK // 2)
                for g in range(gaps):
                    for t in range(begin, end):
                        if cost[i, j, g, t] < found:
                            found = cost[i, j, g, t]
                least[i, j, block] = found


def blocks(times: int) -> int:
    """Number of blocks."""
    return math.ceil(times / BLOCK)
