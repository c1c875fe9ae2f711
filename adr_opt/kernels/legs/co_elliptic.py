"""One transfer: the co-elliptic sequence (docs/model.md section 2).

Vocabulary. The chaser leaves body *i* at the line of nodes, flies half an ellipse to the
*phasing radius* r_x, turns there into plane *j*, waits k revolutions on the circle, flies half
an ellipse to the co-elliptic radius r_c and half an ellipse to a point L behind body *j*; the
*approach* closes the rest.

All orbits are circles here; what eccentric ones add is in
:mod:`adr_opt.kernels.orbits.eccentricity`.
"""

import math
from typing import NamedTuple

import numpy as np

from ...common.constants import MU_M3_S2, SLACK_S, TURN_RAD
from ..core.compile import inlined, kernel
from ..orbits import eccentricity, ephemeris
from . import free_burns

SQRT_MU = math.sqrt(MU_M3_S2)


class TransferRule(NamedTuple):
    """Parameters of every transfer of an instance, with its keep-out zones.

    Attributes
    ----------
    first_leg_fraction : float
        f: the share of r_j − r_x that is closed on the way to the co-elliptic radius.
    standoff : float
        L: distance behind the target at which the approach begins [m].
    approach_revolutions : float
        Duration of the approach [periods of the target].
    max_phasing_revolutions : int
        Largest k.
    min_radius, max_radius : float
        Limits of the phasing radius [m].
    time_value : float
        w: what a second is worth [m/s per s].
    zones : (zones, 4) float64
        Closed keep-out bands: min radius [m], max radius [m], start [s], end [s].
    oblateness : float
        J2 R², 0 for two bodies [m²].
    approach_length : float
        ΔV of the approach over the mean motion of the target [m].
    approach : (burns, 5) float64
        Its burns, :class:`adr_opt.problem.approach.Approach`.
    free : bool
        Whether a leg has the price of free burns (:mod:`.free_burns`), not that of its sequence.
    """

    first_leg_fraction: float
    standoff: float
    approach_revolutions: float
    max_phasing_revolutions: int
    min_radius: float
    max_radius: float
    time_value: float
    zones: np.ndarray
    oblateness: float
    approach_length: float
    approach: np.ndarray
    free: bool = False


class Pair(NamedTuple):
    """Data of a transfer i → j that do not depend on the departure."""

    radius_i: float
    radius_j: float
    alpha_i: float
    alpha_j: float
    theta: float
    phase_i: float  # u_i − α_i at t = 0 [rad]
    phase_j: float
    rate_i: float  # of the arguments of latitude [rad/s]
    rate_j: float
    speed_i: float  # circular speeds [m/s]
    speed_j: float
    turn: float  # 4 sin²(θ/2): the square of the chord of the turn
    fixed_delta_v: float  # approach [m/s]
    floor_delta_v: float  # no sequence of this pair costs less [m/s]
    reference: float  # radius of the expansions below [m]
    flight: float  # T, T′ and T″ without phasing, at the reference
    flight_1: float
    flight_2: float
    lap: float  # one phasing revolution and its derivatives, at the reference
    lap_1: float
    lap_2: float
    shortest: float  # T without phasing at the least radius less a slack, and one revolution there
    shortest_lap: float
    longest: float  # the same at the greatest radius, and a slack more
    longest_lap: float
    inclination_i: float  # [rad]
    inclination_j: float
    lag: float  # Ω_j − Ω_i at t = 0 [rad]
    lag_rate: float  # [rad/s]
    node_rate_j: float
    latitude_i: float  # u at t = 0 [rad]
    latitude_j: float
    widening_i: float  # 3/2 J2 R² (4 cos² i − 1): what a² has to it in the latitude's rate [m²]
    widening_j: float
    shift_i: float  # −3/2 π J2 R² cos i: a node's shift in half a revolution, but for a² [rad m²]
    shift_j: float
    matching: float  # v |Δe| / 2, or 0 where perigees drift [m/s]
    eccentricity_i: float  # where perigees drift or burns are free, else 0
    eccentricity_j: float
    perigee_i: float  # ω_i at t = 0 [rad]
    perigee_rate_i: float  # [rad/s]
    perigee_lag: float  # ω_j − ω_i at t = 0 [rad]
    perigee_lag_rate: float  # [rad/s]
    free_speed: float  # v of free burns, 0 where a leg has the price of its sequence [m/s]
    turning: float  # no sequence of this pair costs less, but for its phasing [m/s]
    swing: float  # what a second more or less than ``flight`` costs at least, for k = 0 [m/s per s]
    acceleration_i: float  # of the arguments of latitude of decaying orbits, else 0 [rad/s²]
    acceleration_j: float


@inlined
def pace(axis, widening):
    """Time between equal latitudes as a ratio of the two-body time; 1 without J2."""
    return 1.0 if widening == 0.0 else 1.0 / (1.0 + widening / (axis * axis))


@inlined
def flight_time(radius_i, radius_j, widening_i, widening_j, fraction, r):
    """T(r_x) without phasing revolutions, and its first two derivatives (docs/model.md section 2).

    Parameters
    ----------
    radius_i, radius_j : float
        Radii of origin and destination [m].
    widening_i, widening_j : float
        As in :class:`Pair` [m²].
    fraction : float
        f of the co-elliptic radius r_c = r + f (r_j − r).
    r : float
        Phasing radius [m].

    Returns
    -------
    time, first, second : float
        [s], [s/m], [s/m²]; of the derivatives what J2 adds is kept to its first order, and to none.
    """
    half = 0.5 * (1.0 - fraction)
    a1 = 0.5 * (radius_i + r)
    a2 = r + 0.5 * fraction * (radius_j - r)
    a3 = half * r + 0.5 * (1.0 + fraction) * radius_j
    b2 = 1.0 - 0.5 * fraction
    s1, s2, s3 = math.sqrt(a1), math.sqrt(a2), math.sqrt(a3)
    scale = math.pi / SQRT_MU
    first = 1.5 * scale * (0.5 * s1 + b2 * s2 + half * s3)
    second = 0.75 * scale * (0.25 / s1 + b2 * b2 / s2 + half * half / s3)
    if widening_j == 0.0 and widening_i == 0.0:
        time = scale * (a1 * s1 + a2 * s2 + a3 * s3)
    else:
        time = a1 * s1 * pace(a1, widening_i) + a2 * s2 * pace(a2, widening_j)
        time = scale * (time + a3 * s3 * pace(a3, widening_j))
        first *= 1.0 + widening_j / (3.0 * r * r)
    return time, first, second


@inlined
def lap_time(r, widening):
    """Period of the phasing circle and its first two derivatives."""
    root = math.sqrt(r)
    scale = TURN_RAD / SQRT_MU
    first = 1.5 * scale * root
    if widening != 0.0:
        first *= 1.0 + widening / (3.0 * r * r)
    return scale * r * root * pace(r, widening), first, 0.75 * scale / root


@inlined
def least_swing(largest):
    """Lower bound on the ΔV of phasing per second of flight time, from the largest radius [m/s²].

    Burns before and after the turn are at least 0.2 v/r for each metre between the phasing radius
    and that of an end (vis-viva at the largest radius; 0.25 v/r between near radii), and both ways
    together are at least twice the distance from the middle. Kepler's third law at the largest
    radius gives the seconds of a metre: 1.5 π (2 − f + 2 k) / (v r).
    """
    return 0.4 * MU_M3_S2 / (1.5 * math.pi * largest * largest)


@kernel
def prepare(orbit_i, orbit_j, extra_delta_v, rule, time):
    """Compute the data of the transfer i → j that do not depend on the departure.

    Parameters
    ----------
    orbit_i, orbit_j : (4,) float64
        Rows of :data:`adr_opt.kernels.orbits.ephemeris.ORBIT_COLUMNS`.
    extra_delta_v : float
        What matching the eccentricity vectors alone would cost, zero between circles [m/s]. Under
        J2 it depends on the time, and is :func:`adr_opt.kernels.orbits.eccentricity.matching`.
    rule : TransferRule
    time : float
        About which elements and rates are taken: they hold for all departures [s].

    Returns
    -------
    Pair
    """
    ri, rj = ephemeris.radius_at(orbit_i, time), ephemeris.radius_at(orbit_j, time)
    inclination_i = ephemeris.inclination_at(orbit_i, time)
    inclination_j = ephemeris.inclination_at(orbit_j, time)
    alpha_i, alpha_j, theta = ephemeris.relative_node(
        inclination_i,
        ephemeris.node_at(orbit_i, time),
        inclination_j,
        ephemeris.node_at(orbit_j, time),
    )
    node_i, node_rate_i = ephemeris.node_tangent(orbit_i, time)
    node_j, node_rate_j = ephemeris.node_tangent(orbit_j, time)
    latitude_i, rate_i = ephemeris.latitude_tangent(orbit_i, time)
    latitude_j, rate_j = ephemeris.latitude_tangent(orbit_j, time)
    perigee_i, perigee_rate_i = ephemeris.perigee_tangent(orbit_i, time)
    perigee_j, perigee_rate_j = ephemeris.perigee_tangent(orbit_j, time)
    cosine_i, cosine_j = math.cos(inclination_i), math.cos(inclination_j)
    strength = 1.5 * rule.oblateness
    wide_i = strength * (4.0 * cosine_i * cosine_i - 1.0)
    wide_j = strength * (4.0 * cosine_j * cosine_j - 1.0)
    drifts = ephemeris.planes_drift(rule.oblateness)
    fixed = ephemeris.mean_motion(rj) * rule.approach_length
    eccentricity_i = eccentricity_j = matching_alone = 0.0
    if drifts or rule.free:
        eccentricity_i = ephemeris.eccentricity_at(orbit_i, time)
        eccentricity_j = ephemeris.eccentricity_at(orbit_j, time)
    if not drifts:
        matching_alone = extra_delta_v
    # The turning burn takes the velocity v₁ of arc 1 to a velocity at the angle θ: it is at least
    # the distance of v₁ from that direction, v₁ sin θ (v₁ itself beyond a right angle), and v₁ is
    # least at the greatest radius.
    slowest = math.sqrt(2.0 * MU_M3_S2 * ri / (rule.max_radius * (ri + rule.max_radius)))
    turn_floor = slowest * (math.sin(theta) if theta < 0.5 * math.pi else 1.0)
    if drifts:
        turn_floor = 0.0  # planes drift towards each other
    f = rule.first_leg_fraction
    reference = 0.5 * (ri + rj)
    turn = 4.0 * math.sin(0.5 * theta) ** 2
    floor, low, high = max(turn_floor, matching_alone), rule.min_radius, rule.max_radius
    free_speed, swing = 0.0, 0.0
    if not (drifts or rule.free):
        swing = least_swing(max(ri, rj, rule.max_radius))
    if rule.free:
        free_speed = math.sqrt(MU_M3_S2 / math.sqrt(ri * rj))
        # Apsides of the orbit between both ends, whose eccentricity vector is half way.
        middle = 0.5 * (eccentricity_i + eccentricity_j)
        low /= 1.0 - middle
        high = max(low, high / (1.0 + middle))
        least_turn, least_shape = turn, abs(eccentricity_j - eccentricity_i)
        if drifts:
            least_turn = 0.0
        floor = free_burns.floor(free_speed, (rj - ri) / reference, least_shape, least_turn)
        fixed += math.inf if extra_delta_v == math.inf else 0.0
    flight, flight_1, flight_2 = flight_time(ri, rj, wide_i, wide_j, f, reference)
    lap, lap_1, lap_2 = lap_time(reference, wide_j)
    # The floor and the range of flight times are moved outwards by more than rounding: searches
    # leave out all beyond them, and must not lose what lies on them.
    return Pair(
        ri,
        rj,
        alpha_i,
        alpha_j,
        theta,
        latitude_i - alpha_i,
        latitude_j - alpha_j,
        rate_i,
        rate_j,
        math.sqrt(MU_M3_S2 / ri),
        math.sqrt(MU_M3_S2 / rj),
        turn,
        fixed,
        fixed + floor * (1.0 - 1e-12),
        reference,
        flight,
        flight_1,
        flight_2,
        lap,
        lap_1,
        lap_2,
        flight_time(ri, rj, wide_i, wide_j, f, low)[0] - SLACK_S,
        lap_time(low, wide_j)[0],
        flight_time(ri, rj, wide_i, wide_j, f, high)[0] + SLACK_S,
        lap_time(high, wide_j)[0],
        inclination_i,
        inclination_j,
        node_j - node_i,
        node_rate_j - node_rate_i,
        node_rate_j,
        latitude_i,
        latitude_j,
        wide_i,
        wide_j,
        -strength * math.pi * cosine_i,
        -strength * math.pi * cosine_j,
        matching_alone,
        eccentricity_i,
        eccentricity_j,
        perigee_i,
        perigee_rate_i,
        perigee_j - perigee_i,
        perigee_rate_j - perigee_rate_i,
        free_speed,
        fixed + turn_floor * (1.0 - 1e-12),
        swing,
        ephemeris.latitude_acceleration_at(orbit_i, time),
        ephemeris.latitude_acceleration_at(orbit_j, time),
    )


@inlined
def decays(pair):
    """Whether either orbit decays, so that its argument of latitude is quadratic in time."""
    return pair.acceleration_i != 0.0 or pair.acceleration_j != 0.0


@inlined
def time_at(latitude, rate, acceleration, angle):
    """Time at which an argument of latitude, given for t = 0, is at an angle [s].

    Parameters
    ----------
    latitude, rate, acceleration : float
        At t = 0 [rad], [rad/s], [rad/s²].
    angle : float
        Whole turns counted [rad].
    """
    ahead = angle - latitude
    if acceleration == 0.0:
        return ahead / rate
    # The root that stays finite without an acceleration.
    return 2.0 * ahead / (rate + math.sqrt(max(rate * rate + 2.0 * acceleration * ahead, 0.0)))


@inlined
def latitude_of_i(pair, time):
    """Argument of latitude of the origin at a time [rad]."""
    if pair.acceleration_i == 0.0:
        return pair.latitude_i + pair.rate_i * time
    return pair.latitude_i + (pair.rate_i + 0.5 * pair.acceleration_i * time) * time


@inlined
def latitude_of_j(pair, time):
    """Argument of latitude of the destination at a time [rad]."""
    if pair.acceleration_j == 0.0:
        return pair.latitude_j + pair.rate_j * time
    return pair.latitude_j + (pair.rate_j + 0.5 * pair.acceleration_j * time) * time


@inlined
def rate_of_j(pair, time):
    """Rate of the argument of latitude of the destination at a time [rad/s]."""
    return pair.rate_j + pair.acceleration_j * time


@kernel
def first_departure(pair):
    """The first departure event at or after t = 0, and its number of half turns past N.

    Returns
    -------
    time : float
        [s], less than half a period of i, and before 0 by no more than the slack: a chaser that is
        ready at 0 takes that event too.
    half_turns : int
        Angle of the chaser from N at that event, in half revolutions.
    """
    half_turns = math.ceil((pair.phase_i - SLACK_S * pair.rate_i) / math.pi)
    return (half_turns * math.pi - pair.phase_i) / pair.rate_i, int(half_turns)


@kernel
def target_lead(pair, departure, half_turns):
    """Δ: lead of the target over the chaser at the departure event, in [0, 2π) [rad]."""
    lead = pair.phase_j + pair.rate_j * departure - math.pi * (half_turns % 2)
    lead -= TURN_RAD * math.floor(lead / TURN_RAD)
    return lead if lead < TURN_RAD else 0.0


@inlined
def phasing_radius(pair, rule, revolutions, time):
    """The radius r_x at which the sequence with k revolutions takes the given time [m].

    T(r_x) is increasing and nearly linear over the altitude limits: a quadratic inversion about
    the mean radius, then Halley steps. They converge cubically, so a step below 1e-5 leaves an
    error at the rounding level. Under J2, of which derivatives know the first order, a step has to
    be less.
    """
    k = float(revolutions)
    small = 1e-5 if pair.widening_i == 0.0 and pair.widening_j == 0.0 else 1e-9
    slope = pair.flight_1 + k * pair.lap_1
    d = (time - pair.flight - k * pair.lap) / slope
    d -= 0.5 * (pair.flight_2 + k * pair.lap_2) / slope * d * d
    r = pair.reference + d
    for _ in range(8):
        t0, t1, t2 = flight_time(
            pair.radius_i,
            pair.radius_j,
            pair.widening_i,
            pair.widening_j,
            rule.first_leg_fraction,
            r,
        )
        if revolutions > 0:
            p0, p1, p2 = lap_time(r, pair.widening_j)
            t0 += k * p0
            t1 += k * p1
            t2 += k * p2
        error = t0 - time
        step = error / (t1 - 0.5 * t2 * error / t1)
        r -= step
        if abs(step) < small * r:
            break
    return r


@inlined
def burn_parts(pair, rule, revolutions, r):
    """The four numbers that determine the ΔV of a sequence, each smooth in r.

    See docs/model.md section 2.

    Returns
    -------
    climb : float
        First burn, against the velocity if negative [m/s].
    rest : float
        All burns after the turn likewise: they have one sense [m/s].
    chord : float
        Speed of the chaser at the turn, less its speed after it [m/s].
    square : float
        The product of the two speeds [m²/s²].
    """
    ri, rj = pair.radius_i, pair.radius_j
    rc = r + rule.first_leg_fraction * (rj - r)
    # Each half ellipse by its speed at departure; the arrival speed follows from r₁ v₁ = r₂ v₂.
    v1 = math.sqrt(2.0 * MU_M3_S2 * r / (ri * (ri + r)))
    v2 = math.sqrt(2.0 * MU_M3_S2 * rc / (r * (r + rc)))
    v3 = math.sqrt(2.0 * MU_M3_S2 * rj / (rc * (rc + rj)))
    arrival = v1 * ri / r
    rest = (v3 - v2 * r / rc) + (pair.speed_j - v3 * rc / rj)
    circle = v2
    if revolutions > 0:
        circle = math.sqrt(MU_M3_S2 / r)
        rest += v2 - circle
    return v1 - pair.speed_i, rest, arrival - circle, arrival * circle


@inlined
def leg_delta_v(pair, rule, revolutions, r, departure, time, turn):
    """Price of a leg by the instance's transfer rule (docs/model.md sections 2.5 and 2.7) [m/s].

    Parameters
    ----------
    pair : Pair
    rule : TransferRule
    revolutions : int
        k.
    r : float
        Phasing radius [m].
    departure, time : float
        When it leaves, and how long it flies to the stand-off [s].
    turn : float
        4 sin²(θ/2).
    """
    if pair.free_speed == 0.0:
        matching = eccentricity.matching(pair, departure)
        return turned_delta_v(pair, rule, revolutions, r, turn, matching)
    along, across = free_burns.shape(pair, departure, latitude_of_i(pair, departure))
    price = free_burns.delta_v(
        free_burns.faces_of(revolutions),
        pair.free_speed,
        free_burns.climb(pair),
        free_burns.swing(pair, revolutions, time),
        along,
        across,
        turn,
    )
    return price + pair.fixed_delta_v


@inlined
def turned_delta_v(pair, rule, revolutions, r, turn, matching):
    """ΔV of the sequence with phasing radius r, by vis-viva (docs/model.md section 2) [m/s].

    Parameters
    ----------
    pair : Pair
    rule : TransferRule
    revolutions : int
        k.
    r : float
        [m].
    turn, matching : float
        4 sin²(θ/2), and v |Δe| / 2 [m/s].
    """
    climb, rest, chord, square = burn_parts(pair, rule, revolutions, r)
    return whole(climb, rest, chord, square * turn, matching) + pair.fixed_delta_v


@inlined
def whole(climb, rest, chord, turned, matching):
    """ΔV of a sequence without the approach [m/s].

    Parameters
    ----------
    climb, rest, chord : float
        As of :func:`burn_parts` [m/s].
    turned, matching : float
        As :func:`adr_opt.kernels.orbits.eccentricity.whole` takes them [m²/s²], [m/s].
    """
    # (v₁ − v₂)² + 4 v₁ v₂ sin²(θ/2) is the cosine formula without its cancellation.
    circles = abs(climb) + abs(rest) + math.sqrt(chord * chord + turned)
    return eccentricity.whole(circles, turned, matching)
