"""Service windows and durations of bodies, as arrays."""

from __future__ import annotations

import math
from collections.abc import Iterable

import numpy as np

from ..common.constants import SLACK_S
from ..common.records import Window
from ..kernels.core.windows import windows_of
from ..kernels.orbits.ephemeris import EPOCH_S, revolution_at
from ..kernels.tables.timetable_making import ServiceLimits
from ..plan.plan import Leg
from ..plan.tows import removals_of
from ..problem.drives import drive_of
from ..problem.instance import Instance
from .corrections import NO_CORRECTIONS, Corrections


def limits_of(
    instance: Instance, chaser: int | None = None, corrections: Corrections = NO_CORRECTIONS
) -> ServiceLimits:
    """Time limits of an instance as kernels take them; the arrays are read-only.

    A tow follows the service at once, or later: the chaser is free only after it. So it counts to
    the service, and to the window of that.

    Parameters
    ----------
    instance : Instance
    chaser : int, optional
        Number of the one whose times they are; by default those in which some chaser is there.
    corrections : Corrections
        Times of services other than the mission's, and what tows get beyond what they take.
    """
    mission, first = instance.mission, instance.first_target
    # Nothing is counted in the period of a body without an orbit.
    periods = np.nan_to_num(np.array([revolution_at(row, EPOCH_S) for row in instance.orbits()]))
    service = mission.refuel_revolutions * periods
    if mission.service_revolutions is not None:
        service[first:] = mission.service_revolutions * periods[first:]
    else:
        service[first:] = mission.service_s
    numbers = range(len(instance.chasers)) if chaser is None else [chaser]
    available = [_seconds(instance.available_s[number]) for number in numbers]
    begin, end = min(begin for begin, _ in available), max(end for _, end in available)
    duration = min(mission.duration_s, end) + SLACK_S
    opens, latest = np.full(periods.size, begin), np.full(periods.size, math.inf)
    for body, target in enumerate(instance.targets, start=first):
        opened, closed = _seconds(target.window_s)
        opens[body], latest[body] = max(begin, opened), closed + SLACK_S - service[body]
    for name, service_s in corrections.services_s.items():
        service[instance.names.index(name)] = service_s
    for body, station in enumerate(instance.stations):
        if station.max_refuellings == 0:
            latest[body] = -math.inf
    for body, least_s in removal_times(instance, numbers).items():
        service[body] += least_s + corrections.stays_s.get(instance.names[body], 0.0)
    service.setflags(write=False)
    latest = np.minimum(latest, duration - service)
    windows = windows_of(np.arange(periods.size), opens, latest)
    return ServiceLimits(service, windows, begin, duration)


def removal_times(instance: Instance, chasers: Iterable[int]) -> dict[int, float]:
    """Least time that one of some chasers takes for each removal, by number of the body [s]."""
    drives = {drive_of(instance.chasers[number], instance.targets) for number in chasers}
    found: dict[int, float] = {}
    for drive in drives:
        for body, removal in removals_of(instance, drive).items():
            found[body] = min(found.get(body, math.inf), removal.time_s)
    return found


def service_begins(instance: Instance, leg: Leg) -> float:
    """Start of the service at the end of a leg: on arrival, or when the window opens [s].

    Of a plan that is wrong about its times no later than the leg ends.
    """
    opens = {target.name: target.window_s[0] for target in instance.targets}
    opening = min(opens.get(leg.destination, 0.0), leg.end_s)
    return max(leg.arrival_s, opening)


def _seconds(window: Window) -> tuple[float, float]:
    """A window as two numbers, +inf if it never closes [s]."""
    opens, closes = window
    return opens, math.inf if closes is None else closes
