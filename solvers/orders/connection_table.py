"""Table of connections for timing orders of targets: for each pair, those worth taking.

Where nodes drift a pair has thousands of connections. Those that some value of time chooses are a
tenth of them, and an order of targets is timed on them a hundred thousand times a second.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from adr_opt.common.constants import HOUR_S
from adr_opt.common.stop import Stop, TimeIsOver
from adr_opt.common.tolerance import ROUNDED
from adr_opt.kernels.core.compile import kernel
from adr_opt.kernels.core.windows import service_ends
from adr_opt.kernels.tables import timetable_making as making
from adr_opt.mission.mission import Mission

from ..beams.beams import TIME_VALUE_M_S_PER_H

SHARES = (0.0, 0.1, 0.35, 1.0, 3.0, 10.0, 30.0)
"""Values of time whose choices are included, as multiples of the beams' value of an hour."""

STEPS = 60
"""Least ΔV step between points of a front, as a share 1/STEPS of a tank."""


class ConnectionTable(NamedTuple):
    """Connections of all pairs in CSR form, each pair's in order of departure.

    Attributes
    ----------
    first : (bodies, bodies) int64
        Place of the first connection of each pair.
    total : (bodies, bodies) int64
        How many a pair has.
    least : (bodies, bodies) float64
        Least ΔV among them, +inf for none [m/s].
    shortest : (bodies, bodies) float64
        Least time from departure to end, no longer than any of them by rounding, 0 for none [s].
    detour : (bodies, bodies) float64
        Least time of two of them by way of a station, +inf for none [s].
    to_station, from_station : (bodies, bodies) float64
        Least ΔV of the first and of the second of such two, +inf for none [m/s].
    departure, end, delta_v : (connections,) float64
        Departure, end of the service at the destination [s], and ΔV [m/s].
    by_end : (connections,) int32
        The connections of each pair in order of their end, counted from the first of the pair.
    budget : float
        ΔV of a full tank [m/s].
    """

    first: np.ndarray
    total: np.ndarray
    least: np.ndarray
    shortest: np.ndarray
    detour: np.ndarray
    to_station: np.ndarray
    from_station: np.ndarray
    departure: np.ndarray
    end: np.ndarray
    delta_v: np.ndarray
    by_end: np.ndarray
    budget: float


@kernel
def _mark(found, limits, j, values, taken, wanted):
    """Mark the connections of a pair chosen by any of the values of time [m/s per s]."""
    for c in range(wanted.size):
        wanted[c] = False
    for value in values:
        count = making.choose(found, limits, j, value, taken)
        for place in range(taken.size - count, taken.size):
            wanted[taken[place]] = True


def table_of(mission: Mission, stop: Stop | None = None) -> ConnectionTable:
    """The table of a mission with drifting nodes; builds its timetable.

    Raises
    ------
    TimeIsOver
        The time of ``stop`` is over.
    """
    rules, limits = mission.rules, mission.timetable.limits
    connecting = mission.timetable.connecting
    usual = TIME_VALUE_M_S_PER_H * mission.instance.hurry / HOUR_S
    values = usual * np.array(SHARES)
    bodies = rules.service.size
    first, total = np.zeros((2, bodies, bodies), dtype=np.int64)
    least = np.full((bodies, bodies), np.inf)
    shortest = np.zeros((bodies, bodies))
    departures, ends, costs, orders = [], [], [], []
    count = 0
    for i, j in connecting.counts:
        if stop is not None and stop.remaining_s() <= 0.0:
            raise TimeIsOver
        found = connecting.found(i, j)
        taken = np.empty(found.departure.size, dtype=np.int64)
        wanted = np.empty(found.departure.size, dtype=np.bool_)
        _mark(found, limits, j, values, taken, wanted)
        end = service_ends(rules.windows, j, found.arrival[wanted], rules.service[j])
        cost = found.delta_v[wanted]
        kept = (end <= rules.duration) & (cost <= rules.budget)
        end, cost = end[kept], cost[kept]
        departure = found.departure[wanted][kept]
        departures.append(departure)
        ends.append(end)
        costs.append(cost)
        orders.append(np.argsort(end, kind="stable").astype(np.int32))
        first[i, j], total[i, j] = count, end.size
        least[i, j] = cost.min(initial=np.inf)
        if end.size:
            shortest[i, j] = (end - departure).min() - ROUNDED * rules.duration
        count += end.size
    empty = np.empty(0)
    return ConnectionTable(
        first,
        total,
        least,
        shortest,
        *_by_stations(shortest, least, rules.stations),
        np.concatenate([empty, *departures]),
        np.concatenate([empty, *ends]),
        np.concatenate([empty, *costs]),
        np.concatenate([np.empty(0, dtype=np.int32), *orders]),
        rules.budget,
    )


@kernel
def is_varied(connections):
    """Whether connections of a pair differ in ΔV by at least the step between points of a front."""
    for i in range(connections.total.shape[0]):
        for j in range(connections.total.shape[1]):
            most = connections.least[i, j] + connections.budget / STEPS
            begin = connections.first[i, j]
            for c in range(begin, begin + connections.total[i, j]):
                if connections.delta_v[c] > most:
                    return True
    return False


def _by_stations(
    shortest: npt.NDArray[np.float64], least: npt.NDArray[np.float64], stations: int
) -> tuple[npt.NDArray[np.float64], npt.NDArray[np.float64], npt.NDArray[np.float64]]:
    """Least times, and least ΔV to and from, of ways between two bodies by a station."""
    detour, to_station, from_station = np.full((3, *least.shape), np.inf)
    for s in range(stations):
        to, on = least[:, s, None], least[None, s]
        possible = np.isfinite(to) & np.isfinite(on)
        possible[s] = False
        for found, one in (
            (detour, shortest[:, s, None] + shortest[None, s]),
            (to_station, np.broadcast_to(to, least.shape)),
            (from_station, np.broadcast_to(on, least.shape)),
        ):
            np.minimum(found, np.where(possible, one, np.inf), out=found)
    return detour, to_station, from_station
