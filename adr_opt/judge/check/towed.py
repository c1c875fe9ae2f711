"""Towed objects, recomputed by the judge: cost and duration of tows, and orbits of release."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from ...common.constants import DAY_S, EARTH_RADIUS_M, MU_M3_S2
from ...kernels.orbits import ephemeris
from ...kernels.orbits.body_rows import as_left, with_orbit
from ...problem.bodies import Target
from ...problem.disposal import Disposal, DisposalCircle, DisposalPerigee
from ...problem.drives import Drive
from ...problem.instance import Instance

FloatArray = npt.NDArray[np.float64]

SPIRAL_STEPS = 2000
"""Number of steps of a spiral."""

MOST_LOST_M_S = 1.0
"""Cost of eccentricity v e / 2 from which a tow has to begin at an apogee [m/s]."""

SAME_LAP = 1e-6
"""Part of a revolution by which a time before an apogee still counts as that of the apogee."""


class Towed(NamedTuple):
    """A towed object.

    Attributes
    ----------
    orbit : (columns,) float64
        Of the object, as of :data:`adr_opt.kernels.orbits.ephemeris.ORBIT_COLUMNS`.
    left : (columns + 1,) float64
        Of a body that is where the chaser is that leaves at a time, and how fast its node moves
        after that; of a tow from apogee at the epoch, see :meth:`left_at`.
    time_s, flight_s : float
        How long the tow takes, and from its first burn to the last.
    delta_v_m_s, back_m_s, mass_kg : float
        Its ΔV, that which the chaser takes alone, and the mass of the object.
    shift, turned : float
        How far its node moves between the burns, and the argument of latitude [rad].
    slower : tuple of float or None
        What its burns take off the speed [m/s]; None for a spiral of low thrust.
    released_m : (float, float)
        Radii of perigee and apogee of the orbit that it has to be left on.
    sinks_m_s : float
        How fast its orbit shrinks.
    offset : (float, float)
        Constant part of its eccentricity vector, towards the node and a quarter lap later.
    period_s : float
        From one apogee to the next where it begins at one, else 0.
    left_on : (float, float)
        Semi-major axis [m] and eccentricity of the orbit that the chaser goes on from.
    oblateness_m2 : float
        J2 R², 0 for two bodies.
    """

    orbit: FloatArray
    left: FloatArray
    time_s: float
    flight_s: float
    delta_v_m_s: float
    back_m_s: float
    mass_kg: float
    shift: float
    turned: float
    slower: tuple[float, ...] | None
    released_m: tuple[float, float]
    sinks_m_s: float
    offset: tuple[float, float]
    period_s: float
    left_on: tuple[float, float]
    oblateness_m2: float

    def begins_s(self, ends_s: float) -> float:
        """First burn of a tow that has to end by a time; at an apogee if it must be [s]."""
        begins_s = ends_s - self.flight_s
        if not self.period_s:
            return begins_s
        mean = ephemeris.latitude_at(self.orbit, begins_s) - ephemeris.perigee_at(
            self.orbit, begins_s
        )
        past = float(mean - math.pi) / math.tau
        return begins_s - (past - math.floor(past + SAME_LAP)) * self.period_s

    def left_at(self, time_s: float) -> FloatArray:
        """Row of a body at the place of a chaser that leaves at a time, shape (columns + 1,)."""
        if not self.period_s:
            return self.left
        begun_s, (axis, shape) = self.begins_s(time_s), self.left_on
        tilt, perigee, node = (
            float(of(self.orbit, begun_s))
            for of in (ephemeris.inclination_at, ephemeris.perigee_at, ephemeris.node_at)
        )
        since_s, latitude = begun_s + self.flight_s, perigee + math.pi + self.turned
        rates = ephemeris.secular_rates(axis, shape, tilt, self.oblateness_m2)
        row = ephemeris.body_row(
            axis,
            tilt,
            node + self.shift - rates[0] * since_s,
            latitude - (rates[1] + rates[2]) * since_s,
            eccentricity=shape,
            perigee=perigee - rates[1] * since_s,
            oblateness_m2=self.oblateness_m2,
        )
        left: FloatArray = as_left(np.array([row]))[0]
        return left


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
    offset = (0.0, 0.0) if target.fit is None else target.fit.eccentricity_offset
    disposal, oblateness = instance.disposal_of(target), instance.oblateness_m2
    high = float(ephemeris.radius_at(orbit, ephemeris.EPOCH_S))
    tilt = float(ephemeris.inclination_at(orbit, ephemeris.EPOCH_S))
    shape = float(ephemeris.eccentricity_at(orbit, ephemeris.EPOCH_S))
    is_perigee = isinstance(disposal, DisposalPerigee)
    loses = 0.5 * math.sqrt(MU_M3_S2 / high) * shape
    if drive is None and (is_perigee or loses >= MOST_LOST_M_S):
        least = EARTH_RADIUS_M + instance.transfer.min_altitude_m
        return _from_apogee(orbit, disposal, least, mass_kg, (sinks_m_s, offset), oblateness)
    assert isinstance(disposal, DisposalCircle)
    low = EARTH_RADIUS_M + disposal.circle_m
    axis = 0.5 * (high + low)
    time = math.pi / float(ephemeris.latitude_rate(axis, tilt, oblateness))
    shift, turned = time * float(ephemeris.node_rate(axis, tilt, oblateness)), math.pi
    burns = (
        math.sqrt(MU_M3_S2 / high) - _speed(high, axis),
        _speed(low, axis) - math.sqrt(MU_M3_S2 / low),
    )
    delta_v = abs(burns[0]) + abs(burns[1])
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
    return Towed(
        orbit=orbit,
        left=left,
        time_s=time,
        flight_s=time,
        delta_v_m_s=delta_v,
        back_m_s=0.0,
        mass_kg=mass_kg,
        shift=shift,
        turned=turned,
        slower=None if drive is not None else burns,
        released_m=(low, low),
        sinks_m_s=sinks_m_s,
        offset=offset,
        period_s=0.0,
        left_on=(low, 0.0),
        oblateness_m2=oblateness,
    )


def _speed(radius: float, axis: float) -> float:
    """Speed at a radius on an orbit with a semi-major axis [m/s]."""
    return math.sqrt(MU_M3_S2 * (2.0 / radius - 1.0 / axis))


def _from_apogee(
    orbit: FloatArray,
    disposal: Disposal | None,
    least: float,
    mass_kg: float,
    unplanned: tuple[float, tuple[float, float]],
    oblateness: float,
) -> Towed:
    """A tow that begins at an apogee, from the ellipse of the object."""
    axis, shape, tilt = (
        float(of(orbit, ephemeris.EPOCH_S))
        for of in (ephemeris.radius_at, ephemeris.eccentricity_at, ephemeris.inclination_at)
    )
    top, begun = axis * (1.0 + shape), _speed(axis * (1.0 + shape), axis)
    time = shift = turned = back = 0.0
    slower: tuple[float, ...]
    if isinstance(disposal, DisposalPerigee):
        low = min(EARTH_RADIUS_M + disposal.perigee_m, axis * (1.0 - shape))
        after, kept = _speed(top, 0.5 * (top + low)), _speed(top, 0.5 * (top + max(low, least)))
        back = kept - after
        slower = (begun - after, after - kept)[: 2 if low < least else 1]
        released, ends = (low, top), (max(low, least), top)
    else:
        assert isinstance(disposal, DisposalCircle)
        circle = EARTH_RADIUS_M + disposal.circle_m
        middle = 0.5 * (top + circle)
        slower = (
            begun - _speed(top, middle),
            _speed(circle, middle) - math.sqrt(MU_M3_S2 / circle),
        )
        time = math.pi / float(ephemeris.latitude_rate(middle, tilt, oblateness))
        shift, turned = time * float(ephemeris.node_rate(middle, tilt, oblateness)), math.pi
        released = ends = circle, circle
    rate = ephemeris.latitude_rate_at(orbit, ephemeris.EPOCH_S) - ephemeris.perigee_rate_at(
        orbit, ephemeris.EPOCH_S
    )
    period = math.tau / float(rate)
    found = Towed(
        orbit=orbit,
        left=as_left(orbit[None])[0],
        time_s=period + time,
        flight_s=time,
        delta_v_m_s=math.fsum(map(abs, slower)),
        back_m_s=back,
        mass_kg=mass_kg,
        shift=shift,
        turned=turned,
        slower=slower,
        released_m=released,
        sinks_m_s=unplanned[0],
        offset=unplanned[1],
        period_s=period,
        left_on=(0.5 * (ends[0] + ends[1]), (ends[1] - ends[0]) / (ends[1] + ends[0])),
        oblateness_m2=oblateness,
    )
    return found._replace(left=found.left_at(found.time_s))
