"""Arrivals that matter to tours that end by a time.

A state of :mod:`.earliest` is alive if from it, as early as it is, a tour can be ended in time.
From the last level back, one knows for each state the latest ready time there, and
so for each way between which times a live state may be ready for it. Arrivals that are known only
roughly need be known better there, and nowhere else.
"""

from __future__ import annotations

import math

import numpy as np
import numpy.typing as npt

from adr_opt.kernels.core.compile import inlined, kernel

from .earliest import ONE, Arrivals, Found, _arrival, _place_of, room_for


@inlined
def _latest_ready(arrivals, kind, i, j, by):
    """Latest ready time for an arrival by a time, rounded up to a step."""
    line = arrivals.arrival[arrivals.row[kind, i, j]]
    low, high = 0, line.size
    while low < high:
        middle = (low + high) // 2
        if line[middle] <= by:
            low = middle + 1
        else:
            high = middle
    return min(low * arrivals.step, by)


@kernel
def _back(arrivals, states, table, filled, due_then, place_of, due, wanted):
    """Latest times of a level's states, from those of the next level; last useful time of ways."""
    every = (ONE << np.uint64(arrivals.near.size)) - ONE
    for state in range(states.here.size):
        due[state] = -math.inf
        left = every & ~states.done[state]
        here, used, time = states.here[state], states.used[state], states.time[state]
        for j in range(arrivals.near.size):
            bit = ONE << np.uint64(j)
            if not left & bit:
                continue
            for kind in range(2):
                arrival = _arrival(arrivals, kind, here, j, time)
                if arrival == math.inf:
                    continue
                place = _place_of(states.done[state] | bit, j, used + kind, table, filled)
                by = due_then[place_of[place]] if filled[place] else -math.inf
                if arrival > by:
                    continue
                ready = max(_latest_ready(arrivals, kind, here, j, by), time)
                due[state] = max(due[state], ready)
                row = arrivals.row[kind, here, j]
                for k in range(
                    int(time / arrivals.step),
                    min(int(by / arrivals.step) + 1, wanted.shape[1]),
                ):
                    wanted[row, k] = max(wanted[row, k], by)
    return due


def wanted_by(arrivals: Arrivals, found: Found, latest: float) -> npt.NDArray[np.float64]:
    """Last time at which arrivals matter to useful states, by ready time and by departure.

    Parameters
    ----------
    arrivals : Arrivals
    found : Found
        With all states up to ``latest``.
    latest : float
        When tours end at the latest.

    Returns
    -------
    (rows, times) float64
        As :attr:`.Arrivals.arrival`: arrivals that are later than this do not matter, however much
        later. Minus infinite without live states.
    """
    wanted = np.full(arrivals.arrival.shape, -np.inf)
    due = np.full(found.levels[-1].here.size, latest)
    for states, after in zip(found.levels[-2::-1], found.levels[:0:-1], strict=True):
        room = 1 << max(int(1.5 * after.here.size + 8).bit_length(), 4)
        filled = np.zeros(room, dtype=np.bool_)
        place_of = np.zeros(room, dtype=np.int64)
        table = room_for(room)
        _store(after, table, filled, place_of)
        empty = np.empty(states.here.size)
        due = _back(arrivals, states, table, filled, due, place_of, empty, wanted)
    return wanted


@kernel
def _store(states, table, filled, place_of):
    """Store states in a hash table, with the index of each."""
    for state in range(states.here.size):
        done, here, used = states.done[state], states.here[state], states.used[state]
        place = _place_of(done, here, used, table, filled)
        filled[place] = True
        table.done[place], table.here[place], table.used[place] = done, here, used
        place_of[place] = state
