"""Tows: a chaser brings an object to its disposal orbit, and continues from there.

With impulses a tow is flown in the object's plane, in one of two ways:

*Between circles.* Where eccentricity costs less than :data:`APOGEE_M_S`, half an ellipse from the
circle that the object is planned on (docs/model.md section 1) to that of disposal: two burns along
the motion, half a revolution apart, begun anywhere. The object is released after the second one.
The chaser may wait before a tow, but not after it: a tow ends when the next transfer leaves. Where
there is none, plans have it follow the service at once, and it may be later.

*From apogee.* Any other object is towed on its own ellipse, coaxially, and such a tow has its first
burn at an apogee. So it takes a revolution more, in which the chaser waits for the apogee and,
after the last burn, for the next transfer: a chaser that leaves at a time t has begun at the only
apogee after t − T − P, up to t − T, with T from the first burn to the last and P from one apogee to
the next. Where it goes on from, :mod:`.after_tows` says.

With low thrust a tow is a spiral, against the motion wherever there is sunlight: ΔV is the
difference of both circular speeds, and it takes as long as with the heaviest chaser and the longest
shadow; a lighter one throttles. Meanwhile the speed of the orbit changes uniformly, and node and
argument of latitude move by the means of their rates.

The burns take propellant for both masses: with A = exp(−ΔV / g₀ Isp) a chaser of mass m that tows
D has (m + D) A − D afterwards. A burn back, which it makes alone, takes its own share of that.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from ..common.constants import EARTH_RADIUS_M, MU_M3_S2
from ..kernels.legs.burns import half_ellipse_speeds
from ..kernels.orbits import ephemeris
from ..kernels.orbits.ephemeris import EPOCH_S
from ..problem.bodies import Target
from ..problem.disposal import Disposal, DisposalCircle, DisposalPerigee
from ..problem.drives import Drive
from ..problem.instance import Instance
from .planes import Arcs, Plane, ahead, outward

FloatArray = npt.NDArray[np.float64]

RATES = 8
"""Number of points of Gauss's rule for the means of rates on a spiral."""

APOGEE_M_S = 1.0
"""Cost of eccentricity v e / 2 from which a tow begins at an apogee [m/s]."""

SAME_LAP = 1e-6
"""Share of a revolution before an apogee within which a time counts as the apogee's."""


class Apogees(NamedTuple):
    """Times of an object's apogees: ``first_s``, and multiples of ``period_s`` before and after it.

    Attributes
    ----------
    first_s, period_s : float
        [s].
    """

    first_s: float
    period_s: float


class RemovalFlight(NamedTuple):
    """Flight of a chaser that removes an object after its service: a tow.

    Attributes
    ----------
    radius_m, eccentricity : float
        Semi-major axis and eccentricity of the orbit that the chaser goes on from.
    time_s : float
        How long it takes: from its beginning, up to a revolution before the first burn where that
        has to be at an apogee, to its end.
    flight_s : float
        From the first burn to the last, or of the spiral.
    delta_v_m_s : float
        Of all burns.
    back_m_s : float
        Part of it that the chaser takes alone, after the release.
    burns_m_s : tuple of float or None
        What each burn takes off the velocity; None for a spiral.
    shift_rad, turned_rad : float
        How far the node moves between the burns, and the argument of latitude.
    object_kg : float
        Mass that is towed.
    released_m : (float, float)
        Radii of perigee and apogee of the orbit that the object is left on.
    apogees : Apogees or None
        Where a tow begins; None if that may be anywhere.
    """

    radius_m: float
    eccentricity: float
    time_s: float
    flight_s: float
    delta_v_m_s: float
    back_m_s: float
    burns_m_s: tuple[float, ...] | None
    shift_rad: float
    turned_rad: float
    object_kg: float
    released_m: tuple[float, float]
    apogees: Apogees | None = None

    def takes_kg(
        self, mass_kg: float, exhaust_m_s: float, delta_v_m_s: float | None = None
    ) -> float:
        """Propellant that the tow takes, from the chaser's mass before it [kg]."""
        docked = (self.delta_v_m_s if delta_v_m_s is None else delta_v_m_s) - self.back_m_s
        lost = (mass_kg + self.object_kg) * -math.expm1(-docked / exhaust_m_s)
        return lost + (mass_kg - lost) * -math.expm1(-self.back_m_s / exhaust_m_s)

    def needed_kg(self, mass_kg: float, exhaust_m_s: float) -> float:
        """Mass of a chaser before the tow, from its mass after it [kg]."""
        alone = mass_kg * math.exp(self.back_m_s / exhaust_m_s)
        docked = self.delta_v_m_s - self.back_m_s
        return (alone + self.object_kg) * math.exp(docked / exhaust_m_s) - self.object_kg

    def begins_s(self, leaves_s: float) -> float:
        """First burn of a tow after which a chaser leaves at a time [s]."""
        if self.apogees is None:
            return leaves_s - self.flight_s
        last_s = leaves_s - self.flight_s
        laps = math.floor((last_s - self.apogees.first_s) / self.apogees.period_s + SAME_LAP)
        return self.apogees.first_s + laps * self.apogees.period_s

    def burn_times_s(self, begins_s: float) -> tuple[float, ...]:
        """Times of the burns of a tow, from the time of the first [s]."""
        assert self.burns_m_s is not None
        return tuple(begins_s + (at > 0) * self.flight_s for at in range(len(self.burns_m_s)))


def removals_of(instance: Instance, drive: Drive | None) -> dict[int, RemovalFlight]:
    """Removals flown by chasers with a drive, or with impulses, by number of the removed body."""
    arcs, found = Arcs(instance.oblateness_m2), {}
    for body, target in enumerate(instance.targets, start=instance.first_target):
        if not target.service.is_flown:
            continue
        assert target.orbit is not None
        assert target.mass_kg is not None
        disposal = instance.disposal_of(target)
        high, inclination = target.orbit.circular_elements()[:2]
        if from_apogee(instance, target) and drive is None:
            low = EARTH_RADIUS_M + instance.transfer.min_altitude_m
            found[body] = _from_apogee(target, disposal, low, arcs, instance.oblateness_m2)
            continue
        low = EARTH_RADIUS_M + instance.circle_m(target)
        if drive is not None:
            found[body] = _spiral(
                drive, (high, low), inclination, instance.oblateness_m2, target.mass_kg
            )
            continue
        first, second = half_ellipse_speeds(high, low)
        time, shift = arcs.half(high, low, inclination)
        burns = math.sqrt(MU_M3_S2 / high) - first, second - math.sqrt(MU_M3_S2 / low)
        found[body] = RemovalFlight(
            radius_m=low,
            eccentricity=0.0,
            time_s=time,
            flight_s=time,
            delta_v_m_s=math.fsum(abs(burn) for burn in burns),
            back_m_s=0.0,
            burns_m_s=burns,
            shift_rad=shift,
            turned_rad=math.pi,
            object_kg=target.mass_kg,
            released_m=(low, low),
        )
    return found


def from_apogee(instance: Instance, target: Target) -> bool:
    """Whether the tow of a target by impulses begins at an apogee."""
    orbit = target.orbit
    if not target.service.is_flown or orbit is None:
        return False
    if isinstance(instance.disposal_of(target), DisposalPerigee):
        return True
    speed = math.sqrt(MU_M3_S2 / orbit.semi_major_axis_m)
    return 0.5 * speed * orbit.eccentricity >= APOGEE_M_S


def any_from_apogee(instance: Instance) -> bool:
    """Whether any tow by impulses begins at an apogee."""
    return any(from_apogee(instance, target) for target in instance.targets)


def _from_apogee(
    target: Target, disposal: Disposal | None, low_m: float, arcs: Arcs, oblateness_m2: float
) -> RemovalFlight:
    """A coaxial tow from the ellipse of an object (docs/model.md section 5.4).

    Parameters
    ----------
    low_m : float
        Least radius of the chaser.
    """
    orbit = target.orbit
    assert orbit is not None
    assert target.mass_kg is not None
    axis, inclination = orbit.semi_major_axis_m, math.radians(orbit.inclination_deg)
    perigee, apogee = axis * (1.0 - orbit.eccentricity), axis * (1.0 + orbit.eccentricity)
    before = half_ellipse_speeds(apogee, perigee)[0]
    node_free = ephemeris.secular_rates(axis, orbit.eccentricity, inclination, oblateness_m2)
    row = orbit.row(oblateness_m2)
    mean = ephemeris.latitude_at(row, EPOCH_S) - math.radians(orbit.argument_of_perigee_deg)
    apogees = Apogees((math.pi - mean) / node_free[2], math.tau / node_free[2])
    if isinstance(disposal, DisposalPerigee):
        released = min(EARTH_RADIUS_M + disposal.perigee_m, perigee)
        let_go = half_ellipse_speeds(apogee, released)[0]
        kept = max(released, low_m)
        back = half_ellipse_speeds(apogee, kept)[0] - let_go
        burns = (before - let_go, -back) if back > 0.0 else (before - let_go,)
        half, time, shift, turned = 0.0, 0.0, 0.0, 0.0
        ends, onward = (released, apogee), (kept, apogee)
    else:
        assert isinstance(disposal, DisposalCircle)
        circle, back = EARTH_RADIUS_M + disposal.circle_m, 0.0
        half, end = half_ellipse_speeds(apogee, circle)
        burns = before - half, end - math.sqrt(MU_M3_S2 / circle)
        (time, shift), turned = arcs.half(apogee, circle, inclination), math.pi
        ends = onward = (circle, circle)
    return RemovalFlight(
        radius_m=0.5 * math.fsum(onward),
        eccentricity=(onward[1] - onward[0]) / math.fsum(onward),
        time_s=apogees.period_s + time,
        flight_s=time,
        delta_v_m_s=math.fsum(abs(burn) for burn in burns),
        back_m_s=back,
        burns_m_s=burns,
        shift_rad=shift,
        turned_rad=turned,
        object_kg=target.mass_kg,
        released_m=ends,
        apogees=apogees,
    )


def _spiral(
    drive: Drive,
    radii_m: tuple[float, float],
    inclination: float,
    oblateness_m2: float,
    object_kg: float,
) -> RemovalFlight:
    """The spiral of a chaser with an object between two circles."""
    high, low = radii_m
    start, end = math.sqrt(MU_M3_S2 / high), math.sqrt(MU_M3_S2 / low)
    delta_v, exhaust = end - start, drive.exhaust_m_s
    lit = 1.0 - math.asin(EARTH_RADIUS_M / low) / math.pi
    both = drive.heaviest_kg + object_kg
    time = both * exhaust / drive.thrust_n * -math.expm1(-delta_v / exhaust) / lit
    shift = turned = 0.0
    for at, weight in zip(*np.polynomial.legendre.leggauss(RATES), strict=True):
        radius = MU_M3_S2 / (start + 0.5 * (1.0 + float(at)) * delta_v) ** 2
        share = 0.5 * float(weight) * time
        shift += share * float(ephemeris.node_rate(radius, inclination, oblateness_m2))
        turned += share * float(ephemeris.latitude_rate(radius, inclination, oblateness_m2))
    return RemovalFlight(
        radius_m=low,
        eccentricity=0.0,
        time_s=time,
        flight_s=time,
        delta_v_m_s=delta_v,
        back_m_s=0.0,
        burns_m_s=None,
        shift_rad=shift,
        turned_rad=turned,
        object_kg=object_kg,
        released_m=(low, low),
    )


def removals_by_name(instance: Instance, drive: Drive | None) -> dict[str, RemovalFlight]:
    """Removals flown by chasers with a drive, or with impulses, by name of the target."""
    names = instance.names
    return {names[body]: tow for body, tow in removals_of(instance, drive).items()}


def burn_vectors(orbit: FloatArray, tow: RemovalFlight, begins_s: float) -> list[FloatArray]:
    """Burns of a tow whose first one is at a time, inertial, shape (3,) each [m/s].

    Parameters
    ----------
    orbit : (columns,) float64
        Row of the object, :data:`adr_opt.kernels.orbits.ephemeris.ORBIT_COLUMNS`.
    tow : RemovalFlight
        With burns.
    """
    assert tow.burns_m_s is not None
    latitude = float(ephemeris.latitude_at(orbit, begins_s))
    if tow.apogees is not None:
        latitude = float(ephemeris.perigee_at(orbit, begins_s)) + math.pi
    plane = Plane(
        float(ephemeris.inclination_at(orbit, begins_s)), float(ephemeris.node_at(orbit, begins_s))
    )
    after = plane.carried(tow.shift_rad)
    places = ((plane, latitude), (after, latitude + tow.turned_rad))
    return [
        -size * ahead(there, outward(there, at))
        for size, (there, at) in zip(tow.burns_m_s, places, strict=False)
    ]
