"""The 113 legs of the winning solution of GTOC9, as flown and as a closed form has them."""

from __future__ import annotations

from pathlib import Path
from typing import NamedTuple

import numpy as np

from adr_opt.common.constants import DAY_S, OBLATENESS_M2
from adr_opt.kernels.legs import drift, drift_linear, drift_pair
from adr_opt.kernels.legs.co_elliptic import TransferRule

from .campaign import FILE, read_campaign
from .debris import FILE as DEBRIS
from .debris import read_debris
from .estimate import LIMITS_M

RULE = TransferRule(
    1.0, 0.0, 0.0, 0, *LIMITS_M, 0.0, np.empty((0, 4)), OBLATENESS_M2, 0.0, np.empty((0, 5))
)
"""Transfers of the contest: to the debris itself, without a co-elliptic orbit or an approach."""


class Leg(NamedTuple):
    """A leg of the solution, times since MJD2000 0 [s].

    Attributes
    ----------
    pair : LinearPair
        Of the two debris, prepared to first order.
    phased : DriftPair
        The same with exact rates and a phase.
    departure, arrival : float
        [s].
    flown : float
        ΔV of the optimised leg, fully flown [m/s].
    """

    pair: drift_linear.LinearPair
    phased: drift_pair.DriftPair
    departure: float
    arrival: float
    flown: float

    @property
    def days(self) -> float:
        """Duration of the leg."""
        return (self.arrival - self.departure) / DAY_S

    @property
    def closed_form(self) -> float:
        """ΔV by the closed form used in planning [m/s]."""
        return float(drift.delta_v(self.phased, self.departure, self.arrival))

    @property
    def first_order(self) -> float:
        """ΔV by the first-order form, without phase [m/s]."""
        return float(drift_linear.delta_v(self.pair, self.departure, self.arrival))


def read_legs(folder: Path) -> list[Leg]:
    """The legs in order of flight, mission by mission."""
    rows = read_debris(folder / DEBRIS)
    legs = []
    for mission in read_campaign(folder / FILE):
        ways = zip(mission.stops[:-1], mission.stops[1:], mission.flown_m_s, strict=True)
        for one, other, flown in ways:
            ends = rows[one.debris], rows[other.debris]
            pair = drift_linear.prepare(*ends, *LIMITS_M, OBLATENESS_M2, 0.0)
            times = one.departure_d * DAY_S, other.arrival_d * DAY_S
            legs.append(Leg(pair, drift_pair.prepare(*ends, RULE, 0.0), *times, flown))
    return legs
