r"""Lower bounds on all legs whose arrivals fall into two cells of time: proven, not sampled.

A drift leg that costs no more than C changes the size of its orbit by |y| ≤ Y = (C + |v_y|) / 2
(docs/model.md section 3). Rates of nodes go with the seventh power of the speed, which is convex,
and with the cosine of the inclination. So over the longest time of flight T a leg makes up for no
more of the node than M |y| + Q |z|, with a secant up to Y as slope, and for some more in the arcs
after the drift orbit. With X₀ the least difference of the nodes on arrival, less that,

    ΔV  ≥  min over (y, z) of hypot( X₀ − M y⁺ − Q z⁺,  N₁ + N₂ ),

where y⁺ and z⁺ are y and z on the side that helps, and 0 on the other: the least of four problems,
each with the slopes M or 0 and Q or 0. Each is bounded by a dual. With b₁ and b₂ = v − M b₁ the two
burns, and s₁, s₂ ≥ 0, for every vector w with

    |w|² + s₂² ≤ 1    and    |Mᵀw|² + s₁² ≤ 1

Cauchy's inequality, once for (Mᵀw, s₁) and (b₁, E), once for (w, s₂) and (b₂, E), gives

    √(|b₁|² + E²) + √(|b₂|² + E²)  ≥  w·M b₁ + w·b₂ + (s₁ + s₂) E  =  w·v + (s₁ + s₂) E .

|Mᵀw|² is convex in the time of flight and largest at an end: the conditions are asked for T and for
0. E is taken at its least over the cell, and as 0 where burns are free. That the leg meets its
target after whole laps only adds to its cost. A leg costs C or more, or no less than the bound for
C: the best C is sought.

Short legs turn their plane at once, at a speed of no less than that at the apogee of an ellipse
from the lower body to the highest phasing radius, after at most :data:`SHORT_S` of phasing.
"""

from __future__ import annotations

import math
from concurrent.futures import ThreadPoolExecutor
from typing import NamedTuple

import numpy as np

from adr_opt.common.constants import MU_M3_S2
from adr_opt.kernels.core.compile import inlined, kernel
from adr_opt.kernels.legs import drift_pair
from adr_opt.kernels.orbits import eccentricity
from adr_opt.kernels.orbits.ephemeris import EPOCH_S
from adr_opt.mission.problem import Problem

from .costs import FORBIDDEN, Costs
from .grid_costs import UNIT_M_S

ROUNDS = 4
"""Number of reweighting rounds; more bring less than a tenth of a metre per second."""

SAFETY = 1e-6
"""Share by which a bound is lowered for rounding."""

HOHMANN = 0.99
"""A Hohmann transfer costs no less than this share of the difference of two circular speeds."""

SHORT_S = 1.5 * 86400.0
"""Longest short leg, phasing revolutions included [s]."""

START_M_S, TRIES, TRIES_BESIDE = 300.0, 5, 3
"""First C that is tried [m/s], and numbers of tries from it and from a neighbouring cell's."""


class CellTimes(NamedTuple):
    """Cells of time of arrivals.

    Attributes
    ----------
    first, step : float
        Beginning of the first cell, and their length [s].
    stay, longest : float
        Time at a body, and of the longest transfer [s].
    least_gap : int
        Cells between two arrivals, at least.
    most_m_s : float
        What no leg may cost [m/s].
    """

    first: float
    step: float
    stay: float
    longest: float
    least_gap: int
    most_m_s: float


@kernel
def least_shape(pair, begin, end):
    """Least E between two arrivals [m/s].

    E² is the squared difference of two eccentricities plus a multiple of sin² of half the angle
    between two perigees, which is linear in time: the least sin² is zero where the angle passes a
    full turn, and lies at an end otherwise.
    """
    first = pair.perigee_lag + pair.perigee_lag_rate * begin
    last = pair.perigee_lag + pair.perigee_lag_rate * end
    low, high = min(first, last), max(first, last)
    turn = 2.0 * math.pi
    if math.floor(high / turn) != math.floor(low / turn):
        angle = 0.0
    else:
        angle = low if abs(math.sin(0.5 * low)) < abs(math.sin(0.5 * high)) else high
    return 0.25 * pair.speed * eccentricity.chord(pair.eccentricity_i, pair.eccentricity_j, angle)


@inlined
def _dual(node, climb, tilt, m, q, shape):
    """Lower bound with slopes m and q, where node ≥ 0 is left [m/s].

    Parameters
    ----------
    node, climb, tilt : float
        v [m/s].
    m, q : float
        How much of the node one unit of y and of z makes up for.
    shape : float
        E [m/s].
    """
    wide = m * m + q * q
    first = second = 1.0
    along = up = tilted = 0.0
    for _ in range(ROUNDS):
        both = first + second
        along = (node + first * (m * climb + q * tilt) / both) / (
            first * (1.0 + wide) + second - first * first * wide / both
        )
        up = (climb + first * m * along) / both
        tilted = (tilt + first * q * along) / both
        here = along * along + up * up + tilted * tilted
        there = along * along + (up - m * along) ** 2 + (tilted - q * along) ** 2
        first = math.sqrt(first * first * there + shape * shape) + 1e-6
        second = math.sqrt(second * second * here + shape * shape) + 1e-6
    if along < 0.0:
        # Then more of the node would be a gain, and the least of it is no bound.
        return math.sqrt(climb * climb + tilt * tilt + 4.0 * shape * shape)
    here = along * along + up * up + tilted * tilted
    there = along * along + (up - m * along) ** 2 + (tilted - q * along) ** 2
    # Shrunk until both conditions hold, that for no time of flight with s₁ as well.
    most = max(here, there, 1.0)
    s_2 = math.sqrt(max(1.0 - here / most, 0.0))
    s_1 = math.sqrt(max(1.0 - max(here, there) / most, 0.0))
    whole = along * node + up * climb + tilted * tilt
    return whole / math.sqrt(most) + (s_1 + s_2) * shape


@inlined
def _drifts(pair, node, longest, shape, cost):
    """Lower bound on drift legs that cost no more than a given cost [m/s].

    Parameters
    ----------
    pair : DriftPair
    node : float
        v_x of least size on arrival, with its sign [m/s].
    longest, shape, cost : float
        T [s], E and C [m/s].
    """
    linear = pair.linear
    worth, speed = linear.speed * linear.sine, pair.speed_i
    most = 0.5 * (cost + abs(pair.climb))
    # Lower orbits, to which a chaser speeds up, drift faster than in proportion.
    faster = (1.0 + most / speed) ** 7
    m = worth * abs(pair.node_rate_i) * (faster - 1.0) / most
    unit = 1.5 * pair.oblateness * speed**7 / MU_M3_S2**3
    q = worth * unit * faster / linear.speed
    # In the arcs after the drift orbit rates lie between those of it and of the target.
    ends = pair.approach + 3.0 * pair.half
    of_target = (1.0 - pair.climb / speed) ** 7
    beside = worth * abs(pair.node_rate_i) * abs(of_target - 1.0)
    beside += worth * unit * max(faster, of_target) * abs(linear.tilt) / linear.speed
    side = 1.0 if node >= 0.0 else -1.0
    left = abs(node) - ends * beside
    square, asked = pair.climb**2, 4.0 * shape * shape
    # Where burns are free those that change the size change the eccentricity as well.
    square = max(square, asked) if pair.free else square + asked
    found = math.sqrt(square + linear.tilt**2)
    if left <= 0.0:
        return found
    least, apart = math.inf, 0.0 if pair.free else shape
    m_helps = side * m * longest if pair.node_rate_i >= 0.0 else -side * m * longest
    for number in range(4):
        by_size = m_helps if number % 2 else 0.0
        by_tilt = -side * q * longest if number > 1 else 0.0
        bound = _dual(left, pair.climb, linear.tilt, by_size, by_tilt, apart)
        least = min(least, bound)
    return max(found, least)


@inlined
def _shorts(pair, rule, lag, cost):
    """Lower bound on short legs that cost no more than a given cost [m/s].

    Parameters
    ----------
    pair : DriftPair
    rule : TransferRule
    lag : float
        Least difference of the nodes while they are flown [rad].
    cost : float
        C [m/s].
    """
    linear = pair.linear
    most = 0.5 * (cost / HOHMANN + abs(pair.climb))
    faster = (1.0 + most / min(pair.speed_i, pair.speed_i - pair.climb)) ** 7
    fastest = max(abs(pair.node_rate_i), abs(pair.node_rate_j))
    lag = min(max(lag - SHORT_S * fastest * (faster - 1.0), 0.0), math.pi)
    turn = math.sin(0.5 * (pair.inclination_j - pair.inclination_i)) ** 2
    sines = pair.sine_i * math.sin(pair.inclination_j)
    turn = 2.0 * math.sqrt(turn + sines * math.sin(0.5 * lag) ** 2)
    lower, highest = min(linear.radius_i, linear.radius_j), rule.max_radius
    slowest = math.sqrt(2.0 * MU_M3_S2 * lower / (highest * (lower + highest)))
    return math.sqrt((slowest * turn) ** 2 + (HOHMANN * pair.climb) ** 2)


@inlined
def _least_lag(linear, begin, end, early):
    """Difference of nodes of least size for arrivals between two times, with its sign [rad].

    Departures are up to a time before the first of them. The second value is whether the sign is
    that of all of them.
    """
    slope, by_departure = linear.lag_rate, linear.lag_by_departure
    low = linear.lag + min(slope * begin, slope * end)
    high = linear.lag + max(slope * begin, slope * end)
    low += min(by_departure * (begin - early), by_departure * end)
    high += max(by_departure * (begin - early), by_departure * end)
    turn = 2.0 * math.pi
    if math.floor(high / turn) != math.floor(low / turn):
        return 0.0, True
    low, high = low % turn, high % turn  # both from 0 to a turn now, in order
    if high <= math.pi:
        return low, True
    if low >= math.pi:
        return high - turn, True
    # About the opposite node: either side may be gone.
    return min(low, turn - high), False


@kernel
def least_cost(pair, rule, begin, end, longest, start, tries):
    """Lower bound on legs that arrive between two times after no more than a time of flight.

    Parameters
    ----------
    pair : DriftPair
    rule : TransferRule
    begin, end, longest : float
        [s].
    start : float
        First C that is tried [m/s].
    tries : int

    Returns
    -------
    float
        [m/s].
    """
    linear = pair.linear
    shape = least_shape(linear, begin, end)
    lag, has_side = _least_lag(linear, begin, end, longest)
    early, _ = _least_lag(linear, begin - SHORT_S, end, longest)
    node = linear.speed * linear.sine * lag
    cost, best = start, 0.0
    for _ in range(tries):
        found = _drifts(pair, node, longest, shape, cost)
        if not has_side:
            found = min(found, _drifts(pair, -node, longest, shape, cost))
        found = min(found, _shorts(pair, rule, abs(early), cost))
        best = max(best, min(found, cost))
        # What is found falls with C, so the best one lies between.
        cost = 0.5 * (cost + found)
    return best * (1.0 - SAFETY)


@kernel
def fill_cells(pair, rule, times, table):
    """Fill the bounds of a pair.

    Parameters
    ----------
    pair : DriftPair
    rule : TransferRule
    times : CellTimes
    table : (times, gaps) uint16
        By the cell of the earlier arrival and the cells between; rounded down.
    """
    for g in range(table.shape[1]):
        start, tries = START_M_S, TRIES
        for t in range(table.shape[0]):
            arrives = t + times.least_gap + g
            table[t, g] = FORBIDDEN
            if arrives >= table.shape[0]:
                continue
            longest = min(times.longest, (times.least_gap + g + 1) * times.step - times.stay)
            begin = times.first + arrives * times.step
            found = least_cost(pair, rule, begin, begin + times.step, longest, start, tries)
            start, tries = max(found, 1.0), TRIES_BESIDE
            if found < times.most_m_s:
                table[t, g] = np.uint16(found / UNIT_M_S)


def cells_of(problem: Problem, times: CellTimes, shape: tuple[int, int], cores: int) -> Costs:
    """Bounds of all legs by cells of time.

    Parameters
    ----------
    problem : Problem
    times : CellTimes
    shape : (int, int)
        Numbers of cells, and of gaps between two arrivals.
    cores : int

    Returns
    -------
    (times, targets, targets, gaps) uint16
        [0.1 m/s].
    """
    ends, first = problem.connecting.ends, problem.instance.first_target
    count = len(problem.instance.targets)
    found = np.full((shape[0], count, count, shape[1]), FORBIDDEN, np.uint16)

    def fill(i: int) -> None:
        of_pair = np.empty(shape, np.uint16)
        for j in range(count):
            if i != j:
                bodies = ends.leaving[first + i], ends.arriving[first + j]
                pair = drift_pair.prepare(*bodies, ends.rule, EPOCH_S)
                fill_cells(pair, ends.rule, times, of_pair)
                found[:, i, j] = of_pair

    with ThreadPoolExecutor(cores) as threads:
        list(threads.map(fill, range(count)))
    return found
