"""Tows, restated: their cost, their time, and the orbit where the chaser continues."""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from ...common.constants import DAY_S, EARTH_RADIUS_M, MU_M3_S2
from ...kernels.orbits import ephemeris
from ...kernels.orbits.body_rows import as_left, with_orbit
from ...plan.plan import Burn, Leg
from ...problem.bodies import Target
from ...problem.drives import Drive
from ...problem.instance import Instance
from .violation import DELTA_V_TOLERANCE_M_S, MOST_RELEASE_OFF_M, TIME_TOLERANCE_S, Violation
from .zone_crossings import KEPLER_STEPS, ZonedArc

FloatArray = npt.NDArray[np.float64]

SPIRAL_STEPS = 2000
"""Number of steps of a spiral."""

RELEASE_SPARE_M, PLACES = 500.0, 24
"""How much nearer than the limit a release has to be for all places of an orbit [m], and the number
of places."""


class Towed(NamedTuple):
    """A towed object.

    Attributes
    ----------
    orbit : (columns,) float64
        Of the object, as of :data:`adr_opt.kernels.orbits.ephemeris.ORBIT_COLUMNS`.
    left : (columns + 1,) float64
        Of a body that is where the chaser is that leaves at a time, and how fast its node moves
        after that.
    time_s, delta_v_m_s, mass_kg : float
        How long the tow takes, its ΔV, and the mass of the object.
    shift : float
        How far its node moves [rad].
    slower : (float, float) or None
        What its burns take off the speed [m/s]; None for a spiral of low thrust.
    sinks_m_s : float
        How fast its orbit shrinks.
    offset : (float, float)
        Constant part of its eccentricity vector, towards the node and a quarter lap later.
    """

    orbit: FloatArray
    left: FloatArray
    time_s: float
    delta_v_m_s: float
    mass_kg: float
    shift: float
    slower: tuple[float, float] | None
    sinks_m_s: float
    offset: tuple[float, float]


def towed_bodies(instance: Instance, elements: FloatArray, drive: Drive | None) -> dict[str, Towed]:
    """Objects towed by chasers with a drive, or with impulses, by name."""
    return {
        target.name: _towed(instance, elements[body], target, drive)
        for body, target in enumerate(instance.targets, start=instance.first_target)
        if target.removal == "tow"
    }


def _spiral(
    drive: Drive, high: float, low: float, tilt: float, oblateness: float, mass_kg: float
) -> tuple[float, float, float, float]:
    """Time [s], ΔV [m/s], and the shifts of node and argument of latitude [rad] of a spiral.

    In small steps of the speed, with the mass as it is and the longest shadow.
    """
    start, end = math.sqrt(MU_M3_S2 / high), math.sqrt(MU_M3_S2 / low)
    both = drive.heaviest_kg + mass_kg
    lit = 1.0 - math.asin(EARTH_RADIUS_M / low) / math.pi
    step = (end - start) / SPIRAL_STEPS
    time = node = latitude = 0.0
    for number in range(SPIRAL_STEPS):
        middle = start + (number + 0.5) * step
        radius = MU_M3_S2 / middle**2
        mass = both * math.exp(-(middle - start) / drive.exhaust_m_s)
        time += step * mass / (drive.thrust_n * lit)
        node += float(ephemeris.node_rate(radius, tilt, oblateness)) / SPIRAL_STEPS
        latitude += float(ephemeris.latitude_rate(radius, tilt, oblateness)) / SPIRAL_STEPS
    return time, end - start, node * time, latitude * time


def _towed(instance: Instance, orbit: FloatArray, target: Target, drive: Drive | None) -> Towed:
    mass_kg, sinks_m_s = float(target.mass_kg or 0.0), (target.decay_m_per_day or 0.0) / DAY_S
    low = EARTH_RADIUS_M + instance.circle_m(target)
    high = float(ephemeris.radius_at(orbit, ephemeris.EPOCH_S))
    tilt = float(ephemeris.inclination_at(orbit, ephemeris.EPOCH_S))
    oblateness, axis = instance.oblateness_m2, 0.5 * (high + low)
    time = math.pi / float(ephemeris.latitude_rate(axis, tilt, oblateness))
    shift, turned = time * float(ephemeris.node_rate(axis, tilt, oblateness)), math.pi
    burns = (
        math.sqrt(MU_M3_S2 / high) - math.sqrt(MU_M3_S2 * (2.0 / high - 1.0 / axis)),
        math.sqrt(MU_M3_S2 * (2.0 / low - 1.0 / axis)) - math.sqrt(MU_M3_S2 / low),
    )
    delta_v = burns[0] + burns[1]
    if drive is not None:
        time, delta_v, shift, turned = _spiral(drive, high, low, tilt, oblateness, mass_kg)
    # A chaser that leaves at t = 0 began to tow a while before, at the object's angles then.
    left = with_orbit(
        as_left(orbit[None])[0],
        radius_m=low,
        node=float(ephemeris.node_at(orbit, -time)) + shift,
        latitude=float(ephemeris.latitude_at(orbit, -time)) + turned,
        eccentricity=0.0,
        coasting_node_rate=float(ephemeris.node_rate(low, tilt, oblateness)),
    )
    slower = None if drive is not None else burns
    offset = (0.0, 0.0) if target.fit is None else target.fit.eccentricity_offset
    return Towed(orbit, left, time, delta_v, mass_kg, shift, slower, sinks_m_s, offset)


def check_tow(
    towed: Towed | None,
    number: int,
    leg: Leg,
    end: float,
    following: Leg | None,
    oblateness_m2: float,
) -> Iterator[Violation]:
    """Check the tow after a leg if one is due, and its absence otherwise.

    Parameters
    ----------
    towed : Towed or None
        The destination, where it is towed.
    number : int
    leg : Leg
    end : float
        Of the service [s].
    following : Leg or None
        The leg that the same chaser flies next.
    oblateness_m2 : float
        J2 R², 0 for two bodies.
    """
    if towed is None or leg.tow is None:
        if (towed is None) != (leg.tow is None):
            stated = "towed" if leg.tow else "not towed"
            yield Violation(number, "tow", f"{leg.destination!r} is {stated} by the plan")
        return
    # Who leads nowhere after it may wait before it, too, as far as the mission goes.
    soonest = end + towed.time_s
    last = max(soonest, leg.tow.end_s) if following is None else following.leaves_s
    for name, stated_s, true in (
        ("start_s", leg.tow.start_s, last - towed.time_s),
        ("end_s", leg.tow.end_s, last),
    ):
        if abs(stated_s - true) > TIME_TOLERANCE_S:
            yield Violation(number, "tow", f"{name} = {stated_s!r} of the tow, but it is {true!r}")
    if abs(leg.tow.delta_v_m_s - towed.delta_v_m_s) > DELTA_V_TOLERANCE_M_S:
        yield Violation(
            number,
            "tow",
            f"delta_v_m_s = {leg.tow.delta_v_m_s!r} of the tow, but it takes {towed.delta_v_m_s!r}",
        )
    times = last - towed.time_s, last
    if towed.slower is None:
        if leg.tow.burns:
            yield Violation(number, "tow", "is a spiral, which has no burns")
        return
    if [burn.phase for burn in leg.tow.burns] != ["tow", "tow"]:
        yield Violation(number, "tow", "must have two burns of the phase 'tow'")
        return
    for which, burn in enumerate(leg.tow.burns):
        yield from _check_burn(towed, number, which, burn, times)
    low, high = released_between(towed, times, oblateness_m2)
    circle = float(ephemeris.radius_at(towed.left, ephemeris.EPOCH_S))
    if max(abs(low - circle), abs(high - circle)) > MOST_RELEASE_OFF_M:
        low, high, circle = ((radius - EARTH_RADIUS_M) / 1e3 for radius in (low, high, circle))
        yield Violation(
            number,
            "release",
            f"{leg.destination!r} is released at {low:.1f} × {high:.1f} km, more than "
            f"{MOST_RELEASE_OFF_M / 1e3:g} km off the circle at {circle:g} km",
        )


def may_end_far(towed: Towed, time_s: float, oblateness_m2: float) -> bool:
    """Whether a tow in the revolution after a time [s] may end nearly as far off as is allowed."""
    if towed.slower is None:
        return False
    circle = float(ephemeris.radius_at(towed.left, ephemeris.EPOCH_S))
    lap_s = math.tau / float(ephemeris.latitude_rate_at(towed.orbit, time_s))
    for place in range(PLACES):
        begin_s = time_s + place / PLACES * lap_s
        between = released_between(towed, (begin_s, begin_s + towed.time_s), oblateness_m2)
        if max(abs(radius - circle) for radius in between) > MOST_RELEASE_OFF_M - RELEASE_SPARE_M:
            return True
    return False


def released_between(
    towed: Towed, times: tuple[float, float], oblateness_m2: float
) -> tuple[float, float]:
    """Radii of perigee and apogee of an object that two burns against the motion lead down [m].

    It begins on its true orbit, as large as that is by then.
    """
    assert towed.slower is not None
    position, velocity = _true_state(towed, times[0])
    velocity -= towed.slower[0] / float(np.linalg.norm(velocity)) * velocity
    arc = ZonedArc(position, velocity, *times, oblateness_m2)
    position, velocity = arc.state_at_end()
    velocity -= towed.slower[1] / float(np.linalg.norm(velocity)) * velocity
    after = ZonedArc(position, velocity, times[1], times[1], oblateness_m2)
    shape = math.hypot(after.e_cos, after.e_sin)
    return after.a * (1.0 - shape), after.a * (1.0 + shape)


def _true_state(towed: Towed, time_s: float) -> tuple[FloatArray, FloatArray]:
    """Position and velocity of an object on its true orbit at a time [m], [m/s]."""
    row = towed.orbit
    e, perigee = (
        float(of(row, time_s)) for of in (ephemeris.eccentricity_at, ephemeris.perigee_at)
    )
    axis = float(ephemeris.radius_at(row, time_s)) - towed.sinks_m_s * time_s
    # With what odd harmonics add to the eccentricity vector.
    to_node = e * math.cos(perigee) + towed.offset[0]
    after = e * math.sin(perigee) + towed.offset[1]
    e, perigee = math.hypot(to_node, after), math.atan2(after, to_node)
    mean = math.remainder(float(ephemeris.latitude_at(row, time_s)) - perigee, math.tau)
    anomaly = mean
    for _ in range(KEPLER_STEPS):
        anomaly -= (anomaly - e * math.sin(anomaly) - mean) / (1.0 - e * math.cos(anomaly))
    ascending, ahead, _ = ephemeris.frame(
        ephemeris.inclination_at(row, time_s), ephemeris.node_at(row, time_s)
    )
    to_perigee = math.cos(perigee) * ascending + math.sin(perigee) * ahead
    across = math.cos(perigee) * ahead - math.sin(perigee) * ascending
    root, motion = math.sqrt(1.0 - e * e), math.sqrt(MU_M3_S2 / axis**3)
    c, s = math.cos(anomaly), math.sin(anomaly)
    pace = axis * motion / (1.0 - e * c)
    position = axis * ((c - e) * to_perigee + root * s * across)
    return position, pace * (root * c * across - s * to_perigee)


def _check_burn(
    towed: Towed, number: int, which: int, burn: Burn, times: tuple[float, float]
) -> Iterator[Violation]:
    """Check that a tow's burn opposes the motion, in the plane of the object at that time."""
    assert towed.slower is not None
    raan = ephemeris.node_at(towed.orbit, times[0]) + which * towed.shift
    latitude = ephemeris.latitude_at(towed.orbit, times[0]) + which * math.pi
    tilt = ephemeris.inclination_at(towed.orbit, times[0])
    ascending, ahead, _ = ephemeris.frame(tilt, raan)
    motion = math.cos(latitude) * ahead - math.sin(latitude) * ascending
    late = abs(burn.time_s - times[which])
    off = float(np.linalg.norm(np.array(burn.delta_v_m_s) + towed.slower[which] * motion))
    if late > TIME_TOLERANCE_S or off > DELTA_V_TOLERANCE_M_S:
        yield Violation(
            number, "tow", f"burn {which + 1} of the tow is off by {late:.3g} s and {off:.3g} m/s"
        )
