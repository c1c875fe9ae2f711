"""Distributions of the times of services, and worths of services of uncertain time.

See docs/model.md section 13.3.
"""

from __future__ import annotations

import math
from functools import lru_cache
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from ...problem.uncertainty import Delay, LognormalFactor, ServiceUncertainty

PARTS = 2000
"""Number of equally likely parts of the distribution of a factor."""

STEP = 1.02
"""Ratio between successive times left at which worths are evaluated."""

SHORT_S = 60.0
"""Shortest time left at which worths are evaluated [s]."""

FloatArray = npt.NDArray[np.float64]


@lru_cache(maxsize=64)
def _factors(model: LognormalFactor | None) -> FloatArray:
    """The least factor of each of equally likely parts of a distribution."""
    if model is None or model.lognormal_sigma == 0.0:
        return np.ones(1)
    inner = [model.at(part / PARTS) for part in range(1, PARTS)]
    return np.array([model.least, *inner])


class ServiceTimes:
    """The distribution of the time of a service: a factor on the planned time, and a delay.

    Each part of the distribution of the factor is taken at its least, so that chances are no less,
    and means no more, than the true ones: by no more than a part.

    Parameters
    ----------
    planned_s : float
        [s].
    model : ServiceUncertainty
    """

    def __init__(self, planned_s: float, model: ServiceUncertainty) -> None:
        self._least_s = planned_s * _factors(model.factor)
        self._added = model.added or Delay(chance=0.0, mean_s=0.0)

    def chance_by(self, left_s: float) -> float:
        """Upper bound on the chance that a service takes no longer than a time."""
        over = left_s - self._least_s
        later = np.where(over < self._most_s, self._added.chance * self._beyond(over), 0.0)
        return float(np.where(over >= 0.0, 1.0 - later, 0.0).mean())

    def within_s(self, left_s: float) -> float:
        """Lower bound on the mean of the lesser of a service's time and a given time [s]."""
        over = np.clip(left_s - self._least_s, 0.0, self._most_s)
        added = self._added.chance * self._added.mean_s * (1.0 - self._beyond(over))
        return float((np.minimum(self._least_s, left_s) + added).mean())

    @property
    def _most_s(self) -> float:
        return float("inf") if self._added.most_s is None else self._added.most_s

    def _beyond(self, over: FloatArray) -> FloatArray:
        """Chance that a delay which occurs would be longer if it had no maximum."""
        mean_s = self._added.mean_s
        if mean_s == 0.0:
            return np.zeros(over.size)
        return np.exp(-np.maximum(over, 0.0) / mean_s)


class LateWorth(NamedTuple):
    """Upper limit on the worth of a service that begins late.

    Attributes
    ----------
    below_s : float
        With no more time left at its beginning [s].
    worth : float
    """

    below_s: float
    worth: float


class MostWorths(NamedTuple):
    """Upper bounds on the worth of going to a target, by the time left when its service begins.

    Attributes
    ----------
    left_s : (steps,) float64
        Rising, from what the service is planned to take to the whole mission [s].
    worth : (steps,) float64
        With no more time left; never falling.
    """

    left_s: FloatArray
    worth: FloatArray


@lru_cache(maxsize=4096)
def most_worths(
    planned_s: float, model: ServiceUncertainty, prize: float, per_s: float, mission_s: float
) -> MostWorths:
    """Running maxima of W(x) = r P(S ≤ x) − λ E min(S, x), for a service of random time S.

    Parameters
    ----------
    planned_s : float
        What it is planned to take [s].
    model : ServiceUncertainty
    prize : float
        Mean prize of one that ends in time.
    per_s : float
        Price of time [prize per s].
    mission_s : float
        The most that can be left [s].
    """
    times = ServiceTimes(planned_s, model)
    first_s = max(planned_s, SHORT_S)
    last_s = max(mission_s, first_s)
    left_s = np.geomspace(first_s, last_s, 2 + math.ceil(math.log(last_s / first_s, STEP)))
    # Both parts rise with the time, so that between two times none is worth more than this.
    before_s = np.append(0.0 if planned_s < SHORT_S else planned_s / STEP, left_s[:-1])
    worth = [
        prize * times.chance_by(after) - per_s * times.within_s(before)
        for before, after in zip(before_s.tolist(), left_s.tolist(), strict=True)
    ]
    return MostWorths(left_s, np.maximum.accumulate(worth))


def levels_of(left_s: FloatArray, worth: FloatArray, least: float) -> tuple[LateWorth, ...]:
    """Falling levels above a worth that rises with the time left.

    Parameters
    ----------
    left_s : (steps,) float64
        Rising [s].
    worth : (steps,) float64
        At most what a service counts that begins with no more time left; never falling.
    least : float
        Least fall from one level to the next.

    Returns
    -------
    tuple of LateWorth
        From the longest time to the shortest; none where the worth falls by less.
    """
    found, top = list[LateWorth](), float(worth[-1])
    for left, most in zip(left_s[::-1].tolist(), worth[::-1].tolist(), strict=True):
        if most <= top - least:
            top = most
            found.append(LateWorth(left, top))
    return tuple(found)
