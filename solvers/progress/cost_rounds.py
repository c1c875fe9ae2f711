"""What all proofs of the least ΔV have in common, be they of one chaser or of a campaign."""

from __future__ import annotations

from collections.abc import Callable
from contextlib import closing
from typing import Protocol

from adr_opt.common.tolerance import COST_RELATIVE
from adr_opt.mission.prizes import Prizes

RELATIVE = COST_RELATIVE
"""A cost is the least if it exceeds the bound by no more than this share of it."""


SLACK_WORTH = 1e-9
"""So much less is asked for at most, as a share: the bound on the cost comes down by as much."""


class CostRounds(Protocol):
    """A proof of the least ΔV of plans that are worth enough, round by round.

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
        """What was done so far."""

    def close(self) -> None:
        """End the threads."""


def asked(problem: Prizes, least_worth: float) -> float:
    """What a plan has to be worth at least, of which a proof asks for the cost.

    A little less, so that no rounding of a sum of prizes counts, but far more than any plan has
    that collects less.
    """
    return least_worth - min(SLACK_WORTH * abs(least_worth), 0.5 * problem.prize_resolution)


def is_least(cost: float, bound: float) -> bool:
    """Whether a cost is the least, for all that a bound lets it exceed the least by."""
    return cost <= bound * (1.0 + RELATIVE)


def settled(proof: CostRounds, over: Callable[[], bool]) -> tuple[float, dict[str, float]]:
    """Go through the rounds of a proof, and close it.

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
