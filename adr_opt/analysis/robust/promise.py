"""The probability that a plan holds in an uncertain world (docs/model.md section 13.4).

Each tank holds what its legs take, each chaser is free when its next leg departs, and the last stay
ends in time. Draws are independent, so the chances of tanks are multiplied. Lateness is no sum, as
waiting absorbs it: each stay and each launch has a chance of its own.

A stay with a target is all tries, as long as they take. A try takes the drawn time of the service;
it is repeated until one succeeds or no more are allowed, and takes no time where the target is gone
(docs/model.md section 13.2). A tow is not part of it.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property
from statistics import NormalDist
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from ...common.constants import SLACK_S
from ...kernels.core.windows import service_begin
from ...kernels.rules.loads import after_service
from ...problem.uncertainty import Delay, LognormalFactor, Uncertainty
from ..rehearse.flying_chasers import beginning, full_of
from ..rehearse.intended import Intended
from ..rehearse.mission_facts import Hop, MissionFacts

FloatArray = npt.NDArray[np.float64]

FACTORS = 2000
"""Number of equally likely values that approximate the distribution of a factor."""

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
        """Chance of each number of tries at a target that exists."""
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
        """Quantile of the time of a stay, at least the planned time [s].

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
    """Quantile of a slip at a chance below 1 [s]."""
    if chance <= 1.0 - slip.chance or slip.mean_s == 0.0:
        return 0.0
    longest_s = math.inf if slip.most_s is None else slip.most_s
    return min(slip.mean_s * math.log(slip.chance / (1.0 - chance)), longest_s)


HALVINGS = 50
"""Number of bisections of a tank's spare ΔV."""

_NORMAL = NormalDist()


class TankChance(NamedTuple):
    """The chance that a tank suffices for its legs.

    Attributes
    ----------
    chaser : str
    filling : int
        Number of the tank, from 1.
    spare_m_s : float
        What the tank has beyond the mean of its legs [m/s].
    sigma_m_s : float
        Standard deviation of what they take and of what can be used [m/s].
    """

    chaser: str
    filling: int
    spare_m_s: float
    sigma_m_s: float

    @property
    def chance(self) -> float:
        """The chance by a normal approximation."""
        if self.sigma_m_s <= 0.0:
            return float(self.spare_m_s >= 0.0)
        return _NORMAL.cdf(self.spare_m_s / self.sigma_m_s)


class InTime(NamedTuple):
    """The chance that a chaser is in time for its next leg, its end or its launch.

    Attributes
    ----------
    chaser : str
    at : str
        Target that it stays with; empty for the launch.
    chance : float
    """

    chaser: str
    at: str
    chance: float


@dataclass(frozen=True)
class Promise:
    """The chances that the parts of a plan hold: tanks, stays and launches.

    Attributes
    ----------
    tanks : tuple of TankChance
        Those that may run dry, or do.
    stays : tuple of InTime
        Those that may last longer than planned.
    launches : tuple of InTime
        Those that may slip.
    """

    tanks: tuple[TankChance, ...]
    stays: tuple[InTime, ...]
    launches: tuple[InTime, ...]

    @cached_property
    def tanks_chance(self) -> float:
        """Chance that all tanks suffice for their legs."""
        return math.prod(each.chance for each in self.tanks)

    @cached_property
    def least_chance(self) -> float:
        """The least chance, over all stays and launches, that a chaser is in time."""
        return min((each.chance for each in (*self.stays, *self.launches)), default=1.0)

    def keeps(self, confidence: float) -> bool:
        """Whether all tanks hold together, and each stay and launch is in time, with a chance."""
        return min(self.tanks_chance, self.least_chance) >= confidence


def promise_of(facts: MissionFacts, planned: Intended, uncertainty: Uncertainty) -> Promise:
    """The promise of a plan.

    Parameters
    ----------
    facts : MissionFacts
    planned : Intended
        The plan.
    uncertainty : Uncertainty
    """
    tanks, stays, launches = list[TankChance](), list[InTime](), list[InTime]()
    for chaser, route in enumerate(planned.routes):
        hops = [each.hop for each in route]
        tanks += _tanks(facts, chaser, planned.kits[chaser], hops, uncertainty)
        stays += _stays(facts, chaser, hops, uncertainty)
        what = facts.chasers[chaser]
        slip = uncertainty.slip_of(what.name) if what.is_launched else None
        if slip is not None and hops:
            spare_s = hops[0].departure - what.limits.ready
            launches.append(InTime(what.name, "", slip_chance(slip, spare_s)))
    return Promise(
        tuple(each for each in tanks if each.sigma_m_s > 0.0 or each.spare_m_s < 0.0),
        tuple(stays),
        tuple(launches),
    )


def _stays(
    facts: MissionFacts, chaser: int, hops: list[Hop], uncertainty: Uncertainty
) -> Iterator[InTime]:
    what = facts.chasers[chaser]
    for place, hop in enumerate(hops):
        j = hop.destination
        if j < facts.stations:
            continue
        tow_s = facts.tow_s.get(j, 0.0)
        stay = StayTime(uncertainty, facts.names[j], float(what.limits.service[j]) - tow_s)
        if stay.is_certain:
            continue
        begin = float(service_begin(what.limits.windows, j, hop.arrival))
        is_last = place + 1 == len(hops)
        until = what.limits.duration if is_last else hops[place + 1].departure + SLACK_S
        yield InTime(what.name, facts.names[j], stay.chance(until - tow_s - begin))


def _tanks(
    facts: MissionFacts, chaser: int, kits: int, hops: list[Hop], uncertainty: Uncertainty
) -> Iterator[TankChance]:
    """The tanks of a chaser in order."""
    what = facts.chasers[chaser]
    mean_share, share_sigma = (1.0, 0.0)
    if uncertainty.tanks is not None:
        mean_share, share_sigma = uncertainty.tanks.moments
    left, filling, begun = beginning(facts, chaser, kits, 0.0, mean_share).left, 1, 0
    aboard = kits
    for place, hop in enumerate(hops):
        refuels = hop.destination < facts.stations
        if not refuels and place + 1 < len(hops):
            continue
        legs = hops[begun : place + 1]
        full = full_of(what, aboard)
        square = (full * share_sigma) ** 2
        for leg in legs:
            _, sigma = moments_of(facts, leg, uncertainty)
            square += (sigma * leg.delta_v) ** 2
        spare = _spare(facts, chaser, aboard, legs, left, uncertainty)
        yield TankChance(what.name, filling, spare, math.sqrt(square))
        aboard -= sum(facts.takes_kit(leg.destination) for leg in legs)
        left, filling, begun = mean_share * full_of(what, aboard), filling + 1, place + 1


def moments_of(facts: MissionFacts, hop: Hop, uncertainty: Uncertainty) -> tuple[float, float]:
    """Mean and standard deviation of the factor on the ΔV of a leg."""
    model = facts.factor_of(hop, uncertainty)
    return (1.0, 0.0) if model is None else model.moments


def _spare(
    facts: MissionFacts,
    chaser: int,
    kits: int,
    legs: list[Hop],
    left: float,
    uncertainty: Uncertainty,
) -> float:
    """ΔV of a full tank beyond the mean ΔV of its legs [m/s].

    With cargo a metre per second more at the beginning is worth at least as much later, as the
    chaser becomes lighter: that much is on the safe side. Negative where it is not enough.
    """
    loads = facts.chasers[chaser].loads
    takes = [moments_of(facts, leg, uncertainty)[0] * leg.delta_v for leg in legs]
    if loads is None:
        return left - math.fsum(takes)

    def suffices(begin: float) -> bool:
        has, aboard = begin, kits
        for leg, taken in zip(legs, takes, strict=True):
            has -= taken
            if has < 0.0:
                return False
            if leg.destination >= facts.stations:
                has, aboard = after_service(loads, leg.destination, aboard, has)
                if has < 0.0:
                    return False
        return True

    if not suffices(left):
        return -math.inf
    low, high = 0.0, left
    for _ in range(HALVINGS):
        middle = 0.5 * (low + high)
        low, high = (middle, high) if suffices(left - middle) else (low, middle)
    return low
