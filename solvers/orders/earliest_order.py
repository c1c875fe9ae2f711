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


class EarliestOrder(NamedTuple):
    """An order and its times.

    Attributes
    ----------
    order : (targets,) int64
        All targets: those visited in order, then the others.
    early : (targets + 1, exceptions + 1) float64
        Earliest end at each position with that many exceptions at most; position 0 is the start
        [s].
    late : (targets + 1, exceptions + 1) float64
        Latest end there for all that follow to be done by the deadline, with that many exceptions
        at most [s].
    """

    order: np.ndarray
    early: np.ndarray
    late: np.ndarray


@kernel
def new_order(order, exceptions):
    """Storage for an order and its times."""
    shape = (order.size + 1, exceptions + 1)
    return EarliestOrder(order.copy(), np.full(shape, np.inf), np.full(shape, -np.inf))


@kernel
def copy_order(source, destination, length):
    """Copy an order, and its times at the visited targets."""
    for p in range(source.order.size):
        destination.order[p] = source.order[p]
    for p in range(length + 1):
        for used in range(source.early.shape[1]):
            destination.early[p, used] = source.early[p, used]
            destination.late[p, used] = source.late[p, used]


@inlined
def body_at(order, start, position):
    """Body at a position; 0 is the start."""
    return start if position == 0 else order[position - 1]


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


@kernel
def time_forth(legs, course, start, length, first, settled, scratch):
    """Earliest times from a position on, to where they are as they were beyond ``settled``."""
    for p in range(first, length):
        i, j = body_at(course.order, start, p), course.order[p]
        forth(legs, i, j, course.early[p], scratch)
        same = p >= settled
        for used in range(scratch.size):
            same = same and scratch[used] == course.early[p + 1, used]
            course.early[p + 1, used] = scratch[used]
        if same:
            break


@kernel
def time_back(legs, course, start, length, last, settled, deadline, scratch):
    """Latest times from a position down, to where they are as they were below ``settled``."""
    for p in range(last, -1, -1):
        if p == length:
            for used in range(scratch.size):
                scratch[used] = deadline
        else:
            i, j = body_at(course.order, start, p), course.order[p]
            back(legs, i, j, course.late[p + 1], scratch)
        same = p < settled
        for used in range(scratch.size):
            same = same and scratch[used] == course.late[p, used]
            course.late[p, used] = scratch[used]
        if same:
            break


@kernel
def best_position(legs, course, start, length, j, deadline, passed_over, scratch, rng):  # noqa: PLR0913
    """Position with most time left after inserting a target; −1 if it fits nowhere."""
    best, most = -1, 0.0
    at, then = scratch[0], scratch[1]
    for p in range(length + 1):
        i = body_at(course.order, start, p)
        if not has_leg(legs, i, j):
            continue
        if p < length and not has_leg(legs, j, course.order[p]):
            continue
        if rng.random() < passed_over:
            continue
        forth(legs, i, j, course.early[p], at)
        if p == length:
            left = deadline - at[legs.exceptions]
        elif at[legs.exceptions] >= course.late[p + 1, legs.exceptions]:
            continue
        else:
            forth(legs, j, course.order[p], at, then)
            left = slack(legs, then, course.late[p + 1])
        if left >= most:
            best, most = p, left
    return best


@kernel
def insert(order, source, position):
    """Move a target at a later position to a position."""
    j = order[source]
    for p in range(source, position, -1):
        order[p] = order[p - 1]
    order[position] = j
