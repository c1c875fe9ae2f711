"""Whether the thrust of all chasers is too small for any leg in the mission."""

from __future__ import annotations

import math

from ..common.constants import DAY_S
from ..common.records import LARGEST_DURATION_S
from ..kernels.legs import low_thrust, low_thrust_windows
from ..kernels.legs.low_thrust_arcs import Thrust
from ..kernels.orbits.ephemeris import EPOCH_S
from ..problem.drives import drive_of, since_j2000_s
from ..problem.instance import Instance
from .families.ends import AllEnds

LONGER = 1.1
"""Ratio of the durations that are tried."""


def too_weak(instance: Instance) -> str | None:
    """A sentence if no first leg of a chaser ends within the mission; else None.

    Parameters
    ----------
    instance : Instance
        All of whose chasers have low thrust; of any other nothing is said.
    """
    soonest, quickest, between = math.inf, math.inf, ("", "")
    first, names = instance.first_target, instance.names
    for number, chaser in enumerate(instance.chasers):
        drive = drive_of(chaser, instance.targets)
        if drive is None or chaser.is_launched:
            return None
        ends, start = AllEnds(instance, drive), instance.starts[number]
        thrust = Thrust(drive.least_acceleration, drive.exhaust_m_s)
        since = since_j2000_s(instance.epoch)
        begin = instance.available_s[number][0]
        for j in range(first, len(names)):
            pair = low_thrust_windows.prepare(
                ends.leaving[start], ends.arriving[j], ends.rule, since, EPOCH_S
            )
            span = instance.transfer.drift_step_s
            while span < min(quickest, LARGEST_DURATION_S):
                cost = low_thrust.delta_v(pair, thrust, begin, begin + span)
                if cost <= chaser.tank.delta_v_m_s:
                    quickest, between = span, (names[start], names[j])
                    soonest = min(soonest, begin + span)
                    break
                span *= LONGER
    if soonest <= instance.mission.duration_s or math.isinf(quickest):
        return None
    return (
        f"the thrust is too small for any leg in the mission of {instance.mission.duration_s:g} s: "
        f"the quickest, from {between[0]!r} to {between[1]!r}, takes some {quickest / DAY_S:.0f} d"
    )
