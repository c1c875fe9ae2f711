r"""Below what no leg lies whose arrivals fall into two cells of time: proven, not sampled.

The estimate splits what is left to do on arrival, v, into a change b₁ made at departure and
b₂ = v − M b₁ (:mod:`adr_opt.kernels.legs.drift`), and costs √(|b₁|² + E²) + √(|b₂|² + E²). For
every vector y and s₁, s₂ ≥ 0 with

    |y|² + s₂² ≤ 1    and    |Mᵀy|² + s₁² ≤ 1

Cauchy's inequality, once for (Mᵀy, s₁) and (b₁, E), once for (y, s₂) and (b₂, E), gives

    √(|b₁|² + E²) + √(|b₂|² + E²)  ≥  y·M b₁ + y·b₂ + (s₁ + s₂) E  =  y·v + (s₁ + s₂) E

whatever the split is, so also where the altitude limits bend it. Over a cell three things vary:

- the time of flight T, up to the most that the two cells leave room for, S. M is linear in T, so
  |Mᵀy|² is convex in it and largest at an end: the conditions are asked for T = S and for T = 0,
  where M is the identity;
- the node, of which v_x is linear in the time of arrival: y·v is least at an end of the cell;
- E, in which the bound grows. E² is the squared difference of two eccentricities plus a multiple of
  sin² of half the angle between two perigees. That angle is linear in time: the least sin² over the
  cell is zero where the angle passes a full turn, and lies at an end otherwise.

Every y is valid; a good one comes from the best split, which weighted least squares approach. If
v_x changes sign in between, or jumps where the node is opposite, y_x = 0 is right: then Mᵀy = y,
and the bound is √(v_y² + v_z² + 4 E²).
"""

from __future__ import annotations

import math

import numpy as np
import numpy.typing as npt

from adr_opt.common.constants import DAY_S, OBLATENESS_M2
from adr_opt.kernels.core.compile import inlined, kernel
from adr_opt.kernels.legs import drift_linear as drift
from adr_opt.kernels.orbits import eccentricity

from ..reading import FloatArray
from .estimate import LIMITS_M
from .expense import DRY_KG, EXHAUST_M_S, MOST_PROPELLANT_KG
from .scoring import FIRST_D, LAST_D, STAY_D, WITHIN_D

UNIT_M_S = 0.1
"""ΔV of one unit of the cells [m/s]."""

MOST_M_S = EXHAUST_M_S * math.log(1.0 + MOST_PROPELLANT_KG / DRY_KG) + 1.0
"""A leg of more needs more than a full tank by itself, whatever a chaser carries besides."""

ROUNDS = 4
"""Number of reweighting rounds; more bring less than a tenth of a metre per second."""

SAFETY = 1e-9
"""Share by which a bound is lowered for the rounding of its own arithmetic."""


@kernel
def least_shape(pair, begin, end):
    """E at its least between two arrivals [m/s]."""
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
def below(pair, m, q, at, low, high, shape):
    """A bound for all nodes from ``low`` to ``high``, by the y that is best at ``at``.

    Parameters
    ----------
    pair : LinearPair
    m, q : float
        Of the longest time of flight.
    at, low, high, shape : float
        v_x, between which it lies, and E [m/s].

    Returns
    -------
    bound, along : float
        [m/s], and y_x.
    """
    wide = m * m + q * q
    first = second = 1.0
    along = climb = tilt = 0.0
    for _ in range(ROUNDS):
        both = first + second
        along = (at + first * (m * pair.climb + q * pair.tilt) / both) / (
            first * (1.0 + wide) + second - first * first * wide / both
        )
        climb = (pair.climb + first * m * along) / both
        tilt = (pair.tilt + first * q * along) / both
        here = along * along + climb * climb + tilt * tilt
        there = along * along + (climb - m * along) ** 2 + (tilt - q * along) ** 2
        first = math.sqrt(first * first * there + shape * shape) + 1e-6
        second = math.sqrt(second * second * here + shape * shape) + 1e-6
    here = along * along + climb * climb + tilt * tilt
    there = along * along + (climb - m * along) ** 2 + (tilt - q * along) ** 2
    # Shrunk until both conditions hold, that for T = 0 with s₁ as well.
    most = max(here, there, 1.0)
    scale = 1.0 / math.sqrt(most)
    s_2 = math.sqrt(max(1.0 - here / most, 0.0))
    s_1 = math.sqrt(max(1.0 - max(here, there) / most, 0.0))
    node = low if along > 0.0 else high
    found = scale * (along * node + climb * pair.climb + tilt * pair.tilt) + (s_1 + s_2) * shape
    return found, along


@kernel
def least_cost(pair, begin, end, longest):
    """Below what no leg lies that arrives between two times after no more than a time of flight.

    Parameters
    ----------
    pair : LinearPair
    begin, end, longest : float
        [s].

    Returns
    -------
    float
        [m/s].
    """
    shape = least_shape(pair, begin, end)
    bound = math.sqrt(pair.climb**2 + pair.tilt**2 + 4.0 * shape * shape)
    first, last = drift.node_left(pair, begin), drift.node_left(pair, end)
    change = pair.speed * pair.sine * pair.lag_rate * (end - begin)
    if abs(last - first - change) > 1e-3 + 1e-9 * abs(change):
        # The node jumps in between.
        return bound * (1.0 - SAFETY)
    low, high = min(first, last), max(first, last)
    m, q = pair.by_radius * longest, pair.by_inclination * longest
    found, along = below(pair, m, q, low, low, high, shape)
    bound = max(bound, found)
    if along < 0.0:
        found, along = below(pair, m, q, high, low, high, shape)
        bound = max(bound, found)
    return bound * (1.0 - SAFETY)


@kernel
def fill_cells(pair, first, step, stay, most, least_gap, unit, most_units, table):  # noqa: PLR0913
    """Fill the bounds of a pair.

    Parameters
    ----------
    pair : LinearPair
    first, step, stay, most : float
        Of the cells; least stay, and longest transfer [s].
    least_gap : int
    unit : float
        [m/s].
    table : (times, gaps) uint16
        By the cell of the earlier arrival and the cells between; rounded down.
    most_units : float
        What no leg may cost.
    """
    times, gaps = table.shape
    for t in range(times):
        for g in range(gaps):
            arrives = t + least_gap + g
            table[t, g] = 65535
            if arrives >= times:
                continue
            longest = min(most, (least_gap + g + 1) * step - stay)
            begin = first + arrives * step
            found = least_cost(pair, begin, begin + step, longest) / unit
            if found < most_units:
                table[t, g] = np.uint16(found)


def cells(rows: FloatArray, step_d: float) -> npt.NDArray[np.uint16]:
    """Bounds of all legs by cells of time.

    Parameters
    ----------
    rows : (debris, columns) float64
    step_d : float
        Of the cells; stay and longest leg are whole numbers of it, so that arrivals at least a stay
        apart lie at least as many cells apart, and likewise for the most [d].

    Returns
    -------
    (times, debris, debris, gaps) uint16
        [0.1 m/s].
    """
    count, times = len(rows), int((LAST_D - STAY_D - FIRST_D) / step_d) + 1
    least = round(STAY_D / step_d)
    gaps = round(WITHIN_D / step_d) - least + 1
    found = np.full((times, count, count, gaps), 65535, np.uint16)
    of_pair = np.empty((times, gaps), np.uint16)
    for i in range(count):
        for j in range(count):
            if i != j:
                pair = drift.prepare(rows[i], rows[j], *LIMITS_M, OBLATENESS_M2, 0.0)
                fill_cells(
                    pair, FIRST_D * DAY_S, step_d * DAY_S, STAY_D * DAY_S,
                    (WITHIN_D - STAY_D) * DAY_S, least, UNIT_M_S, MOST_M_S / UNIT_M_S, of_pair,
                )  # fmt: skip
                found[:, i, j] = of_pair
    return found
