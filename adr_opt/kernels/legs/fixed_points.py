"""Fixed points of the sequences between drifting planes, solved many at once.

What :func:`.precession.fixed_point` finds one by one, with an inversion and a line of nodes at
every step, follows from one number here: s, by how much the difference of the RAANs that a sequence
is flown for differs from that of its event. With s both ends are known, since the tangents of the
angles by which the line of nodes moves are rational in sin s and cos s; and with the flight time
between the ends ε is, read off the curves of the pair (:mod:`.phasing`). So s is the fixed point of
products and sums without a branch, and the compiler makes vectors of them. Two steps, drawn on by
Aitken's rule, leave an error of rounding; what is left is measured, and a sequence that it is too
much for is said to be unsure.
"""

import math
from typing import NamedTuple

import numpy as np

from ...common.constants import SLACK_S, TURN_RAD
from ..core.compile import inlined, kernel
from ..core.lists import rising
from ..core.memory import borrowed
from ..orbits import eccentricity
from . import co_elliptic, free_burns
from .phasing import NODES, SWING

BLOCK = 128
"""Number of events laid out at once. Offsets within an array are known to the compiler, so that it
sees that no two of its fields overlap."""

BAND_S = 300.0
"""Largest deviation of a flight time without ε from the range of its revolutions [s]."""

FLAT_RAD = 3e-4
"""Angle of two planes from equal or opposite below which too many digits are lost [rad]."""

SMALL = 1.7
"""Largest angle whose arc tangent is computed by a series [rad]."""

TERMS = np.array([(-1.0) ** term / (2.0 * term + 1.0) for term in range(14)])
"""Coefficients of the arc tangent's series, whose remainder is below rounding."""

SURE = 0.03
"""Ratio of successive steps below which the iteration converges to a fixed point."""

ERROR_S = 1e-9
"""Tolerance on the ends of a sequence [s]."""

ASIDE_S = 100.0
"""Distance before and after an event at which the cost of eccentricity is sampled [s]."""

LANES = 8
"""Number of lanes in the widest vectors."""

(BASE, SINE, COSINE, ACROSS_I, ALONG_I, ACROSS_J, ALONG_J, TURN, EARLIEST, ERROR, SHAPE) = range(11)
FACTS = SHAPE + 6
"""Number of facts: the cost of eccentricity is one parabola, Δe for free burns is two."""

COST, REVOLUTIONS, LEFT, MET = range(4)


class _Motion(NamedTuple):
    """Motion of a pair, common to all of its sequences.

    Attributes
    ----------
    rate_i, rate_j : float
        Of the arguments of latitude [rad/s].
    cosine_i, cosine_j : float
        Of the inclinations.
    lag_rate : float
        Of Ω_j − Ω_i [rad/s].
    sines : float
        2 sin i_i sin i_j.
    fixed : float
        ΔV of the approach [m/s].
    """

    rate_i: float
    rate_j: float
    cosine_i: float
    cosine_j: float
    lag_rate: float
    sines: float
    fixed: float


class _Laps(NamedTuple):
    """Sequences with a given number of revolutions in a row of a grid.

    Attributes
    ----------
    k : float
        Revolutions.
    later : float
        How much longer sequences of the row fly than those of the first one [s].
    low, high : float
        Between which flight times there are some with k revolutions [s].
    """

    k: float
    later: float
    low: float
    high: float


class _FreePrice(NamedTuple):
    """Terms of the price of free burns that depend on the revolutions and on the pair."""

    faces: free_burns.Faces
    speed: float
    climb: float


class MeetingGrid(NamedTuple):
    """Cheapest sequences of a block of events, by the time they meet the target.

    Attributes
    ----------
    facts : (fields · BLOCK,) float64
        Of the events: flight time of the first row without ε [s], sine and cosine of δ, and how the
        line of nodes moves in both planes; 4 sin²(θ/2); the earliest departure and the greatest
        error of s; and, as parabolas over the time from the event, the square of what matching
        alone costs, or Δe along and across the line of nodes of the event.
    found : (rows, 4 · BLOCK) float64
        ΔV, +inf for none and −inf where one is unsure [m/s]; revolutions; and how long after the
        event they leave, and after the time of the row they meet [s]. Rows are a revolution of the
        target apart.
    place : (BLOCK,) int64
        Where in these arrays an event is: they are in order of the flight time of the first row.
    curves : (revolutions + 1, 6 · NODES) float64
        Nodes and coefficients of :class:`.phasing.Curves`, in one row for each k.
    """

    facts: np.ndarray
    found: np.ndarray
    place: np.ndarray
    curves: np.ndarray


@kernel
def grid_of(curves, rows):
    """An empty grid for a block of events, from the curves of a pair."""
    flat = np.empty((curves.time.shape[0], 6 * NODES))
    for k in range(flat.shape[0]):
        for n in range(NODES):
            flat[k, n] = curves.time[k, n]
            for part in range(5):
                flat[k, (part + 1) * NODES + n] = curves.coefficients[k, part, n]
    return MeetingGrid(
        np.zeros(FACTS * BLOCK), np.zeros((rows, 4 * BLOCK)), np.empty(BLOCK, np.int64), flat
    )


@inlined
def _enter_parabola(facts, field, e, before, there, after):
    """Fit a parabola in the time from an event to a function's values around it."""
    facts[field * BLOCK + e] = there
    facts[(field + 1) * BLOCK + e] = 0.5 * (after - before) / ASIDE_S
    facts[(field + 2) * BLOCK + e] = 0.5 * (after - 2.0 * there + before) / (ASIDE_S * ASIDE_S)


@inlined
def _parabola(facts, field, e, left):
    """Value of a fitted parabola at a time."""
    second = facts[(field + 1) * BLOCK + e] + left * facts[(field + 2) * BLOCK + e]
    return facts[field * BLOCK + e] + left * second


@inlined
def _enter(pair, facts, e, time, base, lag):
    """Enter an event into a grid: its time, the flight time of its first row, and δ."""
    sine_i, sine_j = math.sin(pair.inclination_i), math.sin(pair.inclination_j)
    cosine_i, cosine_j = math.cos(pair.inclination_i), math.cos(pair.inclination_j)
    half = math.sin(0.5 * lag) ** 2
    sine = math.sin(lag)
    # The line of nodes in each plane, as in orbits.relative_node; its length is sin θ.
    apart = math.sin(pair.inclination_j - pair.inclination_i)
    across_i, along_i = apart - 2.0 * cosine_i * sine_j * half, sine_j * sine
    across_j, along_j = apart + 2.0 * cosine_j * sine_i * half, sine_i * sine
    square = across_i * across_i + along_i * along_i
    facts[BASE * BLOCK + e], facts[SINE * BLOCK + e] = base, sine
    facts[COSINE * BLOCK + e] = math.cos(lag)
    facts[ACROSS_I * BLOCK + e] = across_i * sine_j / square
    facts[ALONG_I * BLOCK + e] = along_i * sine_j / square
    facts[ACROSS_J * BLOCK + e] = across_j * sine_i / square
    facts[ALONG_J * BLOCK + e] = along_j * sine_i / square
    tilt = 4.0 * math.sin(0.5 * (pair.inclination_j - pair.inclination_i)) ** 2
    facts[TURN * BLOCK + e] = tilt + 4.0 * sine_i * sine_j * half
    if pair.free_speed == 0.0:
        before = eccentricity.matching(pair, time - ASIDE_S) ** 2
        there = eccentricity.matching(pair, time) ** 2
        after = eccentricity.matching(pair, time + ASIDE_S) ** 2
        _enter_parabola(facts, SHAPE, e, before, there, after)
    else:
        latitude = co_elliptic.latitude_of_i(pair, time)
        before, aside = free_burns.shape(pair, time - ASIDE_S, latitude)
        there, across = free_burns.shape(pair, time, latitude)
        after, beside = free_burns.shape(pair, time + ASIDE_S, latitude)
        _enter_parabola(facts, SHAPE, e, before, there, after)
        _enter_parabola(facts, SHAPE + 3, e, aside, across, beside)
    facts[EARLIEST * BLOCK + e] = -SLACK_S - time
    # An upper limit on how fast the line moves against s, but for a share of SMALL.
    speed = (sine_j / pair.rate_i + sine_i / pair.rate_j) / math.sqrt(square)
    facts[ERROR * BLOCK + e] = ERROR_S / speed


@inlined
def _angle(sine, cosine):
    """Angle of a direction of any length, from the angle within its quadrant.

    Even and odd terms are added up beside each other, which is faster.
    """
    half = sine / (cosine + math.sqrt(cosine * cosine + sine * sine))
    quarter = half / (1.0 + math.sqrt(1.0 + half * half))
    square = quarter * quarter
    fourth, even, odd = square * square, 0.0, 0.0
    for term in range(12, -1, -2):
        even = even * fourth + TERMS[term]
        odd = odd * fourth + TERMS[term + 1]
    return 4.0 * quarter * (even + odd * square)


@inlined
def _ends(facts, e, s, motion):
    """Delays of departure and of meeting the target relative to the event, after s [s].

    Returns
    -------
    left, met : float
        [s].
    versine : float
        By how much 1 − cos δ grows.
    narrow : bool
        Whether both angles are small enough for that.
    sine_i, into_i : float
        Direction of the line of nodes in the plane of the origin, from that of the event.
    """
    half = 0.5 * s
    q = half * half
    sine = half * (1.0 - q * (1.0 / 6.0) * (1.0 - q * 0.05 * (1.0 - q * (1.0 / 42.0))))
    cosine = 1.0 - 0.5 * q * (1.0 - q * (1.0 / 12.0) * (1.0 - q * (1.0 / 30.0)))
    at_sine, at_cosine = facts[SINE * BLOCK + e], facts[COSINE * BLOCK + e]
    moved = 2.0 * sine * (at_cosine * cosine - at_sine * sine)
    versine = 2.0 * sine * (at_sine * cosine + at_cosine * sine)
    across, along = facts[ACROSS_I * BLOCK + e], facts[ALONG_I * BLOCK + e]
    sine_i = across * moved + motion.cosine_i * along * versine
    into_i = 1.0 + along * moved - motion.cosine_i * across * versine
    across, along = facts[ACROSS_J * BLOCK + e], facts[ALONG_J * BLOCK + e]
    sine_j = across * moved - motion.cosine_j * along * versine
    into_j = 1.0 + along * moved + motion.cosine_j * across * versine
    narrow = (abs(sine_i) <= SMALL * into_i) & (abs(sine_j) <= SMALL * into_j)
    left, met = _angle(sine_i, into_i) / motion.rate_i, _angle(sine_j, into_j) / motion.rate_j
    return left, met, versine, narrow, sine_i, into_i


@inlined
def _shift(curve, time):
    """ε at a flight time."""
    shift = 0.0
    for n in range(NODES - 1, -1, -1):
        shift = shift * (time - curve[n]) + curve[5 * NODES + n]
    return shift


@inlined
def _solved(facts, curve, e, laps, motion):
    """The fixed point of one sequence.

    Returns
    -------
    left, met, versine, sine_i, into_i : float
        As of :func:`_ends`.
    time : float
        From one end to the other [s].
    there, unsure : bool
        Whether the sequence can be flown, and whether that is unsure.
    """
    base = facts[BASE * BLOCK + e] + laps.later
    # s = g(s): g(0), g there, on by Aitken's rule, and a step of the secant method.
    s0 = _shift(curve, base)
    left, met, versine, narrow, sine_i, into_i = _ends(facts, e, s0, motion)
    s1 = motion.lag_rate * left + _shift(curve, base + met - left)
    bend = 2.0 * s0 - s1
    s2 = s1 if bend == 0.0 else s1 + (s1 - s0) * (s1 - s0) / bend
    left, met, versine, narrow, sine_i, into_i = _ends(facts, e, s2, motion)
    s3 = motion.lag_rate * left + _shift(curve, base + met - left)
    steep = 0.0 if s2 == s0 else (s3 - s1) / (s2 - s0)
    s = s2 + (s3 - s2) / (1.0 - steep)
    left, met, versine, narrow, sine_i, into_i = _ends(facts, e, s, motion)
    time = base + met - left
    # Two successive steps whose ratio is small bound the contraction, and a residual below the
    # error bounds the distance to the fixed point; else the sequence is unsure and solved by
    # itself.
    error = facts[ERROR * BLOCK + e]
    sure = (
        (abs(motion.lag_rate * left + _shift(curve, time) - s) <= error)
        & (abs(s1 - s0) <= SURE * abs(s0) + error)
        & narrow
    )
    there = sure & (laps.low <= time) & (time <= laps.high)
    there = there & (left >= facts[EARLIEST * BLOCK + e])
    unsure = (not sure) & (laps.low - BAND_S <= base) & (base <= laps.high + BAND_S)
    return left, met, versine, sine_i, into_i, time, there, unsure


@inlined
def _keep(found, e, cost, there, unsure, k, left, met):
    """Keep a sequence if it costs less than what is kept."""
    cost = cost if there else math.inf
    cost = -math.inf if unsure else cost
    # Read whether or not they are kept: without a branch.
    best, best_k = found[COST * BLOCK + e], found[REVOLUTIONS * BLOCK + e]
    best_left, best_met = found[LEFT * BLOCK + e], found[MET * BLOCK + e]
    better = cost < best
    found[COST * BLOCK + e] = cost if better else best
    found[REVOLUTIONS * BLOCK + e] = k if better else best_k
    found[LEFT * BLOCK + e] = left if better else best_left
    found[MET * BLOCK + e] = met if better else best_met


@kernel
def _lower(facts, curve, found, size, laps, motion):
    """Lower part of a row to costs of sequences with k revolutions; one loop that is vectorised."""
    for e in range(size):
        left, met, versine, _, _, time, there, unsure = _solved(facts, curve, e, laps, motion)
        climb = rest = chord = square = 0.0
        for n in range(NODES - 1, -1, -1):
            after = time - curve[n]
            climb = climb * after + curve[NODES + n]
            rest = rest * after + curve[2 * NODES + n]
            chord = chord * after + curve[3 * NODES + n]
            square = square * after + curve[4 * NODES + n]
        turned = square * (facts[TURN * BLOCK + e] + motion.sines * versine)
        matching = _parabola(facts, SHAPE, e, left)
        circles = abs(climb) + abs(rest) + math.sqrt(chord * chord + turned)
        cost = max(circles, math.sqrt(max(matching, 0.0) + turned)) + motion.fixed
        _keep(found, e, cost, there, unsure, laps.k, left, met)


@kernel
def _lower_free(facts, curve, found, size, laps, motion, price):
    """Lower part of a row to prices by free burns of sequences with k revolutions."""
    faces, speed, climb = price
    for e in range(size):
        left, met, versine, sine_i, into_i, time, there, unsure = _solved(
            facts, curve, e, laps, motion
        )
        swing = 0.0
        for n in range(NODES - 1, -1, -1):
            swing = swing * (time - curve[n]) + curve[(1 + SWING) * NODES + n]
        turn = facts[TURN * BLOCK + e] + motion.sines * versine
        length = math.sqrt(sine_i * sine_i + into_i * into_i)
        along, across = _parabola(facts, SHAPE, e, left), _parabola(facts, SHAPE + 3, e, left)
        along, across = free_burns.turned(along, across, sine_i / length, into_i / length)
        cost = free_burns.delta_v(faces, speed, climb, swing, along, across, max(turn, 0.0))
        _keep(found, e, cost + motion.fixed, there, unsure, laps.k, left, met)


@kernel
def lay_out(pair, grid, numbers, bases, rows):
    """Find the cheapest sequences of some events.

    Parameters
    ----------
    pair : Pair
    grid : MeetingGrid
        Written.
    numbers : (events, 2 or more) float64
        Of at most ``BLOCK`` events: when they are [s], and δ [rad].
    bases : (events,) float64
        Their flight times in the first row without ε: from ``pair.shortest − BAND_S`` on, less than
        a revolution of the target [s].
    rows : int
        Number of rows wanted.
    """
    grid, size = borrowed(grid), bases.size
    lap, first = TURN_RAD / pair.rate_j, pair.shortest - BAND_S
    order, base = rising(bases, size), np.empty(size)
    for place in range(size):
        e = order[place]
        grid.place[e], base[place] = place, bases[e]
        _enter(pair, grid.facts, place, numbers[e, 0], bases[e], numbers[e, 1])
    for row in range(rows):
        for e in range(COST * BLOCK, COST * BLOCK + size):
            grid.found[row, e] = math.inf
    sines = 2.0 * math.sin(pair.inclination_i) * math.sin(pair.inclination_j)
    motion = _Motion(
        pair.rate_i,
        pair.rate_j,
        math.cos(pair.inclination_i),
        math.cos(pair.inclination_j),
        pair.lag_rate,
        sines,
        pair.fixed_delta_v,
    )
    for k in range(grid.curves.shape[0]):
        low = pair.shortest + k * pair.shortest_lap
        high = pair.longest + k * pair.longest_lap
        row = max(int((low - BAND_S - first) / lap), 0)
        while row < rows and first + row * lap <= high + BAND_S:
            begin, end = 0, size
            while begin < end and base[begin] + row * lap < low - BAND_S:
                begin += 1
            while begin < end and base[end - 1] + row * lap > high + BAND_S:
                end -= 1
            # Bases ascend, so that events whose time is in the range of k are beside each other.
            if begin < end:
                # Whole vectors: the rest of a loop that is none would take as long as all of it.
                begin = begin // LANES * LANES
                facts, found = grid.facts[begin:], grid.found[row, begin:]
                whole = (end - begin + LANES - 1) // LANES * LANES
                laps = _Laps(float(k), row * lap, low, high)
                if pair.free_speed == 0.0:
                    _lower(facts, grid.curves[k], found, whole, laps, motion)
                else:
                    price = _FreePrice(
                        free_burns.faces_of(k), pair.free_speed, free_burns.climb(pair)
                    )
                    _lower_free(facts, grid.curves[k], found, whole, laps, motion, price)
            row += 1
