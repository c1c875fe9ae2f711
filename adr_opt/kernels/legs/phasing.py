"""Least ΔV over all numbers of phasing revolutions, at many flight times at once.

With k given, what a sequence costs is a function of its flight time alone. It has bends where the
phasing radius passes that of the origin or of the destination, but is made of four numbers that
have none (:func:`.co_elliptic.burn_parts`). So these are interpolated over the flight time: the
nodes are radii, whose flight times and numbers are explicit, and between them nothing is solved
for. What is left of interpolation is at the level of rounding where the altitude limits are not
:data:`WIDE`; where they are, every sequence is solved for.
"""

import math
from typing import NamedTuple

import numpy as np

from ..core.compile import inlined, kernel
from ..orbits.ephemeris import planes_drift
from . import co_elliptic, free_burns, precession

SWING = 0
"""Place of the swing (:mod:`.free_burns`) among the numbers of a pair whose burns are free."""

NODES = 16
"""Number of interpolation nodes, a constant so that the compiler unrolls the loop over them."""


class Curves(NamedTuple):
    """Costs of the sequences of a pair by flight time, for each number of revolutions.

    Attributes
    ----------
    time : (revolutions + 1, nodes) float64
        Flight times of the nodes [s].
    coefficients : (revolutions + 1, 5, nodes) float64
        Newton's divided differences of the four numbers, and of ε (:mod:`.precession`) under J2;
        none where limits are wide. Where burns are free the first number is the swing instead.
    """

    time: np.ndarray
    coefficients: np.ndarray


WIDE = 0.17
"""Half the span of the altitude limits, as a share of their mean radius, up to which this number of
nodes keeps errors below 1e-10 m/s. The usual limits, 300 and 2,000 km, are at 0.11."""


def _spread_nodes():
    """Chebyshev points, ordered so that Newton's interpolation loses no digits (Leja's order)."""
    left = [math.cos((node + 0.5) * math.pi / NODES) for node in range(NODES)]
    points = [left.pop(0)]
    while left:
        points.append(max(left, key=lambda x: math.prod(abs(x - point) for point in points)))
        left.remove(points[-1])
    return np.array(points)


POINTS = _spread_nodes()


@kernel
def curves_of(pair, rule):
    """The curves of a pair, or none if the altitude limits are too wide for them.

    Parameters
    ----------
    pair : Pair
    rule : TransferRule

    Returns
    -------
    Curves
    """
    middle = 0.5 * (rule.max_radius + rule.min_radius)
    half = 0.5 * (rule.max_radius - rule.min_radius)
    counts = 0 if half > WIDE * middle else rule.max_phasing_revolutions + 1
    time, coefficients = np.empty((counts, NODES)), np.empty((counts, 5, NODES))
    if counts == 0:
        return Curves(time, coefficients)
    drifts = planes_drift(rule.oblateness)
    parts, free = 5 if drifts else 4, pair.free_speed > 0.0
    flight, lap, radius = np.empty(NODES), np.empty(NODES), np.empty(NODES)
    direct, phased = np.empty((4, NODES)), np.empty((4, NODES))
    for n in range(NODES):
        r = radius[n] = middle + half * POINTS[n]
        flight[n] = co_elliptic.flight_time(
            pair.radius_i,
            pair.radius_j,
            pair.widening_i,
            pair.widening_j,
            rule.first_leg_fraction,
            r,
        )[0]
        lap[n] = co_elliptic.lap_time(r, pair.widening_j)[0]
        direct[0, n], direct[1, n], direct[2, n], direct[3, n] = co_elliptic.burn_parts(
            pair, rule, 0, r
        )
        phased[0, n], phased[1, n], phased[2, n], phased[3, n] = co_elliptic.burn_parts(
            pair, rule, 1, r
        )
    for k in range(counts):
        values, own = direct if k == 0 else phased, coefficients[k]
        for n in range(NODES):
            time[k, n] = flight[n] + k * lap[n]
            for part in range(4):
                own[part, n] = values[part, n]
            if free:
                own[SWING, n] = free_burns.swing(pair, k, time[k, n])
            own[4, n] = precession.carried(pair, rule, k, radius[n], time[k, n]) if drifts else 0.0
        # Newton's divided differences, in place. The flight time rises with the radius, so that
        # nodes are distinct; with Leja's order the products stay of one size, and no digits are
        # lost.
        for first in range(1, NODES):
            for n in range(first, NODES):
                share = 1.0 / (time[k, n] - time[k, first - 1])
                for part in range(parts):
                    own[part, n] = (own[part, n] - own[part, first - 1]) * share
    return Curves(time, coefficients)


@inlined
def parts_at(curves, k, time):
    """The four numbers of a sequence with k revolutions by its flight time, and ε under J2."""
    climb = rest = chord = square = shift = 0.0
    nodes, own = curves.time[k], curves.coefficients[k]
    for n in range(NODES - 1, -1, -1):
        after = time - nodes[n]
        climb = climb * after + own[0, n]
        rest = rest * after + own[1, n]
        chord = chord * after + own[2, n]
        square = square * after + own[3, n]
        shift = shift * after + own[4, n]
    return climb, rest, chord, square, shift


class Flights(NamedTuple):
    """Flights that leave half a revolution apart: the first departure [s], times [s], how many."""

    departure: float
    times: np.ndarray
    size: int


class _Laps(NamedTuple):
    """A number of phasing revolutions and the flight times at which it can be flown [s]."""

    k: int
    low: float
    high: float


class _Price(NamedTuple):
    """Terms that turn the four numbers into a ΔV: 4 sin²(θ/2), v |Δe| / 2 and approach [–, m/s]."""

    turn: float
    matching: float
    fixed: float


@kernel
def _lower(times, size, laps, nodes, coefficients, price, cost, revolutions):
    """Lower costs to those of sequences with k revolutions; one loop that is vectorised."""
    k, low, high = laps
    turn, matching, fixed = price
    for t in range(size):
        time = times[t]
        climb = rest = chord = square = 0.0
        for n in range(NODES - 1, -1, -1):
            after = time - nodes[n]
            climb = climb * after + coefficients[0, n]
            rest = rest * after + coefficients[1, n]
            chord = chord * after + coefficients[2, n]
            square = square * after + coefficients[3, n]
        found = co_elliptic.whole(climb, rest, chord, square * turn, matching) + fixed
        better = (low <= time) & (time <= high) & (found < cost[t])
        cost[t] = found if better else cost[t]
        revolutions[t] = k if better else revolutions[t]


class _FreePrice(NamedTuple):
    """Terms that turn the swing into a ΔV, as :func:`.free_burns.delta_v` takes them; approach."""

    faces: free_burns.Faces
    speed: float
    climb: float
    along: float
    across: float
    turn: float
    fixed: float


@kernel
def _lower_free(times, size, laps, nodes, coefficients, price, cost, revolutions):
    """Lower costs to prices by free burns at events half a revolution apart (Δe alternates)."""
    k, low, high = laps
    faces, speed, climb, along, across, turn, fixed = price
    for t in range(size):
        time, swing, sign = times[t], 0.0, 1.0 - 2.0 * (t & 1)
        for n in range(NODES - 1, -1, -1):
            swing = swing * (time - nodes[n]) + coefficients[SWING, n]
        found = fixed + free_burns.delta_v(
            faces, speed, climb, swing, sign * along, sign * across, turn
        )
        better = (low <= time) & (time <= high) & (found < cost[t])
        cost[t] = found if better else cost[t]
        revolutions[t] = k if better else revolutions[t]


@kernel
def lower(pair, rule, curves, k, flights, cost, revolutions):
    """Lower costs at flight times to those of sequences with k revolutions, if less.

    Parameters
    ----------
    pair : Pair
    rule : TransferRule
    curves : Curves
    k : int
        Phasing revolutions.
    flights : Flights
    cost : (times,) float64
        Least ΔV so far, +inf for none [m/s]; written.
    revolutions : (times,) int64
        With how many revolutions; written.
    """
    departure, times, size = flights
    low = pair.shortest + k * pair.shortest_lap
    high = pair.longest + k * pair.longest_lap
    if curves.time.shape[0] > 0 and pair.free_speed > 0.0:
        latitude = co_elliptic.latitude_of_i(pair, departure)
        along, across = free_burns.shape(pair, departure, latitude)
        _lower_free(
            times,
            size,
            _Laps(k, low, high),
            curves.time[k],
            curves.coefficients[k],
            _FreePrice(
                free_burns.faces_of(k),
                pair.free_speed,
                free_burns.climb(pair),
                along,
                across,
                pair.turn,
                pair.fixed_delta_v,
            ),
            cost,
            revolutions,
        )
        return
    if curves.time.shape[0] > 0:
        price = _Price(pair.turn, pair.matching, pair.fixed_delta_v)
        _lower(
            times,
            size,
            _Laps(k, low, high),
            curves.time[k],
            curves.coefficients[k],
            price,
            cost,
            revolutions,
        )
        return
    for t in range(size):
        if low <= times[t] <= high:
            r = co_elliptic.phasing_radius(pair, rule, k, times[t])
            leaves = departure + t * math.pi / pair.rate_i
            found = co_elliptic.leg_delta_v(pair, rule, k, r, leaves, times[t], pair.turn)
            if found < cost[t]:
                cost[t], revolutions[t] = found, k
