"""One leg computed with the reference library boinor, as its users would.

The yardstick for the speed of the timetable kernel, and a second opinion on what it computes:
orbits are boinor ``Orbit`` objects, burns come from ``Maneuver.hohmann``, the phasing radius from
SciPy's ``brentq``. Nothing is pruned: every (k, m) of docs/model.md section 2 is solved and priced.
Plain floats are used where a user in earnest would use them, inside the root finder.
"""

from __future__ import annotations

import math

import numpy as np
from astropy import units as u
from boinor.bodies import Earth
from boinor.maneuver import Maneuver
from boinor.twobody import Orbit
from scipy.optimize import brentq

from adr_opt.common.constants import EARTH_RADIUS_M
from adr_opt.common.errors import InputError
from adr_opt.problem.instance import Instance
from adr_opt.problem.orbit import Orbit as Elements
from adr_opt.problem.settings import SequenceSettings

MU = Earth.k.to_value(u.m**3 / u.s**2)
COPLANAR_RAD = 1e-9


def reference_leg(
    instance: Instance, origin: str, destination: str, ready_s: float
) -> tuple[float, float]:
    """ΔV and arrival of the first transfer at or after a ready time.

    Parameters
    ----------
    instance : Instance
        Circular orbits, no keep-out zones.
    origin, destination : str
        Names of two bodies.
    ready_s : float
        When the chaser is free [s].

    Returns
    -------
    delta_v, arrival : float
        [m/s], [s]; both +inf where there is no transfer.

    Raises
    ------
    InputError
        The instance has eccentric orbits or keep-out zones.
    """
    if instance.is_approximate or instance.keep_out_zones:
        raise InputError("the reference leg knows neither eccentric orbits nor keep-out zones")
    rule = instance.transfer
    elements = dict(zip(instance.names, instance.body_orbits, strict=True))
    chaser = _orbit(elements[origin]).propagate(ready_s * u.s)
    target = _orbit(elements[destination]).propagate(ready_s * u.s)

    # 1. Wait for the line of nodes.
    node, theta = _node(chaser, target)
    ahead = _angle_from(chaser, node) % math.pi
    wait = 0.0 if ahead == 0.0 else (math.pi - ahead) / chaser.n.to_value(u.rad / u.s)
    chaser, target = chaser.propagate(wait * u.s), target.propagate(wait * u.s)
    departure = ready_s + wait

    # 2. Every sequence that meets the target at the stand-off.
    ri, rj = chaser.a.to_value(u.m), target.a.to_value(u.m)
    lead = (_angle_from(target, node) - _angle_from(chaser, node)) % (2.0 * math.pi)
    rate = target.n.to_value(u.rad / u.s)
    low, high = EARTH_RADIUS_M + rule.min_altitude_m, EARTH_RADIUS_M + rule.max_altitude_m
    f = rule.first_leg_fraction

    def flight_time(r: float, k: int) -> float:
        rc = r + f * (rj - r)
        axes = (0.5 * (ri + r), 0.5 * (r + rc), 0.5 * (rc + rj))
        arcs = sum(math.pi * math.sqrt(a**3 / MU) for a in axes)
        return arcs + 2.0 * math.pi * k * math.sqrt(r**3 / MU)

    best = (math.inf, math.inf, 0)
    best_delta_v = math.inf
    for k in range(rule.max_phasing_revolutions + 1):
        phase = (2 * k + 3) * math.pi - lead + rule.standoff_m / rj
        shortest, longest = flight_time(low, k), flight_time(high, k)
        m = math.ceil((rate * shortest - phase) / (2.0 * math.pi))
        while (time := (phase + 2.0 * math.pi * m) / rate) <= longest:
            r = brentq(lambda r, k=k, time=time: flight_time(r, k) - time, low, high, xtol=1e-9)
            delta_v = _delta_v(chaser, target, theta, k, r, f)
            key = (delta_v + instance.time_value_m_s_per_h / 3600.0 * time, time, k)
            if key < best:
                best, best_delta_v = key, delta_v
            m += 1
    if not math.isfinite(best_delta_v):
        return math.inf, math.inf
    # 3. The approach.
    length, laps = _approach(rule)
    return (best_delta_v + rate * length, departure + best[1] + laps * target.period.to_value(u.s))


def _approach(rule: SequenceSettings) -> tuple[float, float]:
    """ΔV over the mean motion [m] and revolutions: half a lap, or a safety ellipse by its parts."""
    if rule.approach == "half-lap":
        return 2.0 * (rule.standoff_m / 4.0), 0.5
    m, q = rule.approach_revolutions, rule.inspection_revolutions
    per_revolution = 3.0 * 1.08262668e-3 * (6378137.0 / (6378137.0 + rule.min_altitude_m)) ** 2
    stretch = 3.0 * math.pi * (m + 0.25)

    def shrunk(turns: float) -> float:
        return math.sqrt(1.0 - math.sin(2.0 * math.pi * turns * per_revolution))

    rho = max(
        (rule.keep_out_m + rule.standoff_m / stretch) / (shrunk(2 * m + 1.75) - 2.0 / stretch),
        rule.keep_out_m / shrunk(m + 1.75 + q + 8.0),
    )
    quarter = (rule.standoff_m + 2.0 * rho) / stretch / 4.0
    stops = quarter + rho if q else math.hypot(quarter, rho)
    return 2.0 * rho + 3.0 * quarter + stops + rho * (math.sqrt(1.25) + 0.5), m + 2.5 + q


def _orbit(elements: Elements) -> Orbit:
    latitude = math.radians(elements.argument_of_perigee_deg + elements.true_anomaly_deg)
    return Orbit.from_classical(
        Earth,
        elements.semi_major_axis_m * u.m,
        0.0 * u.one,
        elements.inclination_deg * u.deg,
        elements.raan_deg * u.deg,
        0.0 * u.deg,
        (((latitude + math.pi) % (2.0 * math.pi)) - math.pi) * u.rad,
    )


def _node(chaser: Orbit, target: Orbit) -> tuple[np.ndarray, float]:
    """Line of nodes h_i × h_j, the ascending node of the chaser if the planes are one; angle."""
    hi, hj = (orbit.h_vec.to_value(u.m**2 / u.s) for orbit in (chaser, target))
    node = np.cross(hi, hj)
    theta = math.atan2(np.linalg.norm(node), hi @ hj)
    if theta < COPLANAR_RAD:
        raan = chaser.raan.to_value(u.rad)
        return np.array([math.cos(raan), math.sin(raan), 0.0]), theta
    return node / np.linalg.norm(node), theta


def _angle_from(orbit: Orbit, node: np.ndarray) -> float:
    """Angle of a body past a direction, in its plane and in its sense of motion [rad]."""
    normal = orbit.h_vec.to_value(u.m**2 / u.s)
    normal = normal / np.linalg.norm(normal)
    position = orbit.r.to_value(u.m)
    return math.atan2(position @ np.cross(normal, node), position @ node) % (2.0 * math.pi)


def _delta_v(chaser: Orbit, target: Orbit, theta: float, k: int, r: float, f: float) -> float:
    """ΔV of a sequence from departure to stand-off, by three Hohmann transfers [m/s]."""
    rj = target.a.to_value(u.m)
    rc = r + f * (rj - r)
    phasing, co_elliptic = (
        Orbit.from_classical(
            Earth, radius * u.m, 0.0 * u.one, target.inc, target.raan, 0.0 * u.deg, 0.0 * u.deg
        )
        for radius in (r, rc)
    )
    first = _tangential(chaser, r)
    second = _tangential(phasing, rc)
    third = _tangential(co_elliptic, rj)
    circle = math.sqrt(MU / r)
    # Impulses are signed along the motion: the arrival speed of an arc is the circular speed
    # less the impulse that would circularise it.
    arriving = circle - first[1]
    leaving = circle if k > 0 else circle + second[0]
    turn = math.sqrt(arriving**2 + leaving**2 - 2.0 * arriving * leaving * math.cos(theta))
    total = abs(first[0]) + turn + abs(second[1] + third[0]) + abs(third[1])
    return total + (abs(second[0]) if k > 0 else 0.0)


def _tangential(orbit: Orbit, radius: float) -> tuple[float, float]:
    """Price the two impulses of a Hohmann transfer, positive along the motion [m/s]."""
    (_, start), (_, end) = Maneuver.hohmann(orbit, radius * u.m).impulses
    sign = 1.0 if radius >= orbit.a.to_value(u.m) else -1.0
    return (
        sign * float(np.linalg.norm(start.to_value(u.m / u.s))),
        sign * float(np.linalg.norm(end.to_value(u.m / u.s))),
    )
