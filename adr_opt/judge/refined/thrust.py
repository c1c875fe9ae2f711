"""Flight with low thrust of a refined plan, for the judge: window by window, in time.

Written apart from :mod:`adr_opt.kernels.orbits.thrusting`, which found the windows: that integrates
along the longitude by an implicit method, this along the time by an explicit one
(:mod:`.propagation`), with the thrust of the file's windows and steering. How long thrust is on in
the Earth's shadow, a cylinder, is counted with other formulas for the Sun (J. Meeus, Astronomical
Algorithms, 2nd edition, 1998, chapter 25).
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from ...common.constants import EARTH_RADIUS_M, MU_M3_S2
from ...common.errors import InputError
from ...kernels.core.compile import kernel
from ...plan.refined_plan import RefinedLeg
from ...plan.refined_thrust import RefinedThrust
from ...problem.chasers import Chaser
from ...problem.drives import Drive, drive_of, since_j2000_s
from ...problem.instance import Instance
from .propagation import (
    BEFORE,
    STAGES,
    advance,
    begin_stage,
    elements_of,
    end_step,
    rates_of,
    state_of,
)

Array = npt.NDArray[np.float64]

STEPS = 72
"""Steps per revolution, as of coasts."""

DELTA_V_M_S, PROPELLANT_KG = 1e-5, 1e-6
"""Tolerances on the stated figures of arcs, against their windows."""

MOST_SHADOW_S = 1.0
"""Longest time of a leg in which thrust may be on in the Earth's shadow [s]."""

MORE_FORCE = 1.0 + 1e-9
"""Largest ratio of the force on a leg to that of its chaser."""

CENTURY_S = 36525.0 * 86400.0


class ThrustFlown(NamedTuple):
    """A flight with low thrust at its end.

    Attributes
    ----------
    state : (6,) float64
        [m, m/s].
    delta_v_m_s : float
        Of all windows.
    mass_kg : float
    shadow_s : float
        Time in which thrust was on in the shadow [s].
    lowest_m : float
        Least radius of the perigees at the ends of its windows, and of places on its coasts [m].
    """

    state: Array
    delta_v_m_s: float
    mass_kg: float
    shadow_s: float
    lowest_m: float


def refuse_wrong_thrust(instance: Instance, leg: RefinedLeg, chaser: Chaser) -> None:
    """Raise :class:`InputError` if a leg or its tows have thrust that the chaser does not have."""
    drive = drive_of(chaser, instance.targets)
    if (leg.thrust is None) != (drive is None):
        has = "no low thrust" if drive is None else "low thrust, but the leg has none"
        raise InputError(f"leg {leg.leg}: {chaser.name!r} has {has}; refine the plan again")
    masses = {target.name: target.mass_kg or 0.0 for target in instance.targets}
    for name, tow in ((leg.origin, leg.tow_before), (leg.destination, leg.tow)):
        if tow is None:
            continue
        if (tow.thrust is None) != (drive is None):
            has = "no low thrust" if drive is None else "low thrust, but a tow has none"
            raise InputError(f"leg {leg.leg}: {chaser.name!r} has {has}; refine the plan again")
        if tow.thrust is not None and drive is not None:
            _refuse_other_drive(leg.leg, tow.thrust, chaser.name, drive, masses.get(name, 0.0))
    if leg.thrust is not None and drive is not None:
        _refuse_other_drive(leg.leg, leg.thrust, chaser.name, drive, 0.0)


def _refuse_other_drive(
    number: int, thrust: RefinedThrust, name: str, drive: Drive, object_kg: float
) -> None:
    """Raise :class:`InputError` for thrust beyond that of a drive, with or without an object."""
    if thrust.force_n > MORE_FORCE * drive.thrust_n:
        raise InputError(
            f"leg {number}: force_n = {thrust.force_n!r}: the mean thrust of {name!r} over its "
            f"duty cycle is {drive.thrust_n!r}"
        )
    if abs(thrust.exhaust_m_s / drive.exhaust_m_s - 1.0) > MORE_FORCE - 1.0:
        raise InputError(
            f"leg {number}: exhaust_m_s = {thrust.exhaust_m_s!r}: {name!r} has "
            f"{drive.exhaust_m_s!r}"
        )
    if thrust.mass_kg > drive.heaviest_kg + object_kg + PROPELLANT_KG:
        raise InputError(
            f"leg {number}: mass_kg = {thrust.mass_kg!r}: {name!r} has at most "
            f"{drive.heaviest_kg + object_kg!r}"
        )
    if object_kg and thrust.mass_kg < drive.lightest_kg + object_kg - PROPELLANT_KG:
        raise InputError(
            f"leg {number}: mass_kg = {thrust.mass_kg!r}: {name!r} and the object that it tows "
            f"have at least {drive.lightest_kg + object_kg!r}"
        )


class Course(NamedTuple):
    """Outcome of a flight with thrust.

    Attributes
    ----------
    leg : int
        Number of the leg.
    begin_s, end_s : float
    burnt_m_s : float
        ΔV of burns that take propellant after it.
    """

    leg: int
    begin_s: float
    end_s: float
    burnt_m_s: float


def fly_thrust(
    instance: Instance, thrust: RefinedThrust, course: Course, state: Array, zonals: Array
) -> ThrustFlown:
    """Fly windows of thrust and the coasts between them.

    Parameters
    ----------
    instance : Instance
    thrust : RefinedThrust
    course : Course
    state : (6,) float64
        At its beginning [m, m/s].
    zonals : (3,) float64
        J2, J3 and J4.

    Raises
    ------
    InputError
        ΔV or propellant of the file are not those of its windows.
    ArithmeticError
        The orbit is not closed.
    """
    exhaust = thrust.exhaust_m_s
    elements, now = elements_of(state), course.begin_s
    flow, mass, dark = thrust.force_n / exhaust, thrust.mass_kg, 0.0
    epoch, lowest = since_j2000_s(instance.epoch), math.inf
    for arc in thrust.arcs:
        steering = np.array(arc.steering)
        before = mass
        for start, end in arc.windows_s:
            coasted = advance(elements, start - now, _steps(elements, start - now), zonals)
            lowest = min(lowest, coasted, _perigee(elements))
            push = np.array([mass, thrust.force_n, flow, epoch + start])
            dark += advance_pushed(
                elements, end - start, _steps(elements, end - start), zonals, steering, push
            )
            mass -= flow * (end - start)
            now = end
        _refuse_other_delta_v(course.leg, arc.delta_v_m_s, exhaust * math.log(before / mass))
    lowest = min(lowest, _perigee(elements))
    coasted = advance(elements, course.end_s - now, _steps(elements, course.end_s - now), zonals)
    found = state_of(elements)
    if not bool(np.isfinite(found).all()):
        raise ArithmeticError("the states are no longer numbers")
    used = thrust.mass_kg - mass * math.exp(-course.burnt_m_s / exhaust)
    _refuse_other_propellant(course.leg, thrust, used)
    delta_v = exhaust * math.log(thrust.mass_kg / mass)
    return ThrustFlown(found, delta_v, mass, float(dark), float(min(lowest, coasted)))


def _perigee(elements: Array) -> float:
    """Radius of the perigee [m]."""
    return float(elements[0]) / (1.0 + math.hypot(elements[1], elements[2]))


def _refuse_other_delta_v(leg: int, stated: float, flown: float) -> None:
    if abs(stated - flown) > DELTA_V_M_S:
        raise InputError(
            f"leg {leg}: an arc of {stated!r} m/s, but its windows make {flown!r}; write that"
        )


def _refuse_other_propellant(leg: int, thrust: RefinedThrust, used: float) -> None:
    if abs(thrust.propellant_kg - used) > PROPELLANT_KG:
        raise InputError(
            f"leg {leg}: propellant_kg = {thrust.propellant_kg!r}, but its arcs and burns "
            f"take {used!r}; write that"
        )


def _steps(elements: Array, duration: float) -> int:
    """Number of steps in a time.

    Raises
    ------
    ArithmeticError
        The orbit is not closed.
    """
    p, square = float(elements[0]), float(elements[1] ** 2 + elements[2] ** 2)
    if not (square < 1.0 and p > 0.1 * EARTH_RADIUS_M):
        raise ArithmeticError("the thrust leads away from the Earth or into its centre")
    revolution = math.tau * math.sqrt(_perigee(elements) ** 3 / MU_M3_S2)
    return max(1, math.ceil(abs(duration) / revolution * STEPS))


@kernel
def _push(elements: Array, steering: Array, acceleration: float, rates: Array) -> None:
    """Add the effect of a thrust [m/s²] to the rates of elements."""
    p, f, g, h, k, longitude = (
        elements[0],
        elements[1],
        elements[2],
        elements[3],
        elements[4],
        elements[5],
    )
    c, s = math.cos(longitude), math.sin(longitude)
    latitude = longitude - math.atan2(k, h)
    cosine, sine = math.cos(latitude), math.sin(latitude)
    radial = steering[0] * sine - steering[1] * cosine
    along = steering[2] + 2.0 * (steering[0] * cosine + steering[1] * sine)
    normal = steering[3] * cosine + steering[4] * sine
    size = acceleration / math.sqrt(radial**2 + along**2 + normal**2)
    radial, along, normal = size * radial, size * along, size * normal
    w = 1.0 + f * c + g * s
    pace = math.sqrt(p / MU_M3_S2)
    tilt, square = h * s - k * c, 1.0 + h * h + k * k
    rates[0] += 2.0 * p / w * pace * along
    rates[1] += pace * (radial * s + (((w + 1.0) * c + f) * along - tilt * g * normal) / w)
    rates[2] += pace * (-radial * c + (((w + 1.0) * s + g) * along + tilt * f * normal) / w)
    rates[3] += 0.5 * pace * square * normal / w * c
    rates[4] += 0.5 * pace * square * normal / w * s
    rates[5] += pace * tilt * normal / w


@kernel
def is_dark(elements: Array, since_j2000: float) -> bool:
    """Whether a position is in the Earth's cylindrical shadow, at seconds since J2000."""
    centuries = since_j2000 / CENTURY_S
    anomaly = math.radians(357.52911 + 35999.05029 * centuries)
    longitude = 280.46646 + 36000.76983 * centuries
    longitude += 1.914602 * math.sin(anomaly) + 0.019993 * math.sin(2.0 * anomaly)
    # Without the aberration, 20″.
    longitude, tilt = math.radians(longitude), math.radians(23.439291)
    x, y = math.cos(longitude), math.cos(tilt) * math.sin(longitude)
    z = math.sin(tilt) * math.sin(longitude)
    state = state_of(elements)
    towards = state[0] * x + state[1] * y + state[2] * z
    square = state[0] ** 2 + state[1] ** 2 + state[2] ** 2
    return bool(towards < 0.0 and square - towards * towards < EARTH_RADIUS_M**2)


@kernel
def advance_pushed(
    elements: Array, duration: float, steps: int, zonals: Array, steering: Array, push: Array
) -> float:
    """Propagate elements in place with thrust, in equal steps; the time spent in the shadow [s].

    Parameters
    ----------
    elements, duration, steps, zonals
        As of :func:`.propagation.advance`.
    steering : (5,) float64
        A to E of docs/model.md section 11.6.
    push : (4,) float64
        Mass [kg], force [N] and mass flow [kg/s], and the beginning from J2000 [s].
    """
    mass, force, flow, since = push[0], push[1], push[2], push[3]
    step = duration / steps
    rates, stage, lost = np.empty((STAGES, 6)), np.empty(6), np.zeros(6)
    dark = 0.0
    was_dark = is_dark(elements, since)
    for number in range(steps):
        for at in range(STAGES):
            share = 0.0
            for before in range(at):
                share += BEFORE[at, before]
            begin_stage(at, step, elements, lost, rates, stage)
            rates_of(stage, zonals, rates[at])
            _push(stage, steering, force / (mass - flow * step * (number + share)), rates[at])
        end_step(step, elements, lost, rates)
        now_dark = is_dark(elements, since + step * (number + 1))
        dark += 0.5 * step * (was_dark + now_dark)
        was_dark = now_dark
    return dark
