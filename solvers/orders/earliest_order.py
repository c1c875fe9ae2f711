"""Orders of targets with their earliest and latest times, by exceptions.

Of an order one knows when each target is done at the earliest with so many exceptions before it,
and when at the latest it must be for all that follow to be done by a deadline, with so many
exceptions after it. Whether a target fits in between two others, and how much time is left then,
is answered without looking at the others (Savelsbergh, Annals of Operations Research 4, 1985, for
times that are constant).
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from adr_opt.kernels.core.compile import inlined, kernel

from .quickest_legs import EXCEPTION, USUAL, arrives, has_leg, leaves

MISSING = -2
"""Place of a target that is not visited; that of the start is −1."""


class EarliestOrder(NamedTuple):
    """An order and its times.

    Attributes
    ----------
    order : (targets,) int64
        All targets: those visited in order, then the others.
    place : (bodies,) int64
        Index of each visited target in the order, −1 of the start, and :data:`MISSING`.
    early : (bodies, exceptions + 1) float64
        Earliest end at each body with that many exceptions at most [s].
    late : (bodies, exceptions + 1) float64
        Latest end there for all that follow to be done by the deadline, with that many exceptions
        at most [s].
    """

    order: np.ndarray
    place: np.ndarray
    early: np.ndarray
    late: np.ndarray


@kernel
def new_order(order, start, ready, shape):
    """Storage for an order and its times.

    Parameters
    ----------
    order : (targets,) int64
    start : int
        Body of the start.
    ready : float
        Since when the chaser is free there [s].
    shape : (bodies, exceptions + 1)
    """
    made = EarliestOrder(
        order.copy(), np.full(shape[0], MISSING), np.full(shape, np.inf), np.full(shape, -np.inf)
    )
    made.place[start] = -1
    for used in range(shape[1]):
        made.early[start, used] = ready
    return made


@kernel
def number(course, length):
    """Write the places of an order's first targets."""
    for p in range(course.order.size):
        course.place[course.order[p]] = p if p < length else MISSING


@kernel
def copy_order(source, destination):
    """Copy an order and its times."""
    for p in range(source.order.size):
        destination.order[p] = source.order[p]
    for body in range(source.place.size):
        destination.place[body] = source.place[body]
        for used in range(source.early.shape[1]):
            destination.early[body, used] = source.early[body, used]
            destination.late[body, used] = source.late[body, used]


@inlined
def body_before(order, start, position):
    """Body before a position of an order."""
    return np.int64(start) if position == 0 else order[position - 1]


@inlined
def forth(legs, i, j, early, out):
    """Earliest ends at a body, from those at another."""
    known = math.inf
    for used in range(legs.exceptions + 1):
        if used == 0 or early[used] < early[used - 1]:
            known = min(known, arrives(legs, USUAL, i, j, early[used]))
        if used == 1 or (used > 1 and early[used - 1] < early[used - 2]):
            known = min(known, arrives(legs, EXCEPTION, i, j, early[used - 1]))
        out[used] = known


@inlined
def back(legs, i, j, late, out):
    """Latest ends at a body, from those at the next one."""
    known = -math.inf
    for used in range(legs.exceptions + 1):
        if used == 0 or late[used] > late[used - 1]:
            known = max(known, leaves(legs, USUAL, i, j, late[used]))
        if used == 1 or (used > 1 and late[used - 1] > late[used - 2]):
            known = max(known, leaves(legs, EXCEPTION, i, j, late[used - 1]))
        out[used] = known


@inlined
def slack(legs, early, late):
    """Most time left between earliest and latest times; below 0 if a deadline is missed [s]."""
    most = -math.inf
    for used in range(legs.exceptions + 1):
        most = max(most, late[legs.exceptions - used] - early[used])
    return most


@inlined
def _taken_over(scratch, row):
    """Write times; returns whether they were the same."""
    same = True
    for used in range(scratch.size):
        same = same and scratch[used] == row[used]
        row[used] = scratch[used]
    return same


@kernel
def time_forth(legs, course, start, length, first, settled, scratch):
    """Earliest times from a position on, to where they are as before from ``settled`` on."""
    for p in range(first, length):
        i, j = body_before(course.order, start, p), course.order[p]
        forth(legs, i, j, course.early[i], scratch)
        if _taken_over(scratch, course.early[j]) and p >= settled:
            break


@kernel
def time_back(legs, course, start, length, last, settled, deadline, scratch):
    """Latest times of the bodies before positions, from ``last`` down.

    To where they are as before at ``settled`` or below.
    """
    for p in range(last, -1, -1):
        i = body_before(course.order, start, p)
        if p == length:
            for used in range(scratch.size):
                scratch[used] = deadline
        else:
            j = course.order[p]
            back(legs, i, j, course.late[j], scratch)
        if _taken_over(scratch, course.late[i]) and p <= settled:
            break


@kernel
def best_position(legs, course, start, length, j, deadline, passed_over, scratch, rng):  # noqa: PLR0913
    """Position with most time left after inserting a target; −1 if it fits nowhere."""
    best, most = -1, 0.0
    at, then = scratch[0], scratch[1]
    for line in range(legs.into_first[j], legs.into_first[j + 1]):
        i = legs.into[line]
        p = course.place[i] + 1
        if p < 0 or (p < length and not has_leg(legs, j, course.order[p])):
            continue
        if rng.random() < passed_over:
            continue
        forth(legs, i, j, course.early[i], at)
        if p == length:
            left = deadline - at[legs.exceptions]
        else:
            k = course.order[p]
            if at[legs.exceptions] >= course.late[k, legs.exceptions]:
                continue
            forth(legs, j, k, at, then)
            left = slack(legs, then, course.late[k])
        if left >= most:
            best, most = p, left
    return best


@kernel
def insert(course, source, position):
    """Move a target at a later position to a position; all before that are visited."""
    order, place = course.order, course.place
    j = order[source]
    for p in range(source, position, -1):
        order[p] = order[p - 1]
        if place[order[p]] != MISSING:
            place[order[p]] = p
    order[position], place[j] = j, position
