"""Burns of a transfer as inertial vectors."""

import math

import numpy as np

from ...common.constants import MU_M3_S2, TURN_RAD
from ..core.compile import kernel
from ..orbits import eccentricity, ephemeris
from . import co_elliptic, precession

HOHMANN_1, PHASING, CO_ELLIPTIC, TERMINAL, APPROACH, DRIFT = range(6)
PHASES = ("hohmann-1", "phasing", "co-elliptic", "terminal", "approach", "drift")


@kernel
def half_ellipse_speeds(r1, r2):
    """Speeds at the two ends of a half ellipse, by vis-viva [m/s]."""
    start = math.sqrt(2.0 * MU_M3_S2 * r2 / (r1 * (r1 + r2)))
    return start, start * r1 / r2


@kernel
def combine(vector, a, u, b, v):
    """Write a u + b v; a loop, because array expressions take long to compile."""
    for axis in range(3):
        vector[axis] = a * u[axis] + b * v[axis]


@kernel
def burns(orbit_i, orbit_j, pair, rule, departure, revolutions, r):
    """The burns of one sequence in time order.

    Parameters
    ----------
    orbit_i, orbit_j : (4,) float64
        Rows of :data:`adr_opt.kernels.orbits.ephemeris.ORBIT_COLUMNS`.
    pair : adr_opt.kernels.legs.co_elliptic.Pair
    rule : adr_opt.kernels.legs.co_elliptic.TransferRule
    departure : float
        When the chaser is at the line of nodes [s].
    revolutions : int
        k.
    r : float
        Phasing radius [m].

    Returns
    -------
    times : (burns,) float64
        [s]; four burns for k = 0, five else, and those of the approach.
    vectors : (burns, 3) float64
        [m/s], inertial.
    phases : (burns,) int64
        Index into :data:`PHASES`: the phase that the burn begins; the second terminal burn ends
        it, at the stand-off, and the last approach burn ends the approach, at the target.
    """
    count = (5 if revolutions > 0 else 4) + rule.approach.shape[0]
    times = np.empty(count)
    vectors = np.empty((count, 3))
    phases = np.empty(count, dtype=np.int64)

    ri, rj = pair.radius_i, pair.radius_j
    rc = r + rule.first_leg_fraction * (rj - r)
    v1, v1_end = half_ellipse_speeds(ri, r)
    v2, v2_end = half_ellipse_speeds(r, rc)
    v3, v3_end = half_ellipse_speeds(rc, rj)
    circle = math.sqrt(MU_M3_S2 / r) if revolutions > 0 else v2
    clock = math.pi / co_elliptic.SQRT_MU
    a1, a2, a3 = 0.5 * (ri + r), 0.5 * (r + rc), 0.5 * (rc + rj)
    # Nodes shift on every arc; without J2 all of this is 0.
    turned_1 = pair.shift_i / (a1 * a1 + pair.widening_i)
    turned_k = 2.0 * revolutions * pair.shift_j / (r * r + pair.widening_j)
    turned_2 = pair.shift_j / (a2 * a2 + pair.widening_j)
    turned_3 = pair.shift_j / (a3 * a3 + pair.widening_j)

    position, velocity = ephemeris.state_at(orbit_i, departure)
    outward, ahead = position, velocity
    for axis in range(3):
        outward[axis] /= ri
        ahead[axis] /= pair.speed_i
    now = departure
    times[0], phases[0] = now, HOHMANN_1
    combine(vectors[0], v1 - pair.speed_i, ahead, 0.0, ahead)
    # Half a revolution turns both directions round.
    ephemeris.turn(outward, turned_1)
    ephemeris.turn(ahead, turned_1)
    now += clock * a1 * math.sqrt(a1) * co_elliptic.pace(a1, pair.widening_i)
    times[1], phases[1] = now, CO_ELLIPTIC
    met = now + revolutions * co_elliptic.lap_time(r, pair.widening_j)[0]
    met += clock * a2 * math.sqrt(a2) * co_elliptic.pace(a2, pair.widening_j)
    met += clock * a3 * math.sqrt(a3) * co_elliptic.pace(a3, pair.widening_j)
    # Into the plane that the remaining arcs carry onto the target's.
    raan = ephemeris.node_at(orbit_j, met) - turned_k - turned_2 - turned_3
    _, _, normal = ephemeris.frame(ephemeris.inclination_at(orbit_j, met), raan)
    after = np.empty(3)
    for axis in range(3):
        second, third = (axis + 1) % 3, (axis + 2) % 3
        after[axis] = normal[second] * outward[third] - normal[third] * outward[second]
    length = math.sqrt(after[0] ** 2 + after[1] ** 2 + after[2] ** 2)
    for axis in range(3):
        after[axis] /= length
    combine(vectors[1], v1_end, ahead, -circle, after)
    b = 2
    if revolutions > 0:
        phases[1] = PHASING
        now += revolutions * co_elliptic.lap_time(r, pair.widening_j)[0]
        ephemeris.turn(outward, turned_k)
        ephemeris.turn(after, turned_k)
        times[2], phases[2] = now, CO_ELLIPTIC
        combine(vectors[2], circle - v2, after, 0.0, after)
        b = 3
    now += clock * a2 * math.sqrt(a2) * co_elliptic.pace(a2, pair.widening_j)
    ephemeris.turn(outward, turned_2)
    ephemeris.turn(after, turned_2)
    times[b], phases[b] = now, TERMINAL
    combine(vectors[b], v3 - v2_end, after, 0.0, after)
    now += clock * a3 * math.sqrt(a3) * co_elliptic.pace(a3, pair.widening_j)
    ephemeris.turn(outward, turned_3)
    ephemeris.turn(after, turned_3)
    times[b + 1], phases[b + 1] = now, TERMINAL
    combine(vectors[b + 1], v3_end - pair.speed_j, after, 0.0, after)
    last_times, last = approach_burns(orbit_j, rule, now, TURN_RAD / pair.rate_j)
    for burn in range(last_times.size):
        times[b + 2 + burn], phases[b + 2 + burn] = last_times[burn], APPROACH
        combine(vectors[b + 2 + burn], 1.0, last[burn], 0.0, after)
    return times, vectors, phases


@kernel
def approach_burns(orbit_j, rule, stand_off, period):
    """The burns of the approach, each in the frame of where the chaser is then.

    Parameters
    ----------
    orbit_j : (columns,) float64
        Row of the target.
    rule : adr_opt.kernels.legs.co_elliptic.TransferRule
    stand_off : float
        When it begins [s].
    period : float
        Of the target [s].

    Returns
    -------
    times : (burns,) float64
        [s].
    vectors : (burns, 3) float64
        [m/s], inertial.
    """
    count = rule.approach.shape[0]
    times, vectors = np.empty(count), np.empty((count, 3))
    for burn in range(count):
        revolution, radial, along, across, behind = rule.approach[burn]
        times[burn] = stand_off + revolution * period
        radius = ephemeris.radius_at(orbit_j, times[burn])
        n = ephemeris.mean_motion(radius)
        outward, ahead = ephemeris.state_at(orbit_j, times[burn] - behind / (n * radius))
        for axis in range(3):
            second, third = (axis + 1) % 3, (axis + 2) % 3
            normal = outward[second] * ahead[third] - outward[third] * ahead[second]
            normal /= radius * radius * n
            vectors[burn, axis] = n * (
                radial * outward[axis] / radius
                + along * ahead[axis] / (n * radius)
                + across * normal
            )
    return times, vectors


@kernel
def eccentric_share(orbit_i, orbit_j, extra_delta_v, rule, departure, arrival, revolutions):
    """Part of a connection's ΔV that its burns do not cover: the cost of eccentricity [m/s].

    Parameters
    ----------
    orbit_i, orbit_j, extra_delta_v, rule
        As :func:`.co_elliptic.prepare` takes them.
    departure, arrival : float
        When it really leaves, and when it arrives [s].
    revolutions : int
    """
    pair = co_elliptic.prepare(orbit_i, orbit_j, extra_delta_v, rule, ephemeris.EPOCH_S)
    flight = arrival - rule.approach_revolutions * TURN_RAD / pair.rate_j - departure
    r = co_elliptic.phasing_radius(pair, rule, revolutions, flight)
    turn = pair.turn
    if ephemeris.planes_drift(rule.oblateness):
        lag = pair.lag + pair.lag_rate * departure
        lag += precession.carried(pair, rule, revolutions, r, flight)
        _, _, theta = precession.line(pair, lag)
        turn = 4.0 * math.sin(0.5 * theta) ** 2
    matching = eccentricity.matching(pair, departure)
    return co_elliptic.eccentric_share(pair, rule, revolutions, r, turn, matching)


@kernel
def burns_between(orbit_i, orbit_j, extra_delta_v, rule, departure, arrival, revolutions):
    """The burns of a connection.

    Parameters
    ----------
    orbit_i, orbit_j, extra_delta_v, rule
        As :func:`.co_elliptic.prepare` takes them.
    departure, arrival : float
        [s].
    revolutions : int

    Returns
    -------
    times, vectors, phases
        As of :func:`burns`.
    """
    pair = co_elliptic.prepare(orbit_i, orbit_j, extra_delta_v, rule, ephemeris.EPOCH_S)
    stand_off = arrival - rule.approach_revolutions * TURN_RAD / pair.rate_j
    if ephemeris.planes_drift(rule.oblateness):
        departure = precession.leaving(pair, rule, revolutions, departure, stand_off)
    flight = stand_off - departure
    r = co_elliptic.phasing_radius(pair, rule, revolutions, flight)
    times, vectors, phases = burns(orbit_i, orbit_j, pair, rule, departure, revolutions, r)
    times[times.size - 1] = arrival  # to the last digit
    return times, vectors, phases
