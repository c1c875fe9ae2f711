"""Tows: an object is lowered to a disposal orbit, where the chaser continues from.

With impulses:

A tow is a Hohmann transfer of the chaser with the object from the circle that the object is planned
on (docs/model.md section 1) to one at the disposal altitude, in the object's plane: two burns
against the motion, half a revolution apart. The object is released after the second one. The chaser
may wait before a tow, but not after it: a tow ends when the next transfer leaves. Where there is
none, plans have it follow the service at once, and it may be later. So a chaser leaving a tow at
a time t is on the disposal orbit then,

    u(t) = u_j(t − T) + π,    Ω(t) = Ω_j(t − T) + Ω̇_h T,

with T and Ω̇_h of the half ellipse (docs/model.md section 2): a body whose angles advance as the
object's do, by the time of departure, on another radius. A row of such a body is that of the object
*as it is left*. What has left drifts as its own radius says, which is one column more.

With low thrust a tow is a spiral, against the motion wherever there is sunlight: ΔV is the
difference of both circular speeds, and it takes as long as with the heaviest chaser and the longest
shadow; a lighter one throttles. Meanwhile the speed of the orbit changes uniformly, and node and
argument of latitude move by the means of their rates.

The burns take propellant for both masses: with A = exp(−ΔV / g₀ Isp) a chaser of mass m that tows
D has (m + D) A − D afterwards.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from ..common.constants import EARTH_RADIUS_M, MU_M3_S2
from ..kernels.legs.burns import half_ellipse_speeds
from ..kernels.orbits import ephemeris
from ..kernels.orbits.body_rows import as_left, with_orbit
from ..kernels.orbits.eccentricity import matchings
from ..kernels.orbits.ephemeris import EPOCH_S
from ..problem.drives import Drive
from ..problem.instance import Instance
from ..problem.orbit import Orbit
from .planes import Arcs, Plane, ahead, outward

FloatArray = npt.NDArray[np.float64]

RATES = 8
"""Number of points of Gauss's rule for the means of rates on a spiral."""


class RemovalFlight(NamedTuple):
    """Flight of a chaser that removes an object after its service: a tow.

    Attributes
    ----------
    radius_m : float
        Of the disposal orbit.
    time_s : float
        From the first burn to the second, or of the spiral.
    delta_v_m_s : float
    burns_m_s : (float, float) or None
        What the two burns take off the velocity; None for a spiral.
    shift_rad, turned_rad : float
        How far the node moves meanwhile, and the argument of latitude.
    object_kg : float
        Mass that is towed.
    """

    radius_m: float
    time_s: float
    delta_v_m_s: float
    burns_m_s: tuple[float, float] | None
    shift_rad: float
    turned_rad: float
    object_kg: float


def removals_of(instance: Instance, drive: Drive | None) -> dict[int, RemovalFlight]:
    """Removals flown by chasers with a drive, or with impulses, by number of the removed body."""
    arcs, found = Arcs(instance.oblateness_m2), {}
    for body, target in enumerate(instance.targets, start=instance.first_target):
        if not target.service.is_flown:
            continue
        assert target.orbit is not None
        assert target.mass_kg is not None
        low = EARTH_RADIUS_M + instance.circle_m(target)
        high, inclination = target.orbit.circular_elements()[:2]
        if drive is not None:
            found[body] = _spiral(
                drive, (high, low), inclination, instance.oblateness_m2, target.mass_kg
            )
            continue
        first, second = half_ellipse_speeds(high, low)
        time, shift = arcs.half(high, low, inclination)
        burns = math.sqrt(MU_M3_S2 / high) - first, second - math.sqrt(MU_M3_S2 / low)
        found[body] = RemovalFlight(
            low, time, math.fsum(burns), burns, shift, math.pi, target.mass_kg
        )
    return found


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
    return RemovalFlight(low, time, delta_v, None, shift, turned, object_kg)


def removals_by_name(instance: Instance, drive: Drive | None) -> dict[str, RemovalFlight]:
    """Removals flown by chasers with a drive, or with impulses, by name of the target."""
    names = instance.names
    return {names[body]: tow for body, tow in removals_of(instance, drive).items()}


def leaving_orbits(instance: Instance, drive: Drive | None) -> FloatArray:
    """Bodies at departure, shape (bodies, columns): as in :meth:`Instance.orbits`.

    Those that are towed are left from the disposal orbit. Where there are some, rows have one
    column more, see :func:`adr_opt.kernels.orbits.body_rows.as_left`.
    """
    rows, tows = instance.orbits(), removals_of(instance, drive)
    if not tows:
        return rows
    rows = as_left(rows)
    for body, tow in tows.items():
        row = rows[body]
        node, node_rate = ephemeris.node_tangent(row, EPOCH_S)
        latitude, latitude_rate = ephemeris.latitude_tangent(row, EPOCH_S)
        inclination = ephemeris.inclination_at(row, EPOCH_S)
        rows[body] = with_orbit(
            row,
            radius_m=tow.radius_m,
            node=node + (tow.shift_rad - node_rate * tow.time_s),
            latitude=latitude + (tow.turned_rad - latitude_rate * tow.time_s),
            eccentricity=0.0,
            coasting_node_rate=ephemeris.node_rate(
                tow.radius_m, inclination, instance.oblateness_m2
            ),
        )
    return rows


def released_orbit(instance: Instance, drive: Drive | None, name: str, time_s: float) -> Orbit:
    """Disposal orbit of a chaser that released an object at a time, and stays there."""
    row = leaving_orbits(instance, drive)[instance.names.index(name)]
    radius = float(ephemeris.radius_at(row, time_s))
    inclination = float(ephemeris.inclination_at(row, time_s))
    latitude_rate = float(ephemeris.latitude_rate(radius, inclination, instance.oblateness_m2))
    coasting = float(ephemeris.coasting_node_rate_at(row, time_s))
    node = float(ephemeris.node_at(row, time_s)) - coasting * time_s
    latitude = float(ephemeris.latitude_at(row, time_s)) - latitude_rate * time_s
    return Orbit(
        semi_major_axis_m=radius,
        eccentricity=0.0,
        inclination_deg=math.degrees(inclination),
        raan_deg=math.degrees(node) % 360.0,
        argument_of_perigee_deg=0.0,
        true_anomaly_deg=math.degrees(latitude) % 360.0,
    )


def leaving_eccentricity_delta_v(instance: Instance, leaving: FloatArray) -> FloatArray:
    """Cost of matching eccentricity vectors alone after such a departure [m/s].

    As :meth:`Instance.eccentricity_delta_v`, shape (origin, destination); a disposal orbit is a
    circle.
    """
    costs, rows = instance.eccentricity_delta_v(), instance.orbits()
    if instance.nodes_drift:
        return costs
    for body in removals_of(instance, None):
        columns = rows.shape[1]
        for other in range(len(rows)):
            ends = np.array([leaving[body, :columns], rows[other]])
            costs[body, other] = 0.0 if other == body else matchings(ends, EPOCH_S)[0, 1]
    return costs


def burn_vectors(
    orbit: FloatArray, tow: RemovalFlight, start_s: float
) -> tuple[FloatArray, FloatArray]:
    """Both burns of a tow that begins at a time, inertial, shape (3,) each [m/s].

    Parameters
    ----------
    orbit : (columns,) float64
        Row of the object, :data:`adr_opt.kernels.orbits.ephemeris.ORBIT_COLUMNS`.
    tow : RemovalFlight
        With burns.
    """
    assert tow.burns_m_s is not None
    latitude = float(ephemeris.latitude_at(orbit, start_s))
    plane = Plane(
        float(ephemeris.inclination_at(orbit, start_s)), float(ephemeris.node_at(orbit, start_s))
    )
    after = plane.carried(tow.shift_rad)
    return (
        -tow.burns_m_s[0] * ahead(plane, outward(plane, latitude)),
        -tow.burns_m_s[1] * ahead(after, outward(after, latitude + math.pi)),
    )
