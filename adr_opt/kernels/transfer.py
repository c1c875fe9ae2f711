"""One transfer: the co-elliptic sequence (MODEL section 2).

Vocabulary. The chaser leaves body *i* at the line of nodes, flies half an ellipse to the
*phasing radius* r_x, turns there into plane *j*, waits k revolutions on the circle, flies half
an ellipse to the co-elliptic radius r_c and half an ellipse to a point L behind body *j*; the
*approach*, half a safety ellipse, closes the rest.

How the choice is searched. With Δ the lead of the target at departure, the phase condition reads
n_j T = 3π − Δ + δ + 2π s, s = k + m: the flight time depends on (k, m) through s alone. So the
search runs over s with T ascending, and inside over the few k whose phasing radius lies within
the altitude limits. Since w·T grows by w·P_j with every s, it stops as soon as w·T plus a floor
of the ΔV exceeds the best cost found: no later sequence can win.

Eccentric orbits. The circles of the sequence leave out the eccentricity vectors, which differ by
Δe. Burns that are flown for other reasons change them on the way, at no cost as long as there are
enough of them; but to change them and turn the plane takes about hypot(v |Δe| / 2, 2 v sin θ/2). So
a sequence costs that where it is more than what it costs between circles (docs/model.md).
"""

import math
from typing import NamedTuple

import numpy as np

from . import orbits
from .compile import inlined, kernel
from .constants import MU_M3_S2, SLACK_M_S, SLACK_S
from .memory import borrowed

TWO_PI = 2.0 * math.pi
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
        Length of the safety ellipse, 0.5 plus whole inspection laps [periods of the target].
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


class Pair(NamedTuple):
    """What a transfer i → j needs and what does not depend on the departure."""

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
    eccentricity_i: float  # where perigees drift, else 0
    eccentricity_j: float
    perigee_lag: float  # ω_j − ω_i at t = 0 [rad]
    perigee_lag_rate: float  # [rad/s]


class Sequence(NamedTuple):
    """The sequence flown: ``delta_v`` is +inf where there is none."""

    delta_v: float  # [m/s]
    flight_time: float  # departure to stand-off [s]
    revolutions: int  # k
    phasing_radius: float  # r_x [m]


@inlined
def pace(axis, widening):
    """How much longer than a period two-body motion takes to the same latitude; 1 without J2."""
    return 1.0 if widening == 0.0 else 1.0 / (1.0 + widening / (axis * axis))


@inlined
def flight_time(radius_i, radius_j, widening_i, widening_j, fraction, r):
    """T(r_x) without phasing revolutions, and its first two derivatives (MODEL section 2).

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
    scale = TWO_PI / SQRT_MU
    first = 1.5 * scale * root
    if widening != 0.0:
        first *= 1.0 + widening / (3.0 * r * r)
    return scale * r * root * pace(r, widening), first, 0.75 * scale / root


@kernel
def prepare(orbit_i, orbit_j, extra_delta_v, rule):
    """Everything about the transfer i → j that does not depend on the departure.

    Parameters
    ----------
    orbit_i, orbit_j : (4,) float64
        Rows of :data:`adr_opt.kernels.orbits.ORBIT_COLUMNS`.
    extra_delta_v : float
        What matching the eccentricity vectors alone would cost, zero between circles [m/s]. Under
        J2 it depends on the time, and is :func:`matching`.
    rule : TransferRule

    Returns
    -------
    Pair
    """
    ri, rj = orbit_i[orbits.RADIUS], orbit_j[orbits.RADIUS]
    alpha_i, alpha_j, theta = orbits.relative_node(
        orbit_i[orbits.INCLINATION],
        orbit_i[orbits.RAAN],
        orbit_j[orbits.INCLINATION],
        orbit_j[orbits.RAAN],
    )
    inclination_i, inclination_j = orbit_i[orbits.INCLINATION], orbit_j[orbits.INCLINATION]
    cosine_i, cosine_j = math.cos(inclination_i), math.cos(inclination_j)
    strength = 1.5 * rule.oblateness
    wide_i = strength * (4.0 * cosine_i * cosine_i - 1.0)
    wide_j = strength * (4.0 * cosine_j * cosine_j - 1.0)
    drifts = rule.oblateness != 0.0
    fixed = 0.5 * orbits.mean_motion(rj) * rule.standoff
    eccentricity_i = eccentricity_j = matching_alone = 0.0
    if drifts:
        eccentricity_i, eccentricity_j = orbit_i[orbits.ECCENTRICITY], orbit_j[orbits.ECCENTRICITY]
    else:
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
    flight, flight_1, flight_2 = flight_time(ri, rj, wide_i, wide_j, f, reference)
    lap, lap_1, lap_2 = lap_time(reference, wide_j)
    return Pair(
        ri,
        rj,
        alpha_i,
        alpha_j,
        theta,
        orbit_i[orbits.ARGUMENT_OF_LATITUDE] - alpha_i,
        orbit_j[orbits.ARGUMENT_OF_LATITUDE] - alpha_j,
        orbit_i[orbits.LATITUDE_RATE],
        orbit_j[orbits.LATITUDE_RATE],
        math.sqrt(MU_M3_S2 / ri),
        math.sqrt(MU_M3_S2 / rj),
        4.0 * math.sin(0.5 * theta) ** 2,
        fixed,
        fixed + max(turn_floor, matching_alone) * (1.0 - 1e-12),
        reference,
        flight,
        flight_1,
        flight_2,
        lap,
        lap_1,
        lap_2,
        flight_time(ri, rj, wide_i, wide_j, f, rule.min_radius)[0] - SLACK_S,
        lap_time(rule.min_radius, wide_j)[0],
        flight_time(ri, rj, wide_i, wide_j, f, rule.max_radius)[0] + SLACK_S,
        lap_time(rule.max_radius, wide_j)[0],
        inclination_i,
        inclination_j,
        orbit_j[orbits.RAAN] - orbit_i[orbits.RAAN],
        orbit_j[orbits.RAAN_RATE] - orbit_i[orbits.RAAN_RATE],
        orbit_j[orbits.RAAN_RATE],
        orbit_i[orbits.ARGUMENT_OF_LATITUDE],
        orbit_j[orbits.ARGUMENT_OF_LATITUDE],
        wide_i,
        wide_j,
        -strength * math.pi * cosine_i,
        -strength * math.pi * cosine_j,
        matching_alone,
        eccentricity_i,
        eccentricity_j,
        orbit_j[orbits.PERIGEE] - orbit_i[orbits.PERIGEE],
        orbit_j[orbits.PERIGEE_RATE] - orbit_i[orbits.PERIGEE_RATE],
    )


@inlined
def matching(pair, time):
    """What matching alone would cost, v |Δe| / 2, at a time, where perigees drift [m/s]."""
    if pair.eccentricity_i == 0.0 and pair.eccentricity_j == 0.0:
        return 0.0
    angle = pair.perigee_lag + pair.perigee_lag_rate * time
    angle += orbits.along_turn(
        pair.inclination_i, pair.inclination_j, pair.lag + pair.lag_rate * time
    )
    apart = orbits.chord(pair.eccentricity_i, pair.eccentricity_j, angle)
    return 0.5 * math.sqrt(pair.speed_i * pair.speed_j) * apart


@kernel
def matchings(bodies):
    """What matching alone would cost, v |Δe| / 2, of all pairs as the orbits are at t = 0 [m/s].

    v is the geometric mean of the two circular speeds, and Δe the difference of the eccentricity
    vectors once one plane is turned into the other about their line of nodes.

    Parameters
    ----------
    bodies : (bodies, columns) float64
        Rows of :data:`adr_opt.kernels.orbits.ORBIT_COLUMNS`.

    Returns
    -------
    (origin, destination) float64
    """
    count = bodies.shape[0]
    costs = np.zeros((count, count))
    for i in range(count):
        for j in range(i):
            angle = bodies[j, orbits.PERIGEE] - bodies[i, orbits.PERIGEE] + orbits.along_turn(
                bodies[i, orbits.INCLINATION], bodies[j, orbits.INCLINATION],
                bodies[j, orbits.RAAN] - bodies[i, orbits.RAAN],
            )  # fmt: skip
            apart = orbits.chord(
                bodies[i, orbits.ECCENTRICITY], bodies[j, orbits.ECCENTRICITY], angle
            )
            speed = math.sqrt(
                MU_M3_S2 / math.sqrt(bodies[i, orbits.RADIUS] * bodies[j, orbits.RADIUS])
            )
            costs[i, j] = costs[j, i] = 0.5 * speed * apart
    return costs


@kernel
def first_departure(pair):
    """The first departure event at or after t = 0, and how many half turns past N it lies.

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
    """Δ: how far the target leads the chaser at the departure event, in [0, 2π) [rad]."""
    lead = pair.phase_j + pair.rate_j * departure - math.pi * (half_turns % 2)
    lead -= TWO_PI * math.floor(lead / TWO_PI)
    return lead if lead < TWO_PI else 0.0


@inlined
def phasing_radius(pair, rule, revolutions, time):
    """The radius r_x at which the sequence with k revolutions takes the given time [m].

    T(r_x) is increasing and nearly linear over the altitude limits: a quadratic inversion about
    the mean radius, then Halley steps. They converge cubically, so a step below 1e-5 leaves an
    error at the rounding level.
    """
    k = float(revolutions)
    slope = pair.flight_1 + k * pair.lap_1
    d = (time - pair.flight - k * pair.lap) / slope
    d -= 0.5 * (pair.flight_2 + k * pair.lap_2) / slope * d * d
    r = pair.reference + d
    for _ in range(8):
        t0, t1, t2 = flight_time(
            pair.radius_i, pair.radius_j, pair.widening_i, pair.widening_j,
            rule.first_leg_fraction, r,
        )  # fmt: skip
        if revolutions > 0:
            p0, p1, p2 = lap_time(r, pair.widening_j)
            t0 += k * p0
            t1 += k * p1
            t2 += k * p2
        error = t0 - time
        step = error / (t1 - 0.5 * t2 * error / t1)
        r -= step
        if abs(step) < 1e-5 * r:
            break
    return r


@inlined
def burn_parts(pair, rule, revolutions, r):
    """Four numbers that make up the ΔV of a sequence, each without a bend in r (MODEL section 2).

    Returns
    -------
    climb : float
        First burn, against the velocity if negative [m/s].
    rest : float
        All burns after the turn likewise: they have one sense [m/s].
    chord : float
        How much faster the chaser comes to the turn than it leaves [m/s].
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
def sequence_delta_v(pair, rule, revolutions, r):
    """ΔV of the sequence with phasing radius r, by vis-viva (MODEL section 2) [m/s]."""
    return turned_delta_v(pair, rule, revolutions, r, pair.turn, pair.matching)


@inlined
def turned_delta_v(pair, rule, revolutions, r, turn, matching):
    """The same for another turn, 4 sin²(θ/2), and another v |Δe| / 2 [m/s]."""
    climb, rest, chord, square = burn_parts(pair, rule, revolutions, r)
    return whole(climb, rest, chord, square * turn, matching) + pair.fixed_delta_v


@inlined
def whole(climb, rest, chord, turned, matching):
    """ΔV of a sequence, but for the approach [m/s].

    Parameters
    ----------
    climb, rest, chord : float
        As of :func:`burn_parts` [m/s].
    turned : float
        4 v₁ v₂ sin²(θ/2) [m²/s²].
    matching : float
        v |Δe| / 2 [m/s]. With 0 nothing but the sequence between circles counts, to the last digit.
    """
    # (v₁ − v₂)² + 4 v₁ v₂ sin²(θ/2) is the cosine formula without its cancellation.
    circles = abs(climb) + abs(rest) + math.sqrt(chord * chord + turned)
    return max(circles, math.sqrt(matching * matching + turned))


@kernel
def eccentric_share(pair, rule, revolutions, r, turn, matching):
    """What of a sequence's ΔV its burns between circles do not account for [m/s]."""
    circles = turned_delta_v(pair, rule, revolutions, r, turn, 0.0)
    return turned_delta_v(pair, rule, revolutions, r, turn, matching) - circles


@kernel
def half_ellipse_clock(r1, r2, r):
    """Share of its time that a half ellipse from apsis r1 to apsis r2 takes from r1 to r."""
    e = abs(r2 - r1) / (r1 + r2)
    if e == 0.0:
        return 0.0
    # (1 − r/a) / e without its cancellation, which costs seconds on nearly circular arcs.
    cosine = min(1.0, max(-1.0, ((r1 - r) + (r2 - r)) / abs(r2 - r1)))
    anomaly = math.acos(cosine)
    since_perigee = (anomaly - e * math.sin(anomaly)) / math.pi
    return since_perigee if r2 > r1 else 1.0 - since_perigee


@kernel
def half_ellipse_meets(r1, r2, start, end, zone):
    """Whether a half ellipse flown from start to end is in the zone at some moment."""
    low, high = zone[0], zone[1]
    if max(r1, r2) < low or min(r1, r2) > high or end < zone[2] or start > zone[3]:
        return False
    if r1 == r2:
        return True
    # The radius is monotone along the arc, so the stay in the band is one closed interval.
    first = start + (end - start) * half_ellipse_clock(r1, r2, min(max(r1, low), high))
    last = start + (end - start) * half_ellipse_clock(r1, r2, min(max(r2, low), high))
    return first <= zone[3] and last >= zone[2]


@kernel
def is_blocked(pair, rule, revolutions, r, departure):
    """Whether a keep-out zone forbids the sequence (MODEL section 6).

    The zones are closed in altitude and in time. The arcs and the phasing circle are tested
    moment by moment: an arc is blocked only if it is inside the band while the window is open.
    The approach is flown on the target's own orbit; it counts from stand-off to arrival.
    """
    ri, rj = pair.radius_i, pair.radius_j
    rc = r + rule.first_leg_fraction * (rj - r)
    scale = math.pi / SQRT_MU
    a1, a2, a3 = 0.5 * (ri + r), 0.5 * (r + rc), 0.5 * (rc + rj)
    t1 = departure + scale * a1 * math.sqrt(a1) * pace(a1, pair.widening_i)
    t2 = t1 + revolutions * lap_time(r, pair.widening_j)[0]
    t3 = t2 + scale * a2 * math.sqrt(a2) * pace(a2, pair.widening_j)
    t4 = t3 + scale * a3 * math.sqrt(a3) * pace(a3, pair.widening_j)
    t5 = t4 + rule.approach_revolutions * TWO_PI / pair.rate_j
    zones = borrowed(rule.zones)
    for z in range(zones.shape[0]):
        zone = zones[z]
        if t5 < zone[2] or departure > zone[3]:
            continue
        if zone[0] <= r <= zone[1] and t1 <= zone[3] and t2 >= zone[2]:
            return True
        if zone[0] <= rj <= zone[1] and t4 <= zone[3] and t5 >= zone[2]:
            return True
        if (
            half_ellipse_meets(ri, r, departure, t1, zone)
            or half_ellipse_meets(r, rc, t2, t3, zone)
            or half_ellipse_meets(rc, rj, t3, t4, zone)
        ):
            return True
    return False


@kernel
def best_sequence(pair, rule, departure, lead, earliest, latest):
    """The sequence of a departure event with the least ΔV + w·T (MODEL sections 2 and 4).

    Parameters
    ----------
    pair : Pair
    rule : TransferRule
    departure : float
        Time of the departure event; only keep-out zones depend on it [s].
    lead : float
        Δ, the target's lead over the chaser at departure, in [0, 2π) [rad].
    earliest, latest : float
        A sequence that takes less time than ``earliest`` has to wait at its end, so that T is that
        much; one that takes more than ``latest`` is out of the question [s].

    Returns
    -------
    Sequence
        Ties, up to the slack, go to the shorter time, then to the smaller k; ``delta_v`` is +inf
        if every sequence is out of limits or blocked.
    """
    best_cost, best_delta_v, best_time, best_k, best_r = math.inf, math.inf, math.inf, -1, math.nan
    w = rule.time_value
    k_max = rule.max_phasing_revolutions
    phase = 3.0 * math.pi - lead + rule.standoff / pair.radius_j
    s = math.ceil((pair.shortest * pair.rate_j - phase) / TWO_PI)
    last = min(pair.longest + k_max * pair.longest_lap, latest)
    while True:
        time = (phase + TWO_PI * s) / pair.rate_j
        s += 1
        worth = w * max(time, earliest)
        # Dearer than the best by time alone, or longer than any sequence: so is all that follows.
        if time > last or worth + pair.floor_delta_v > best_cost:
            break
        # The k whose range of times [T(r_min), T(r_max)] holds this time.
        k = max(0, math.ceil((time - pair.longest) / pair.longest_lap))
        while k <= k_max and pair.shortest + k * pair.shortest_lap <= time:
            r = phasing_radius(pair, rule, k, time)
            delta_v = sequence_delta_v(pair, rule, k, r)
            cost = delta_v + worth
            if cost < best_cost - SLACK_M_S and not (
                rule.zones.shape[0] > 0 and is_blocked(pair, rule, k, r, departure)
            ):
                best_cost, best_delta_v, best_time, best_k, best_r = cost, delta_v, time, k, r
            k += 1
    return Sequence(best_delta_v, best_time, best_k, best_r)
