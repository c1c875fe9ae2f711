"""The ΔV of legs: the cheapest Lambert arc between where two targets are, and tables of it."""

import math

import numpy as np

from adr_opt.common.constants import DAY_S
from adr_opt.kernels.core.compile import kernel

from . import kepler, lambert
from .reading import Problem

REVOLUTIONS = 20
"""Most revolutions of an arc, as in ESA's utilities."""


@kernel
def cheapest(r_1, v_1, r_2, v_2, seconds, most, found):
    """ΔV of the cheapest arc; infinite if it costs more than ``most`` or if there is none [m/s].

    The plane of an arc is that of its ends, so that what velocities have across it is lost on
    either side: where that is more than ``most``, no arc is worked out.
    """
    n_x = r_1[1] * r_2[2] - r_1[2] * r_2[1]
    n_y = r_1[2] * r_2[0] - r_1[0] * r_2[2]
    n_z = r_1[0] * r_2[1] - r_1[1] * r_2[0]
    across = abs(v_1[0] * n_x + v_1[1] * n_y + v_1[2] * n_z)
    across += abs(v_2[0] * n_x + v_2[1] * n_y + v_2[2] * n_z)
    if across > most * math.sqrt(n_x * n_x + n_y * n_y + n_z * n_z) * (1.0 + 1e-9):
        return math.inf
    best = math.inf
    for arc in range(lambert.arcs(r_1, r_2, seconds, kepler.MU_MOON_M3_S2, REVOLUTIONS, found)):
        one, other = 0.0, 0.0
        for axis in range(3):
            one += (found[arc, axis] - v_1[axis]) ** 2
            other += (found[arc, 3 + axis] - v_2[axis]) ** 2
        total = math.sqrt(one) + math.sqrt(other)
        if total < best:
            best = total
    return best if best <= most else math.inf


@kernel
def pair_costs(elements_i, elements_j, departures, flights, most, cost):
    """ΔV of a pair by departure and flight.

    Parameters
    ----------
    elements_i, elements_j : (6,) float64
    departures, flights : (departures,), (flights,) float64
        [s].
    most : float
        Dearer legs are infinite [m/s].
    cost : (departures, flights) float64
        Is filled [m/s].
    """
    r_1, v_1, r_2, v_2 = np.empty(3), np.empty(3), np.empty(3), np.empty(3)
    found = np.empty((4 * REVOLUTIONS + 2, 6))
    for d in range(departures.size):
        kepler.state(elements_i, departures[d], r_1, v_1)
        for f in range(flights.size):
            kepler.state(elements_j, departures[d] + flights[f], r_2, v_2)
            cost[d, f] = cheapest(r_1, v_1, r_2, v_2, flights[f], most, found)


def delta_v_m_s(
    problem: Problem, origin: int, destination: int, departure_d: float, flight_d: float
) -> float:
    """ΔV of a leg; infinite where there is no arc."""
    times = np.array([departure_d * DAY_S]), np.array([flight_d * DAY_S])
    cost = np.empty((1, 1))
    pair = problem.elements[origin], problem.elements[destination]
    pair_costs(*pair, *times, np.inf, cost)
    return float(cost[0, 0])


def connections(
    problem: Problem,
    origin: int,
    destination: int,
    departures_d: np.ndarray,
    flights_d: np.ndarray,
    most_m_s: float,
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """All legs of a pair on a grid that cost no more than ``most_m_s``.

    Returns
    -------
    departure, arrival, delta_v : (connections,) float64
        [s], [s], [m/s], in order of departure and then of arrival.
    """
    cost = np.empty((departures_d.size, flights_d.size))
    times = departures_d * DAY_S, flights_d * DAY_S
    pair_costs(problem.elements[origin], problem.elements[destination], *times, most_m_s, cost)
    d, f = np.nonzero(np.isfinite(cost))
    return times[0][d], times[0][d] + times[1][f], cost[d, f]


def matrices(
    problem: Problem, departures_d: np.ndarray, flights_d: np.ndarray, most_m_s: float
) -> tuple[np.ndarray, np.ndarray]:
    """The shortest flight of a grid that costs no more than ``most_m_s``, for all pairs.

    Returns
    -------
    duration, delta_v : (departures, targets, targets) float64
        [s] and [m/s]; infinite where there is none, or from a target to itself.
    """
    count = problem.targets
    duration = np.full((departures_d.size, count, count), np.inf)
    delta_v = np.full(duration.shape, np.inf)
    cost = np.empty((departures_d.size, flights_d.size))
    for i in range(count):
        for j in range(count):
            if i == j:
                continue
            times = departures_d * DAY_S, flights_d * DAY_S
            pair_costs(problem.elements[i], problem.elements[j], *times, most_m_s, cost)
            first = np.argmax(np.isfinite(cost), axis=1)
            there = np.isfinite(cost).any(axis=1)
            duration[there, i, j] = times[1][first[there]]
            delta_v[there, i, j] = cost[np.arange(first.size), first][there]
    return duration, delta_v
