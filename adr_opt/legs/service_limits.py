"""Service windows and durations of bodies, as arrays."""

from __future__ import annotations

import math
from collections.abc import Iterable

import numpy as np

from ..common.constants import SLACK_S
from ..kernels.core.windows import FloatArray, IntArray, Windows, service_ends, windows_of
from ..kernels.orbits.ephemeris import EPOCH_S, revolution_at
from ..kernels.tables.timetable_making import ServiceLimits
from ..plan.plan import Leg
from ..plan.tows import removals_of
from ..problem.capture_windows import intervals_of
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
    service = services_s(instance)
    numbers = range(len(instance.chasers)) if chaser is None else [chaser]
    available = intervals_of(instance.available_s[number] for number in numbers)
    begin, end = float(available[:, 0].min()), float(available[:, 1].max())
    duration = min(instance.mission.duration_s, end) + SLACK_S
    body, opens, latest = _begins(instance, service, begin)
    for name, service_s in corrections.services_s.items():
        service[instance.names.index(name)] = service_s
    for towed, least_s in removal_times(instance, numbers).items():
        service[towed] += least_s + corrections.stays_s.get(instance.names[towed], 0.0)
    service.setflags(write=False)
    windows = windows_of(body, opens, np.minimum(latest, (duration - service)[body]))
    return ServiceLimits(service, windows, begin, duration)


def _begins(
    instance: Instance, service: FloatArray, begin: float
) -> tuple[IntArray, FloatArray, FloatArray]:
    """Body of each interval, and the times in it at which services may begin [s]."""
    first, never = instance.first_target, np.array([[0.0, -math.inf]])
    lists = [np.array([[0.0, math.inf]])] * first
    for number, station in enumerate(instance.stations):
        if station.max_refuellings == 0:
            lists[number] = never
    for body, target in enumerate(instance.targets, start=first):
        intervals = instance.intervals_of(target)
        stay_s = float(service[body])
        capture_s = stay_s if target.capture_s is None else min(target.capture_s, stay_s)
        begins = intervals + np.array([0.0, SLACK_S - capture_s])
        lists.append(begins if len(intervals) else never)
    bodies = np.repeat(np.arange(len(lists)), [len(each) for each in lists])
    opens, latest = np.concatenate(lists).T
    return bodies, np.maximum(opens, begin), latest.copy()


def removal_times(instance: Instance, chasers: Iterable[int]) -> dict[int, float]:
    """Least time that any of some chasers needs for each removal, by number of the body [s]."""
    drives = {drive_of(instance.chasers[number], instance.targets) for number in chasers}
    found: dict[int, float] = {}
    for drive in drives:
        for body, removal in removals_of(instance, drive).items():
            found[body] = min(found.get(body, math.inf), removal.time_s)
    return found


def service_begins(instance: Instance, leg: Leg) -> float:
    """Start of the service at the end of a leg: on arrival, or when the window opens [s].

    Of a plan that is wrong about its times no later than the leg ends, and at nobody on arrival.
    """
    if leg.destination not in instance.names:
        return min(leg.arrival_s, leg.end_s)
    begin = service_ends(windows_at(instance), instance.names.index(leg.destination), leg.arrival_s)
    return min(float(begin), leg.end_s)


def windows_at(instance: Instance) -> Windows:
    """Windows of an instance's bodies, regardless of the limits of the mission and chasers."""
    return windows_of(*_begins(instance, services_s(instance), -math.inf))


def services_s(instance: Instance) -> FloatArray:
    """Time of a service at each body, or of a refuelling [s]."""
    mission, first = instance.mission, instance.first_target
    # Nothing is counted in the period of a body without an orbit.
    periods = np.nan_to_num(np.array([revolution_at(row, EPOCH_S) for row in instance.orbits()]))
    service: FloatArray = mission.refuel_revolutions * periods
    if mission.service_revolutions is not None:
        service[first:] = mission.service_revolutions * periods[first:]
    else:
        service[first:] = mission.service_s
    return service
