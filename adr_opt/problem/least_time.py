"""Check whether a mission is too short for any leg, by a lower bound on a leg's duration."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from ..common.constants import EARTH_RADIUS_M, MU_M3_S2
from .approach import approach_of
from .instance import Instance

FloatArray = npt.NDArray[np.float64]

NODAL_SHARE = 0.99
"""Nodal period under J2 as a share of the two-body period, at least."""


def least_end_s(instance: Instance) -> float | None:
    """Lower bound on the end of any service; None if there is none [s].

    A leg takes three half ellipses over the lowest phasing circle that is allowed, the approach,
    and the service (docs/model.md section 2); that to the first target of a chaser that is launched
    onto it only the service. Nothing is waited for. Nothing can be said where connections are
    given.
    """
    if instance.transfer.given is not None or not instance.targets:
        return None
    rule, mission = instance.transfer, instance.mission
    radii = np.array([orbit.semi_major_axis_m for orbit in instance.body_orbits])
    to = radii[instance.first_target :]
    periods = 2.0 * _half(to)
    service = (
        np.full(to.shape, mission.service_s)
        if mission.service_revolutions is None
        else mission.service_revolutions * periods
    )
    low = EARTH_RADIUS_M + rule.min_altitude_m
    between = low + rule.first_leg_fraction * (to - low)
    last_two = _half(0.5 * (low + between)) + _half(0.5 * (between + to))
    found = []
    for start, chaser, (since, _) in zip(
        instance.starts, instance.chasers, instance.available_s, strict=True
    ):
        flight: FloatArray | float = 0.0
        if not chaser.is_launched:
            first = _half(0.5 * (radii[start] + low))
            flight = first + last_two + approach_of(rule).revolutions * periods
        found.append(max(since, 0.0) + NODAL_SHARE * float((flight + service).min()))
    return min(found)


def too_short(instance: Instance) -> str | None:
    """A sentence if the mission ends before any service can; else None."""
    least = least_end_s(instance)
    duration = instance.mission.duration_s
    if least is None or duration >= least:
        return None
    return (
        f"the mission of {duration:g} s is too short for any leg: the first service cannot end "
        f"before {least:.0f} s"
    )


def _half(axis: FloatArray | float) -> FloatArray:
    """Half the period of an orbit, by its semi-major axis [s]."""
    return np.asarray(np.pi * np.sqrt(np.asarray(axis) ** 3 / MU_M3_S2))
