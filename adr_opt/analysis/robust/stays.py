"""Times that chasers stay with targets: all tries, as long as they take.

A try takes the drawn time of the service; it is repeated until one succeeds or no more are allowed,
and takes no time where the target is gone (docs/model.md section 13.2). A tow is not part of it.
"""

from __future__ import annotations

import math
from functools import cached_property

import numpy as np
import numpy.typing as npt

from ...problem.uncertainty import Delay, LognormalFactor, Uncertainty

FloatArray = npt.NDArray[np.float64]

FACTORS = 2000
"""Number of equally likely factors that stand for the distribution of one."""

STEPS = 60
"""Bisections of a quantile."""


class StayTime:
    """Distribution of the time at a target.

    Parameters
    ----------
    uncertainty : Uncertainty
    target : str
    planned_s : float
        Time of its service by the instance [s].
    """

    def __init__(self, uncertainty: Uncertainty, target: str, planned_s: float) -> None:
        model = uncertainty.service_of(target)
        self._planned_s, self._factor, self._delay = planned_s, model.factor, model.added
        self._gone = uncertainty.gone_of(target)
        self._success = uncertainty.success_of(target)
        self._tries = uncertainty.tries_of(target)

    @property
    def is_certain(self) -> bool:
        """Whether no stay is longer than planned."""
        tried_again = self._tries > 1 and self._success < 1.0
        return self._factor is None and self._delay is None and not tried_again

    @cached_property
    def _shares(self) -> tuple[tuple[int, float], ...]:
        """Chance of each number of tries, of a target that is there."""
        failed, shares = 1.0, []
        for tries in range(1, self._tries):
            shares.append((tries, failed * self._success))
            failed *= 1.0 - self._success
        return (*shares, (self._tries, failed))

    @cached_property
    def _longest_planned_s(self) -> FloatArray:
        """Equally likely times of a try before a delay [s]."""
        if self._factor is None:
            return np.array([self._planned_s])
        return self._planned_s * _equally_likely(self._factor)

    def chance(self, time_s: float) -> float:
        """Chance that a stay is no longer than a time [s]."""
        within = sum(share * self._one_try(time_s / tries) for tries, share in self._shares)
        return self._gone + (1.0 - self._gone) * within

    def _one_try(self, time_s: float) -> float:
        spare_s = time_s - self._longest_planned_s
        if self._delay is None:
            return float((spare_s >= 0.0).mean())
        return float(_no_longer(self._delay, spare_s).mean())

    def quantile(self, chance: float) -> float:
        """The least time that a stay does not exceed with a chance [s]; at least the planned one.

        +inf where no time is long enough.
        """
        low, high = 0.0, max(self._planned_s, 1.0)
        if self.chance(self._planned_s) >= chance:
            return self._planned_s
        while self.chance(high) < chance:
            low, high = high, 2.0 * high
            if not math.isfinite(high):
                return math.inf
        for _ in range(STEPS):
            middle = 0.5 * (low + high)
            low, high = (low, middle) if self.chance(middle) >= chance else (middle, high)
        return max(high, self._planned_s)


def _equally_likely(factor: LognormalFactor) -> FloatArray:
    """Factors at the middles of equal shares of the distribution."""
    return np.array([factor.at((place + 0.5) / FACTORS) for place in range(FACTORS)])


def _no_longer(delay: Delay, spare_s: FloatArray) -> FloatArray:
    """Chance that a delay is no longer than some times, which may be negative [s]."""
    inside = np.maximum(spare_s, 0.0)
    if delay.mean_s > 0.0:
        chance = 1.0 - delay.chance * np.exp(-inside / delay.mean_s)
    else:
        chance = np.ones(inside.size)
    if delay.most_s is not None:
        chance = np.where(spare_s >= delay.most_s, 1.0, chance)
    return np.where(spare_s < 0.0, 0.0, chance)


def slip_chance(slip: Delay, spare_s: float) -> float:
    """Chance that a slip is no longer than a time [s]."""
    return float(_no_longer(slip, np.array([spare_s]))[0])


def slip_quantile(slip: Delay, chance: float) -> float:
    """The least time that a slip does not exceed with a chance below 1 [s]."""
    if chance <= 1.0 - slip.chance or slip.mean_s == 0.0:
        return 0.0
    longest_s = math.inf if slip.most_s is None else slip.most_s
    return min(slip.mean_s * math.log(slip.chance / (1.0 - chance)), longest_s)
