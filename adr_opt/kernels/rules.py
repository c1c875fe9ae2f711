"""The mission rules: which moves are legal, and what one move does (MODEL section 4).

The one place where they stand. Everything that plans, and the environment, asks these kernels;
only ``check`` states them a second time, on purpose.

A chaser's state is (body, time, delta_v_left, since_refuel, visited): where it is and since when
it is free, the ΔV left, how many targets it has serviced since the last refuelling, and which
targets are done. Search methods keep ``visited`` in their own form and ask :func:`fits`.

The slack of the model (:mod:`.constants`) is in the limits that :class:`Rules` holds and in the
next event, and nowhere else: what is left of a tank includes it, so that it is granted once a tank
and not once a leg, and every bound on moves under these rules holds with it.
"""

from typing import NamedTuple

import numpy as np

from . import timetable
from .compile import inlined, kernel
from .constants import STATION


class Rules(NamedTuple):
    """A mission as the kernels see it.

    Attributes
    ----------
    table : Table
    service : (bodies,) float64
        Time at each body after arrival: service, or refuelling at the station [s].
    prize : (bodies,) float64
        Prize of each target; 0 for the station.
    budget : float
        Full ΔV budget with the slack of the model, which is no limit to be met exactly [m/s].
    duration : float
        End of the mission, with the slack [s].
    """

    table: timetable.Table
    service: np.ndarray
    prize: np.ndarray
    budget: float
    duration: float


@inlined
def fits(rules, body, time, left, destination):
    """Whether a move fits ΔV and time, and what it costs.

    Says nothing of ``visited`` and ``since_refuel``, see :func:`may_go`.

    Parameters
    ----------
    rules : Rules
    body : int
        Where the chaser is.
    time : float
        Since when it is free [s].
    left : float
        ΔV left [m/s].
    destination : int

    Returns
    -------
    fits : bool
    delta_v : float
        [m/s], +inf where there is no transfer.
    end : float
        End of the service there [s].
    """
    delta_v, arrival = timetable.lookup(rules.table, body, destination, time)
    end = arrival + rules.service[destination]
    return delta_v <= left and end <= rules.duration, delta_v, end


@inlined
def may_go(body, since_refuel, visited, destination):
    """Whether the rules of the order allow a move: unvisited target, or a refuelling earned."""
    if destination == body:
        return False
    if destination == STATION:
        return since_refuel > 0
    return not visited[destination]


@inlined
def left_after(rules, left, delta_v, destination):
    """ΔV left at the end of a move: the full budget after refuelling [m/s]."""
    return rules.budget if destination == STATION else left - delta_v


@kernel
def legal_moves(rules, body, time, left, since_refuel, visited, mask):
    """All legal moves of a state.

    Parameters
    ----------
    visited : (bodies,) bool
    mask : (bodies,) bool
        Written: True where the move is legal, the station first.

    Returns
    -------
    count : int
    """
    count = 0
    for j in range(rules.service.size):
        legal = False
        if may_go(body, since_refuel, visited, j):
            legal = fits(rules, body, time, left, j)[0]
        mask[j] = legal
        count += legal
    return count


@kernel
def replay(rules, sequence, start, body, time, left, since_refuel, visited, ends, lefts):
    """Make the moves of ``sequence[start:]`` one after the other as long as they are legal.

    Parameters
    ----------
    sequence : (moves,) int
        Bodies in order, the station for refuelling.
    visited : (bodies,) bool
        Updated.
    ends, lefts : (moves,) float64
        Written: end of service [s] and ΔV left [m/s] after each move.

    Returns
    -------
    made : int
        Index of the first move that is not legal; the length of the sequence if all are.
    delta_v : float
        ΔV of the moves made [m/s].
    """
    total = 0.0
    for index in range(start, sequence.size):
        j = sequence[index]
        if not may_go(body, since_refuel, visited, j):
            return index, total
        legal, delta_v, end = fits(rules, body, time, left, j)
        if not legal:
            return index, total
        total += delta_v
        left = left_after(rules, left, delta_v, j)
        since_refuel = 0 if j == STATION else since_refuel + 1
        visited[j] = j != STATION
        body, time = j, end
        ends[index] = end
        lefts[index] = left
    return sequence.size, total


@kernel
def collected(rules, sequence):
    """Sum of the prizes of a sequence of bodies."""
    total = 0.0
    for j in sequence:
        total += rules.prize[j]
    return total
