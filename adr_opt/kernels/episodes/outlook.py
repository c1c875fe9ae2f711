"""Information about a body that needs no search: its neighbours and its cheapest departures.

Worked out once for a timetable and packed, so that an observation reads one cache line per target
instead of a row of the table. These are hints, not rules: times are rounded up to the body's steps
(:func:`adr_opt.kernels.tables.timetable.steps_begun`), costs to the units of
:data:`DELTA_V_UNIT_M_S` and :data:`HOUR_UNIT`, and angles between planes are those at t = 0,
although planes may drift.
"""

import math
from typing import NamedTuple

import numpy as np

from ..core.compile import kernel
from ..core.memory import write
from ..orbits.ephemeris import EPOCH_S, inclination_at, node_at, relative_node
from ..tables import stacked_timetables, timetable

HOME = 0
"""Index of the only station of an episode's mission, where the chaser starts."""

NEAR = 6
"""Number of nearest planes kept for each body."""

AHEAD = 10
"""Number of cheapest departures kept for each body and time: as many as fill a cache line."""

LINE = 32
"""Number of 16-bit integers in a cache line."""

NOBODY = 65535
"""Marks a missing destination, and a cost too large for 16 bits."""

DELTA_V_UNIT_M_S = 0.1
HOUR_UNIT = 1e-3

M_S_PER_HOUR = 450.0
"""ΔV equivalent to an hour where a single cost is needed [m/s]: about the ratio of the two weights
with which beam search compares partial plans."""


class Outlook(NamedTuple):
    """Neighbours and cheapest departures of every body.

    Attributes
    ----------
    angle : (bodies, bodies) float32
        Angle between the planes at t = 0 [rad].
    near : (bodies, NEAR) int16
        Targets whose planes are nearest at t = 0, nearest first; −1 where there are no more.
    near_angle : (bodies, NEAR) float32
        Their angles [rad].
    ahead : (bodies, times, LINE) uint16
        Of a chaser that is ready ``time`` steps of the body after the epoch: destination,
        ΔV [0.1 m/s] and time from ready to the end of service [0.001 h] of the :data:`AHEAD`
        transfers that are cheapest by hours + ΔV / :data:`M_S_PER_HOUR`, cheapest first.
    home : Column
        The timetable's entries of the way to the station.
    """

    angle: np.ndarray
    near: np.ndarray
    near_angle: np.ndarray
    ahead: np.ndarray
    home: stacked_timetables.PackedColumn


@kernel
def insert(cost, item, costs, items, kept):
    """Insert an item among the cheapest, as many as ``costs`` holds; returns their new number."""
    if kept == costs.size and cost >= costs[kept - 1]:
        return kept
    place = min(kept, costs.size - 1)
    while place > 0 and costs[place - 1] > cost:
        costs[place] = costs[place - 1]
        items[place] = items[place - 1]
        place -= 1
    costs[place] = cost
    items[place] = item
    return min(kept + 1, costs.size)


@kernel
def fill(bodies, table, service, outlook):
    """Fill the outlook of a timetable.

    Parameters
    ----------
    bodies : (bodies, columns) float64
        Rows of :data:`adr_opt.kernels.orbits.ephemeris.ORBIT_COLUMNS`.
    table : Table
    service : (bodies,) float64
        Time at each body after arrival [s].
    outlook : Outlook
        Written in place; its arrays may have room for more than the table.
    """
    count = bodies.shape[0]
    for i in range(count):
        one = bodies[i]
        for j in range(count):
            other = bodies[j]
            _, _, theta = relative_node(
                inclination_at(one, EPOCH_S),
                node_at(one, EPOCH_S),
                inclination_at(other, EPOCH_S),
                node_at(other, EPOCH_S),
            )
            outlook.angle[i, j] = theta
    stacked_timetables.fill_column(table, HOME, outlook.home)
    costs, items = np.empty(NEAR), np.empty(NEAR, dtype=np.int64)
    best, who = np.empty(AHEAD), np.empty(AHEAD, dtype=np.int64)
    for i in range(count):
        kept = 0
        for j in range(count):
            if j != i and j != HOME:
                kept = insert(outlook.angle[i, j], j, costs, items, kept)
        outlook.near[i] = -1
        write(outlook.near[i], items[:kept])
        write(outlook.near_angle[i], costs[:kept])
        # Ready times are rounded up to a step. Whoever is ready before may have a better departure,
        # so that lines say what to look at first, and the table what it costs.
        for m in range(outlook.ahead.shape[1]):
            ready = timetable.after_steps(table, i, m)
            kept = 0
            for j in range(count):
                if j in (i, HOME):
                    continue
                delta_v, arrival = timetable.lookup(table, i, j, ready)
                if math.isfinite(delta_v):
                    hours = (arrival + service[j] - ready) / 3600.0
                    kept = insert(hours + delta_v / M_S_PER_HOUR, j, best, who, kept)
            outlook.ahead[i, m] = NOBODY
            for place in range(kept):
                j = who[place]
                delta_v, arrival = timetable.lookup(table, i, j, ready)
                hours = (arrival + service[j] - ready) / 3600.0
                outlook.ahead[i, m, 3 * place] = j
                outlook.ahead[i, m, 3 * place + 1] = min(round(delta_v / DELTA_V_UNIT_M_S), NOBODY)
                outlook.ahead[i, m, 3 * place + 2] = min(round(hours / HOUR_UNIT), NOBODY)
