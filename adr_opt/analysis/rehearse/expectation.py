"""Expectations of planning policies about an uncertain mission: mean prizes, reserves of ΔV."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from ...problem.chasers import Chaser, Tank
from ...problem.instance import Instance
from ...problem.uncertainty import Uncertainty
from .intended import Intended
from .mission_facts import Hop, MissionFacts
from .service_delays import mean_delays_s
from .tries import mean_worths, with_worths

CAUTION = 2.5
"""Reserve of a tank, in standard deviations of its legs' ΔV."""


class Expectation:
    """The uncertainty of a mission, as taken into account when its rest is planned.

    Prizes are what going to a target is worth on average, and services take as long as stays at
    targets do on average; tanks in ΔV that will be filled again keep a reserve for what their legs
    may cost more, since a chaser that runs dry is lost.

    Parameters
    ----------
    facts : MissionFacts
    intended : Intended
    uncertainty : Uncertainty

    Attributes
    ----------
    reserve_m_s : float
        Of a full tank [m/s].
    time_share : float
        Mean time at a target, with all tries, as a multiple of the planned one; at least 1.
    """

    def __init__(self, facts: MissionFacts, intended: Intended, uncertainty: Uncertainty) -> None:
        self._facts, self._uncertainty = facts, uncertainty
        self._worths = mean_worths(facts.instance, uncertainty)
        self.reserve_m_s = self._reserve(intended)
        self.time_share = _time_share(facts, uncertainty)

    @property
    def differs(self) -> bool:
        """Whether expected costs, times or prizes differ from planned ones."""
        return self.reserve_m_s > 0.0 or bool(self._worths) or self.time_share != 1.0

    @property
    def is_cautious(self) -> bool:
        """Whether it keeps a reserve, or expects longer stays."""
        return self.reserve_m_s > 0.0 or self.time_share > 1.0

    def expected(self, instance: Instance, *, cautious: bool) -> Instance:
        """The rest of the mission with expected prizes, times and reserves.

        Parameters
        ----------
        instance : Instance
            A remaining instance of the mission.
        cautious : bool
            Whether tanks keep a reserve, and services take as long as on average.
        """
        instance = with_worths(instance, self._worths)
        if cautious:
            instance = _slower(instance, self.time_share)
        if cautious and self.reserve_m_s > 0.0:
            instance = instance.replace(chasers=tuple(map(self._careful, instance.chasers)))
        return instance

    def spread_m_s(self, hops: Sequence[Hop]) -> float:
        """Reserve for the legs of a chaser up to its next refuelling [m/s]."""
        squares = 0.0
        for hop in hops:
            squares += (self.sigma(hop) * hop.delta_v) ** 2
            if hop.destination < self._facts.stations:
                return CAUTION * math.sqrt(squares)
        return 0.0  # nothing comes after this tank that could be lost

    def _careful(self, chaser: Chaser) -> Chaser:
        """The chaser with a reserve in its tank, if the tank is given in ΔV."""
        tank = chaser.tank
        if not isinstance(tank, Tank) or tank.delta_v_m_s <= self.reserve_m_s:
            return chaser
        full = tank.delta_v_m_s - self.reserve_m_s
        initial = tank.initial_delta_v_m_s
        if initial is not None:
            share = math.sqrt(initial / tank.delta_v_m_s) if tank.delta_v_m_s > 0.0 else 0.0
            initial = min(max(initial - share * self.reserve_m_s, 0.0), full)
        return chaser.replace(tank=Tank(delta_v_m_s=full, initial_delta_v_m_s=initial))

    def sigma(self, hop: Hop) -> float:
        """Spread of the factor on a leg; 0 where it is 1."""
        model = self._facts.factor_of(hop, self._uncertainty)
        return 0.0 if model is None else model.lognormal_sigma

    def _reserve(self, intended: Intended) -> float:
        """Reserve of a full tank: the median need of the planned tanks that are refilled."""
        needed = []
        for route in intended.routes:
            squares = 0.0
            for each in route:
                squares += (self.sigma(each.hop) * each.hop.delta_v) ** 2
                if each.hop.destination < self._facts.stations:
                    needed.append(CAUTION * math.sqrt(squares))
                    squares = 0.0
        return float(np.median(needed)) if needed else 0.0


def _time_share(facts: MissionFacts, uncertainty: Uncertainty) -> float:
    """Mean time at a target as a multiple of the planned time; 1 if objects are towed.

    One that has still to be towed has a window for just its service. Stays that are shorter on
    average count as planned, since a leg may only begin if its planned service ends in time.
    """
    if facts.tow_s:
        return 1.0
    planned_s = float(facts.chasers[0].limits.service[facts.first_target :].sum())
    late_s = float(mean_delays_s(facts, uncertainty).sum())
    return max(1.0 + late_s / planned_s, 1.0) if planned_s > 0.0 else 1.0


def _slower(instance: Instance, share: float) -> Instance:
    """The instance with services that take a multiple of their planned time."""
    mission = instance.mission
    if share == 1.0:
        return instance
    if mission.service_revolutions is not None:
        return instance.replace(
            mission=mission.replace(service_revolutions=share * mission.service_revolutions)
        )
    assert mission.service_s is not None
    return instance.replace(mission=mission.replace(service_s=share * mission.service_s))


def expectation_of(
    facts: MissionFacts, intended: Intended, uncertainty: Uncertainty
) -> Expectation:
    """The expectation of a mission, which its rehearsals share."""
    known = facts.expectation
    if known is None or known[0] is not intended or known[1] is not uncertainty:
        known = facts.expectation = (
            intended,
            uncertainty,
            Expectation(facts, intended, uncertainty),
        )
    made: Expectation = known[2]
    return made
