"""Orders of targets under local changes, with Pareto fronts of their forward and backward flights.

The Pareto fronts of :mod:`.fronts` at every target of an order, from both ends. Those backwards are
whole; those forwards are the ones that are early enough for the rest, which are few.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from adr_opt.common.constants import SLACK_S
from adr_opt.kernels.core.compile import inlined, kernel
from adr_opt.kernels.core.events import earliest_taken
from adr_opt.kernels.core.memory import borrowed, write
from adr_opt.kernels.rules.rules import worth_at

from ..beams.levels import STRAIGHT
from . import fronts, fronts_backward, single_points
from .fronts import ParetoFront
from .reach import may_fit

PASSED_OVER = 0.15
"""Probability that a position is skipped."""


class BitOrder(NamedTuple):
    """An order of targets, with fronts from both ends; places are bodies.

    Attributes
    ----------
    order : (targets,) int64
        All targets: those visited in order, then the others.
    came, suffices : ParetoFront
    """

    order: np.ndarray
    came: ParetoFront
    suffices: ParetoFront


@inlined
def _before(rules, order, position):
    """The body before a position of an order."""
    return np.int64(rules.start) if position == 0 else order[position - 1]


@kernel
def time_forth(rules, connections, course, length, first, settled, workspace):
    """Forward fronts from a position on; returns whether all targets can be reached.

    Only those that are early enough for the rest: the fronts backwards are right. From the position
    ``settled`` up the fronts are right if those before have not changed.
    """
    connections, course, workspace = borrowed(connections), borrowed(course), borrowed(workspace)
    order, came, suffices = course.order, course.came, course.suffices
    for p in range(first, length):
        i, j = _before(rules, order, p), order[p]
        latest, size, end, left = suffices.time[j, 0], np.int64(-1), 0.0, 0.0
        if came.size[i] == 1:
            size, end, left = single_points.arrives(
                connections, i, j, p > 0, came.time[i, 0], came.tank[i, 0], latest
            )
        if size < 0:
            size = fronts.forwards(rules, connections, i, j, p > 0, came, latest, workspace)
            same = fronts.copy_front(workspace.trial, 0, came, j)
        else:
            same = single_points.set_single(came, j, end, left)
        if size == 0:
            return False
        if same and p >= settled:
            break
    return True


@kernel
def time_back(rules, connections, course, length, last, settled, workspace):
    """Backward fronts from a position on; returns whether all are feasible.

    From the position ``settled`` down the fronts are right if those behind have not changed.
    """
    connections, course, workspace = borrowed(connections), borrowed(course), borrowed(workspace)
    order, suffices = course.order, course.suffices
    for p in range(last, -1, -1):
        j = order[p]
        size, departure, tank = np.int64(-1), 0.0, 0.0
        if p == length - 1:
            size = fronts_backward.finish(rules, connections, j, rules.ready, workspace, 0)
            same = fronts.copy_front(workspace.trial, 0, suffices, j)
        else:
            k = order[p + 1]
            if suffices.size[k] == 1:
                size, departure, tank = single_points.leaves(
                    connections, j, k, suffices.time[k, 0], suffices.tank[k, 0], rules.ready
                )
            if size < 0:
                size = fronts_backward.backwards(
                    rules, connections, j, k, suffices, rules.ready, workspace, 0
                )
                same = fronts.copy_front(workspace.trial, 0, suffices, j)
            else:
                same = single_points.set_single(suffices, j, departure, tank)
        if size == 0:
            return False
        if same and p <= settled:
            break
    return True


@kernel
def copy_course(source, destination, bodies):
    """Copy an order with its fronts at all bodies."""
    write(destination.order, source.order)
    for side in range(2):
        one, other = source.came, destination.came
        if side == 1:
            one, other = source.suffices, destination.suffices
        for body in range(bodies):
            fronts.copy_front(one, body, other, body)


@kernel
def insert(order, source, position):
    """Move a target at a later position to a position."""
    j = order[source]
    for p in range(source, position, -1):
        order[p] = order[p - 1]
    order[position] = j


@inlined
def _plain_left(connections, course, i, j, k, refuels):
    """Result of :func:`left_with` where all fronts are evidently single points; NaN elsewhere."""
    came, suffices = course.came, course.suffices
    left = np.nan
    if came.size[i] == 1 and suffices.size[k] == 1:
        latest, needed = suffices.time[k, 0], suffices.tank[k, 0]
        size, end, tank = single_points.arrives(
            connections, i, j, refuels, came.time[i, 0], came.tank[i, 0], latest
        )
        if size == 0:
            left = -np.inf
        elif size > 0:
            size, departure, needed = single_points.leaves(connections, j, k, latest, needed, end)
            if size == 0 or (size > 0 and needed > tank):
                left = -np.inf
            elif size > 0:
                left = departure - end
    return left


@kernel
def left_with(rules, connections, course, length, j, p, latest, workspace):
    """Time left after inserting a target at a position [s]; −inf if it does not fit.

    ``latest`` is when the chaser has to be ready at the next target, or when the mission ends.
    """
    order, came, suffices = course.order, course.came, course.suffices
    i = _before(rules, order, p)
    trial = workspace.trial
    size = fronts.forwards(rules, connections, i, j, p > 0, came, latest, workspace)
    if size == 0:
        return -np.inf
    earliest = trial.time[0, 0]
    if p == length:
        size = fronts_backward.finish(rules, connections, j, earliest, workspace, 1)
    else:
        size = fronts_backward.backwards(
            rules, connections, j, order[p], suffices, earliest, workspace, 1
        )
    if size == 0:
        return -np.inf
    return fronts.slack(trial, 0, trial, 1)


@kernel
def find_room(rules, course, length, workspace):
    """Write the data on each position that :func:`best_position` needs."""
    course, workspace = borrowed(course), borrowed(workspace)
    for p in range(length + 1):
        i = _before(rules, course.order, p)
        latest = rules.duration if p == length else course.suffices.time[course.order[p], 0]
        workspace.before[p] = i
        # A little more than there is, so that no rounding counts.
        workspace.room[p] = latest - earliest_taken(course.came.time[i, 0]) + SLACK_S


@inlined
def has_room(reach, before, room, order, length, j):
    """Whether a position has room for a target; cheaper than a call, as most have none."""
    for p in range(length):
        if reach.into[j, before[p]] + reach.shortest[j, order[p]] <= room[p]:
            return True
    return reach.into[j, before[length]] <= room[length]


@kernel
def best_position(rules, connections, reach, course, length, j, workspace, rng):
    """Position with most time left after inserting a target; −1 if it fits nowhere.

    What :func:`find_room` writes has to be up to date.
    """
    rules, connections, reach = borrowed(rules), borrowed(connections), borrowed(reach)
    course, workspace = borrowed(course), borrowed(workspace)
    best, most = -1, -np.inf
    order, came, suffices = course.order, course.came, course.suffices
    before, room = workspace.before, workspace.room
    for p in range(length + 1):
        i, k = before[p], np.int64(-1)
        needed = reach.into[j, i]
        if p < length:
            k = order[p]
            needed += reach.shortest[j, k]
        # Most positions fail here.
        if needed > room[p] or rng.random() < PASSED_OVER:
            continue
        latest, need, left = rules.duration, 0.0, np.nan
        if p < length:
            left = _plain_left(connections, course, i, j, k, p > 0)
            latest, need = suffices.time[k, 0], suffices.tank[k, suffices.size[k] - 1]
        if left > most:
            best, most = p, left
        if not np.isnan(left):
            continue
        times, tanks = (came.time[i, 0], latest), (came.tank[i, came.size[i] - 1], need)
        if may_fit(rules, reach, i, j, k, times, tanks, p > 0):
            left = left_with(rules, connections, course, length, j, p, latest, workspace)
            if left > most:
                best, most = p, left
    return best


@kernel
def new_course(order, bodies):
    """Storage for a copy of an order, without fronts."""
    return BitOrder(order.copy(), fronts.new_front(bodies), fronts.new_front(bodies))


@kernel
def prize_of(rules, course, length):
    """Sum of prizes of an order, at its earliest ends where they fall."""
    prize = 0.0
    for p in range(length):
        j = course.order[p]
        prize += worth_at(rules, j, course.came.time[j, 0])
    return prize


@kernel
def spare(course, length):
    """Mean slack over all targets of an order [s]."""
    total = 0.0
    for p in range(length):
        j = course.order[p]
        total += fronts.slack(course.came, j, course.suffices, j)
    return total / max(length, 1)


@kernel
def with_refuelling(rules, course, length):
    """The sequence of bodies with the earliest end, refuelling stops included."""
    order, came = course.order, course.came
    backwards = np.empty(2 * length, np.int64)
    moves, point = 0, 0
    for p in range(length - 1, -1, -1):
        j = order[p]
        backwards[moves] = j
        moves += 1
        if came.via[j, point] != STRAIGHT:
            backwards[moves] = came.via[j, point]
            moves += 1
        point = came.parent[j, point]
    return backwards[:moves][::-1].copy()
