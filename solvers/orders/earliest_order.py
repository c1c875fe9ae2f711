"""Orders of targets with their earliest and latest times.

Of an order one knows when each target is done at the earliest, and when at the latest it must be
for all that follow to be done by a deadline. Whether a target fits in between two others, and how
much time is left then, is answered without looking at the others (Savelsbergh, Annals of Operations
Research 4, 1985, for times that are constant).
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from adr_opt.kernels.core.compile import inlined, kernel

from .quickest_legs import arrives, has_leg, leaves

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
    early : (bodies,) float64
        Earliest end at each body [s].
    late : (bodies,) float64
        Latest end there for all that follow to be done by the deadline [s].
    """

    order: np.ndarray
    place: np.ndarray
    early: np.ndarray
    late: np.ndarray


@kernel
def new_order(order, start, ready, bodies):
    """Storage for an order and its times.

    Parameters
    ----------
    order : (targets,) int64
    start : int
        Body of the start.
    ready : float
        Since when the chaser is free there [s].
    bodies : int
    """
    made = EarliestOrder(
        order.copy(), np.full(bodies, MISSING), np.full(bodies, np.inf), np.full(bodies, -np.inf)
    )
    made.place[start] = -1
    made.early[start] = ready
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
        destination.early[body] = source.early[body]
        destination.late[body] = source.late[body]


@inlined
def body_before(order, start, position):
    """Body before a position of an order."""
    return np.int64(start) if position == 0 else order[position - 1]


@kernel
def time_forth(legs, course, start, length, first, settled):
    """Earliest times from a position on, to where they are as before from ``settled`` on."""
    for p in range(first, length):
        i, j = body_before(course.order, start, p), course.order[p]
        end = arrives(legs, i, j, course.early[i])
        same, course.early[j] = end == course.early[j], end
        if same and p >= settled:
            break


@kernel
def time_back(legs, course, start, length, last, settled, deadline):
    """Latest times of the bodies before positions, from ``last`` down.

    To where they are as before at ``settled`` or below.
    """
    for p in range(last, -1, -1):
        i = body_before(course.order, start, p)
        latest = deadline
        if p < length:
            latest = leaves(legs, i, course.order[p], course.late[course.order[p]])
        same, course.late[i] = latest == course.late[i], latest
        if same and p <= settled:
            break


@kernel
def best_position(legs, course, start, length, j, deadline, passed_over, rng):
    """Position with most time left after inserting a target; −1 if it fits nowhere."""
    best, most = -1, 0.0
    for line in range(legs.into_first[j], legs.into_first[j + 1]):
        i = legs.into[line]
        p = course.place[i] + 1
        if p < 0 or (p < length and not has_leg(legs, j, course.order[p])):
            continue
        if rng.random() < passed_over:
            continue
        end = arrives(legs, i, j, course.early[i])
        if p == length:
            left = deadline - end
        else:
            k = course.order[p]
            if end >= course.late[k]:
                continue
            left = course.late[k] - arrives(legs, j, k, end)
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
