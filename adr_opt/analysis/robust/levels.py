"""Levels of confidence: how likely each tank, stay and launch is to be kept, and shares of risk."""

from __future__ import annotations

from statistics import NormalDist
from typing import NamedTuple

from .promise import Promise

_NORMAL = NormalDist()

MOST_LEVEL = 1.0 - 1e-9

LEAST_STEP = 0.3
"""Least difference of shared levels from the confidence, in normal scores."""


class Levels(NamedTuple):
    """Chances with which each part of a promise is to be kept.

    Attributes
    ----------
    tank : float
        Each tank.
    stay : float
        Each stay ends before the next leg departs.
    launch : float
        Each launch.
    """

    tank: float
    stay: float
    launch: float


def equal(confidence: float) -> Levels:
    """Levels that every plan keeps whose promise is kept with a confidence."""
    return Levels(confidence, confidence, confidence)


def shared(confidence: float, promise: Promise) -> Levels:
    """The risk shared out equally: among kinds of parts, and among the parts of each.

    Each level is above the confidence, since charges ask less than a tank of unequal legs needs.

    Parameters
    ----------
    confidence : float
        Of the whole promise.
    promise : Promise
        Of a plan, whose numbers of parts are assumed.
    """
    numbers = len(promise.tanks), len(promise.stays), len(promise.launches)
    kinds = sum(number > 0 for number in numbers)
    least = _NORMAL.cdf(_NORMAL.inv_cdf(confidence) + LEAST_STEP)
    return Levels(*(max(confidence ** (1.0 / max(1, kinds * number)), least) for number in numbers))


def between(first: Levels, second: Levels, share: float) -> Levels:
    """Levels on the way from one to the other, and beyond it, by their normal scores."""

    def score(level: float) -> float:
        return _NORMAL.inv_cdf(min(level, MOST_LEVEL))

    return Levels(
        *(
            min(_NORMAL.cdf(score(a) + share * (score(b) - score(a))), MOST_LEVEL)
            for a, b in zip(first, second, strict=True)
        )
    )
