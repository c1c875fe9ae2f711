"""The chance that a plan keeps what it promises (docs/model.md section 13.4).

Each tank holds what its legs take, each chaser is free when its next leg departs, and the last stay
ends in time. Draws are independent, so the chances of tanks are multiplied. Lateness is no sum, as
waiting absorbs it: each stay and each launch has a chance of its own.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property
from statistics import NormalDist
from typing import NamedTuple

from ...common.constants import SLACK_S
from ...kernels.core.windows import service_begin
from ...kernels.rules.loads import after_service
from ...problem.uncertainty import Uncertainty
from ..rehearse.flying_chasers import beginning, full_of
from ..rehearse.intended import Intended
from ..rehearse.mission_facts import Hop, MissionFacts
from .stays import StayTime, slip_chance

HALVINGS = 50
"""Bisections of the ΔV that a tank has to spare."""

_NORMAL = NormalDist()


class TankChance(NamedTuple):
    """The chance that a tank holds what its legs take.

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
        """By the normal distribution."""
        if self.sigma_m_s <= 0.0:
            return float(self.spare_m_s >= 0.0)
        return _NORMAL.cdf(self.spare_m_s / self.sigma_m_s)


class InTime(NamedTuple):
    """The chance that a chaser is in time: for its next leg, its end, or its launch.

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
    """What a plan promises, with the chance of each part.

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
        """Chance that all tanks hold what their legs take."""
        return math.prod(each.chance for each in self.tanks)

    @cached_property
    def least_chance(self) -> float:
        """The least chance of a chaser to be in time somewhere."""
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
        begin = float(service_begin(hop.arrival, what.limits.opens[j]))
        is_last = place + 1 == len(hops)
        until = what.limits.duration if is_last else hops[place + 1].departure + SLACK_S
        yield InTime(what.name, facts.names[j], stay.chance(until - tow_s - begin))


def _tanks(
    facts: MissionFacts, chaser: int, kits: int, hops: list[Hop], uncertainty: Uncertainty
) -> Iterator[TankChance]:
    """The tanks of a chaser, one after the other."""
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
    """What a tank has at its beginning beyond what its legs take on average [m/s].

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
