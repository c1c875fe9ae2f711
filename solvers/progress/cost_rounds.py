"""Common parts of cost proofs, for one chaser or a campaign."""

from __future__ import annotations

from collections.abc import Callable
from contextlib import closing
from typing import Protocol

from adr_opt.common.tolerance import COST_RELATIVE
from adr_opt.mission.prizes import Prizes

RELATIVE = COST_RELATIVE
"""Largest excess over the bound at which a cost counts as least, as a share of it."""


SLACK_WORTH = 1e-9
"""Relative reduction of the goal, by which the bound on the cost falls."""


class CostRounds(Protocol):
    """Rounds of a proof of the least ΔV of plans with sufficient worth.

    Attributes
    ----------
    bound : float
        No plan worth as much costs less [m/s].
    done : bool
        Nothing is left to do.
    """

    bound: float
    done: bool

    def advance(self) -> None:
        """One round."""

    @property
    def counters(self) -> dict[str, float]:
        """Work counters."""

    def close(self) -> None:
        """End the threads."""


def least_worth_of(problem: Prizes, worth: float) -> float:
    """Least worth of plans in a cost proof, with a tolerance for plans of equal worth.

    A little less, so that no rounding of a sum of prizes counts, but far more than any plan has
    that collects less.
    """
    return worth - min(SLACK_WORTH * abs(worth), 0.5 * problem.prize_resolution)


def is_least(cost: float, bound: float) -> bool:
    """Whether a cost is least, within the tolerance of the bound."""
    return cost <= bound * (1.0 + RELATIVE)


def settled(proof: CostRounds, over: Callable[[], bool]) -> tuple[float, dict[str, float]]:
    """Run all rounds of a proof, and close it.

    Parameters
    ----------
    proof : CostRounds
    over : callable
        Whether the time is over.

    Returns
    -------
    bound : float
        How much ΔV the plans cost at least that are worth enough [m/s].
    counters : dict
    """
    with closing(proof):
        while not proof.done and not over():
            proof.advance()
    return proof.bound, proof.counters
