"""Ends of legs: data that determine the legs of all pairs of an instance."""

from __future__ import annotations

import math

import numpy as np

from ...common.constants import SLACK_M_S, SLACK_S
from ...kernels.legs.times import Times
from ...plan.tows import leaving_eccentricity_delta_v, leaving_orbits
from ...problem.drives import Drive
from ...problem.instance import Instance
from ..altitude_limits import AltitudeLimits, altitude_limits
from .family import FloatArray, PairEnds


class AllEnds:
    """Ends of the legs of all pairs of an instance.

    Attributes
    ----------
    instance : Instance
    leaving, arriving : (bodies, columns) float64
        Bodies as they are left and as they are arrived at.
    eccentricity_m_s : (bodies, bodies) float64
        What matching eccentricity vectors alone costs, by origin and destination; +inf between
        bodies that limits of altitude keep apart [m/s].
    altitudes : AltitudeLimits
    rule : TransferRule
    times : Times or None
    latest_s : float
        [s].
    drive : Drive or None
        Of the chasers that the legs are for.
    relaxed : bool
        As in :class:`PairEnds`.
    """

    def __init__(
        self, instance: Instance, drive: Drive | None = None, *, relaxed: bool = False
    ) -> None:
        self.instance, self.drive, self.relaxed = instance, drive, relaxed
        self.leaving, self.arriving = leaving_orbits(instance, drive), instance.orbits()
        self.altitudes = altitude_limits(instance, drive)
        self.eccentricity_m_s = _with_barred(
            leaving_eccentricity_delta_v(instance, self.leaving), self.altitudes
        )
        self.rule = instance.transfer_rule()
        self.times = _times(instance)
        self.latest_s = instance.mission.duration_s + SLACK_S

    def of(self, i: int, j: int) -> PairEnds:
        """The ends of a pair."""
        leave_by, arrive_by = self.altitudes.leave_by[i], self.altitudes.arrive_by[j]
        times = None if self.times is None else self.times._replace(leave_by=float(leave_by))
        return PairEnds(
            self.instance,
            i,
            j,
            self.leaving[i],
            self.arriving[j],
            self.eccentricity_m_s[i, j],
            self.rule,
            times,
            min(self.latest_s, float(arrive_by)),
            self.drive,
            self.relaxed,
        )


def is_regular(instance: Instance) -> bool:
    """Whether departure events are those of two-body motion, with the model's connections."""
    return instance.dynamics == "two-body" and instance.transfer.departure_spacing_s == 0.0


def _times(instance: Instance) -> Times | None:
    """Departure times of transfers; None where events are regular or connections are given."""
    settings = instance.transfer
    if is_regular(instance) or settings.given is not None:
        return None
    return Times(
        settings.departure_spacing_s,
        settings.drift_step_s,
        settings.max_drift_s,
        instance.largest_tank_m_s + SLACK_M_S,
    )


def _with_barred(costs: FloatArray, altitudes: AltitudeLimits) -> FloatArray:
    """Costs with +inf where no leg leads."""
    barred = (altitudes.leave_by < 0.0)[:, None] | (altitudes.arrive_by < 0.0)
    return np.where(barred, math.inf, costs) if barred.any() else costs
