"""Ends of legs: data that determine the legs of all pairs of an instance.

They also say until when bodies can be met within the limits of altitude (docs/model.md section
1.5). A chaser passes the perigee of a body on its true orbit, at the size that this has by then.
Where the perigee is below ``min_altitude_m``, no leg leads there, and where it sinks below, none
later. A body whose circle is below from the beginning is one that the mission means to meet: then
the limit is that circle. Neither do legs lead to objects that would be released too far from the
circle of disposal, or stay in orbit for too long.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from ...common.constants import DAY_S, EARTH_RADIUS_M, MU_M3_S2, SLACK_M_S, SLACK_S
from ...kernels.core.windows import latest_arrival
from ...kernels.legs.departure_events import Times
from ...kernels.orbits.body_rows import launched
from ...plan.after_tows import leaving_eccentricity_delta_v, leaving_orbits, pieced_of
from ...plan.lifetimes import unreleasable
from ...plan.tows import RemovalFlight, any_from_apogee, removals_of
from ...problem.drives import Drive
from ...problem.instance import Instance
from ...problem.orbit import Orbit
from ..service_limits import services_s, windows_at
from .family import FloatArray, PairEnds, PiecedEnd

SPARE_S = 7200.0
"""Margin of a last departure before a body is too low: legs on a grid leave a lap later [s]."""

RELEASE_M, RELEASE_SPARE_M = 10e3, 100.0
"""Largest distance of a release from the circle of disposal, as in `check`, and the margin in it
for the harmonics [m]."""

MOST_ECCENTRICITY = 0.5
"""Eccentricity far above any release near a circle."""

PLACES, HALVINGS = 72, 40
"""Numbers of places of an orbit where tows may begin, and of halvings of a time."""


class AltitudeLimits(NamedTuple):
    """Latest times at bodies [s]: −inf for never, +inf where nothing sinks.

    Attributes
    ----------
    arrive_by, leave_by : (bodies,) float64
    """

    arrive_by: FloatArray
    leave_by: FloatArray

    def bars(self, i: int, j: int) -> bool:
        """Whether no leg leads from one body to another one."""
        return bool(self.leave_by[i] < 0.0 or self.arrive_by[j] < 0.0)


def altitude_limits(instance: Instance, drive: Drive | None) -> AltitudeLimits:
    """Latest times at the bodies of an instance, for chasers with a drive or with impulses.

    They are those of `check` less some time, so that no plan breaks them by rounding.
    """
    bodies = len(instance.names)
    arrive_by, leave_by = np.full((2, bodies), math.inf)
    if instance.given is not None:
        return AltitudeLimits(arrive_by, leave_by)
    tows, stays_s = removals_of(instance, drive), services_s(instance)
    fits = [None] * instance.first_target + [target.fit for target in instance.targets]
    windows = windows_at(instance)
    sinking = instance.decays_m_per_day
    for body, orbit in enumerate(instance.body_orbits):
        fit, sinks_m_s = fits[body], sinking[body] / DAY_S
        offset = (0.0, 0.0) if fit is None else fit.eccentricity_offset
        eccentricity = orbit.eccentricity + math.hypot(*offset)
        if eccentricity == 0.0 and sinks_m_s <= 0.0:
            continue
        until = _above(orbit, eccentricity, sinks_m_s, instance.transfer.min_altitude_m)
        tow = tows.get(body)
        if tow is not None and tow.apogees is not None:
            # Apogees are those of the part of the eccentricity vector that turns.
            until = -math.inf if fit is not None and any(fit.eccentricity_offset) else until
        elif tow is not None and tow.burns_m_s is not None:
            shaped = orbit.semi_major_axis_m, min(eccentricity, MOST_ECCENTRICITY)
            until = min(until, _released_well(*shaped, tow, sinks_m_s, instance.mission.duration_s))
        leave_by[body] = until - SPARE_S + (0.0 if tow is None else tow.time_s)
        begin_by = until - SPARE_S - stays_s[body]
        arrive_by[body] = begin_by
        if begin_by < windows.closing[body]:  # waiting for a window takes time, too
            arrive_by[body] = latest_arrival(windows, body, begin_by)
    arrive_by[list(unreleasable(instance, drive))] = -math.inf
    for array in (arrive_by, leave_by):
        array.setflags(write=False)
    return AltitudeLimits(arrive_by, leave_by)


def _above(orbit: Orbit, eccentricity: float, sinks_m_s: float, least_m: float) -> float:
    """Time until which the perigee of a decaying orbit is above a limit; −inf for never [s]."""
    axis = orbit.semi_major_axis_m
    least = min(EARTH_RADIUS_M + least_m, axis)
    spare = axis * (1.0 - eccentricity) - least
    if spare < 0.0:
        return -math.inf
    return spare / ((1.0 - eccentricity) * sinks_m_s) if sinks_m_s > 0.0 else math.inf


def _released_well(
    size_m: float, eccentricity: float, tow: RemovalFlight, sinks_m_s: float, duration_s: float
) -> float:
    """Time until which a tow from anywhere on an orbit ends near the circle of disposal [s]."""

    def is_near(time_s: float) -> bool:
        off = _release_off_m(size_m - sinks_m_s * time_s, eccentricity, tow)
        return off <= RELEASE_M - RELEASE_SPARE_M

    if not is_near(0.0):
        return -math.inf
    if is_near(duration_s):
        return math.inf
    low, high = 0.0, duration_s
    for _ in range(HALVINGS):
        middle = 0.5 * (low + high)
        low, high = (middle, high) if is_near(middle) else (low, middle)
    return low


def _release_off_m(axis: float, eccentricity: float, tow: RemovalFlight) -> float:
    """Largest distance of an apsis of the release from its circle, over all places of a tow [m].

    Both burns are against the motion, and the time between them is that in which a circle turns by
    half a revolution.
    """
    assert tow.burns_m_s is not None
    true = np.arange(PLACES) * (math.tau / PLACES)
    radius = axis * (1.0 - eccentricity**2) / (1.0 + eccentricity * np.cos(true))
    x, y = radius * np.cos(true), radius * np.sin(true)
    pace = math.sqrt(MU_M3_S2 / (axis * (1.0 - eccentricity**2)))
    state = np.array([x, y, -pace * np.sin(true), pace * (eccentricity + np.cos(true))])
    state[2:] *= 1.0 - tow.burns_m_s[0] / np.hypot(*state[2:])
    half = 0.5 * (axis + tow.radius_m)
    state = _coasted(state, math.pi * math.sqrt(half**3 / MU_M3_S2))
    state[2:] *= 1.0 - tow.burns_m_s[1] / np.hypot(*state[2:])
    size, shape = _size_and_shape(state)
    apsides = np.array([size * (1.0 - shape), size * (1.0 + shape)])
    return float(np.max(np.abs(apsides - tow.radius_m)))


def _size_and_shape(state: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Semi-major axes [m] and eccentricities of states in one plane."""
    radius, square = np.hypot(*state[:2]), state[2] ** 2 + state[3] ** 2
    radial = state[0] * state[2] + state[1] * state[3]
    vector = ((square - MU_M3_S2 / radius) * state[:2] - radial * state[2:]) / MU_M3_S2
    return 1.0 / (2.0 / radius - square / MU_M3_S2), np.hypot(*vector)


def _coasted(state: FloatArray, time_s: float) -> FloatArray:
    """States in one plane, shape (4, states), after a time, by Lagrange's coefficients."""
    radius = np.hypot(*state[:2])
    axis = _size_and_shape(state)[0]
    cosine = 1.0 - radius / axis
    sine = (state[0] * state[2] + state[1] * state[3]) / np.sqrt(MU_M3_S2 * axis)
    motion = np.sqrt(MU_M3_S2 / axis**3)
    turned = motion * time_s
    for _ in range(12):
        c, s = np.cos(turned), np.sin(turned)
        off = turned - cosine * s + sine * (1.0 - c) - motion * time_s
        turned = turned - off / (1.0 - cosine * c + sine * s)
    c, s = np.cos(turned), np.sin(turned)
    there = axis * (1.0 - cosine * c + sine * s)
    f, g = 1.0 - axis / radius * (1.0 - c), time_s - (turned - s) / motion
    f_rate, g_rate = (
        -np.sqrt(MU_M3_S2 * axis) / (there * radius) * s,
        1.0 - axis / there * (1.0 - c),
    )
    return np.concatenate([f * state[:2] + g * state[2:], f_rate * state[:2] + g_rate * state[2:]])


class AllEnds:
    """Data on the ends of legs, for all pairs of an instance.

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
    launched : set of int
        Circles that are launched into, which are left in the plane of the destination's node.
    pieced : dict of int to PiecedEnd
        Bodies that are left piece by piece of time, by number.
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
        every = zip(instance.starts, instance.chasers, strict=True)
        self.launched = {body for body, chaser in every if chaser.launch is not None}
        self.pieced: dict[int, PiecedEnd] = {}
        if self.times is not None:
            interval_s, step_s, longest_s, *_ = self.times
            until_s = self.latest_s if longest_s > 0.0 else 0.0
            for body, pieced in pieced_of(instance, removals_of(instance, drive)).items():
                pieces = pieced.spaced(interval_s, self.latest_s)
                self.pieced[body] = PiecedEnd(pieced, pieces, pieced.on_grid(step_s, until_s))

    def of(self, i: int, j: int) -> PairEnds:
        """The ends of a pair."""
        leave_by, arrive_by = self.altitudes.leave_by[i], self.altitudes.arrive_by[j]
        left, times = self.leaving[i], self.times
        if times is not None:
            times = times._replace(leave_by=float(leave_by))
        if i in self.launched:
            left = launched(left, self.arriving[j])
            # In the plane of the target there is nothing to drift for.
            times = times._replace(longest=0.0) if times and self.drive is None else times
        return PairEnds(
            self.instance,
            i,
            j,
            left,
            self.arriving[j],
            self.eccentricity_m_s[i, j],
            self.rule,
            times,
            min(self.latest_s, float(arrive_by)),
            self.drive,
            self.relaxed,
            self.pieced.get(i),
        )


def is_regular(instance: Instance) -> bool:
    """Whether departure events are those of two-body motion, with the model's connections.

    No tow then ends once a revolution, either.
    """
    spacing_s, dynamics = instance.transfer.departure_spacing_s, instance.dynamics
    return dynamics == "two-body" and spacing_s == 0.0 and not any_from_apogee(instance)


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
    """Costs, with +inf for pairs that no leg connects."""
    barred = (altitudes.leave_by < 0.0)[:, None] | (altitudes.arrive_by < 0.0)
    return np.where(barred, math.inf, costs) if barred.any() else costs
