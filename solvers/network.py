"""The exact time-expanded network, in rows: what walks and labels move on.

All that matters of a time is which departure events lie ahead, so a *row* stands for the times
between one event of a body and the next one. The moves from a row are the next events of all
destinations: no waiting past an event. Services that would end after the mission are left out.
Times are exact; ΔV is also given in slots, rounded down.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from adr_opt.kernels import timetable as timetables
from adr_opt.kernels.compile import kernel
from adr_opt.mission import Mission

SLACK = 1e-9
"""Guard of roundings to slots, always in the optimistic direction [slots]."""


class Network(NamedTuple):
    """Legs as rows, body after body, each body's in order of departure.

    A row is a leg *and* the state of a chaser that is free at the body in time for it but not for
    the row before. One row more closes each body: free after its last leg.

    Attributes
    ----------
    start : (bodies + 1,) int64
        First row of each body.
    departure : (rows,) float64
        [s]; +inf in closing rows.
    destination : (rows,) int32
    landing : (rows,) int64
        Row of the destination at the end of service; −1 where the leg is not possible.
    cost : (rows,) int32
        ΔV in slots, rounded down.
    last : (rows,) int64
        The moves from a row are its own leg and the legs up to this row: the last of the next
        events of all destinations.
    block : (bodies,) int64
        Most rows from a row to its last one.
    """

    start: np.ndarray
    departure: np.ndarray
    destination: np.ndarray
    landing: np.ndarray
    cost: np.ndarray
    last: np.ndarray
    block: np.ndarray


@kernel
def _events_of(table, i):
    total = 0
    for j in range(table.first.shape[0]):
        total += timetables.events(table, i, j)
    return total


@kernel
def _legs_of(rules, i, departure, end, delta_v, destination):
    """All departure events of a body in time order; returns how many up to the last possible."""
    table = rules.table
    size = departure.size
    times = np.empty(size)
    targets = np.empty(size, dtype=np.int32)
    numbers = np.empty(size, dtype=np.int32)
    count = 0
    for j in range(rules.service.size):
        for m in range(timetables.events(table, i, j)):
            times[count] = timetables.departure_at(table, i, j, m)
            targets[count] = j
            numbers[count] = m
            count += 1
    order = np.argsort(times, kind="mergesort")
    used = 0
    for r in range(size):
        j = targets[order[r]]
        cost, arrival = timetables.entry_at(table, i, j, numbers[order[r]])
        departure[r] = times[order[r]]
        destination[r] = j
        delta_v[r] = cost
        end[r] = arrival + rules.service[j]
        if cost <= rules.budget and end[r] <= rules.duration:
            used = r + 1
    return used


@kernel
def _windows(destination, bodies, last):
    """Last row of the next events of all destinations, from every row of a body."""
    ahead = np.full(bodies, -1, dtype=np.int64)
    longest = 1
    for r in range(destination.size - 1, -1, -1):
        ahead[destination[r]] = r
        final = r
        for j in range(bodies):
            final = max(final, ahead[j])
        last[r] = final
        longest = max(longest, final - r + 1)
    return longest


@kernel
def _link(rules, slot, start, departure, destination, end, delta_v, landing, cost):
    """Landing rows and costs of all legs; returns the least time from departure to end."""
    shortest = rules.duration
    for i in range(start.size - 1):
        for r in range(start[i], start[i + 1] - 1):
            landing[r] = -1
            cost[r] = 0
            if delta_v[r] <= rules.budget and end[r] <= rules.duration:
                j = destination[r]
                ahead = departure[start[j] : start[j + 1] - 1]
                landing[r] = start[j] + np.searchsorted(ahead, timetables.earliest_taken(end[r]))
                cost[r] = max(0, math.floor(delta_v[r] / slot - SLACK))
                shortest = min(shortest, end[r] - departure[r])
        landing[start[i + 1] - 1] = -1
    return shortest


def build_network(mission: Mission, delta_v_slot_m_s: float) -> tuple[Network, np.ndarray, float]:
    """The network of a mission.

    Parameters
    ----------
    mission : Mission
    delta_v_slot_m_s : float
        Slot u of the ΔV axis [m/s].

    Returns
    -------
    network : Network
    delta_v : (rows,) float64
        Exact ΔV of the legs [m/s].
    shortest : float
        Least time from departure to the end of service of any leg [s].
    """
    rules = mission.rules
    bodies = rules.service.size
    departures: list[np.ndarray] = []
    ends: list[np.ndarray] = []
    costs: list[np.ndarray] = []
    destinations: list[np.ndarray] = []
    lasts: list[np.ndarray] = []
    never = np.array([math.inf])
    block = np.ones(bodies, dtype=np.int64)
    start = np.zeros(bodies + 1, dtype=np.int64)
    for i in range(bodies):
        size = _events_of(rules.table, i)
        departure, end, delta_v = np.empty(size), np.empty(size), np.empty(size)
        destination = np.empty(size, dtype=np.int32)
        used = _legs_of(rules, i, departure, end, delta_v, destination)
        last = np.zeros(used + 1, dtype=np.int64)
        # Over all events: beyond the last possible leg there is nothing that a window could miss.
        block[i] = _windows(destination[:used], bodies, last[:used])
        last[:used] += start[i]
        last[used] = start[i] + used
        start[i + 1] = start[i] + used + 1
        departures += [departure[:used], never]
        ends += [end[:used], never]
        costs += [delta_v[:used], never]
        destinations += [destination[:used], np.array([i], dtype=np.int32)]
        lasts.append(last)
    departure = np.concatenate(departures)
    destination = np.concatenate(destinations).astype(np.int32)
    landing = np.empty(departure.size, dtype=np.int64)
    cost = np.zeros(departure.size, dtype=np.int32)
    shortest = _link(
        rules,
        delta_v_slot_m_s,
        start,
        departure,
        destination,
        np.concatenate(ends),
        np.concatenate(costs),
        landing,
        cost,
    )
    delta_v = np.concatenate(costs)
    network = Network(start, departure, destination, landing, cost, np.concatenate(lasts), block)
    return network, delta_v, float(shortest)
