"""Slack induction by string removals (Christiaens and Vanden Berghe 2020), for one chaser.

An iteration takes some strings of targets out of the order, from where a target that is drawn would
have its neighbours, and puts all targets that are missing back in, one after the other, each where
most time is left afterwards; positions are passed over at random now and then. Simulated annealing
decides whether to go on with the result: the value of an order is what it collects, less what the
time until its end is worth. Whether a target fits in is asked of :mod:`.stairs`, which answers for
hundreds of connections of each pair and all ways to refuel.
"""

from __future__ import annotations

import math
from collections.abc import Iterable
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from adr_opt.kernels.compile import inlined, kernel
from adr_opt.kernels.constants import HOUR_S
from adr_opt.kernels.lists import rising
from adr_opt.kernels.memory import borrowed, write
from adr_opt.mission import Mission
from adr_opt.stop import Stop

from ..halting import halted_by
from . import stairs as staircases
from .beams import TIME_VALUE_M_S_PER_H
from .lines import Lines, lines_of
from .stairs import STRAIGHT, Desk, Stairs

LONGEST_STRING = 6
MOST_STRINGS = 3

PASSED_OVER = 0.03
"""Probability that a position is not looked at."""

HOT, COLD = 0.3, 0.01
"""Temperatures of the annealing, in mean prizes."""


class Course(NamedTuple):
    """An order of targets, and how far it can be flown from both ends; places are bodies.

    Attributes
    ----------
    order : (targets,) int64
        All targets: those visited in order, then the others.
    came, suffices : Stairs
    """

    order: np.ndarray
    came: Stairs
    suffices: Stairs


@inlined
def _before(rules, order, position):
    """The body before a position of an order."""
    return np.int64(rules.start) if position == 0 else order[position - 1]


@kernel
def _time(rules, lines, course, length, first, desk):
    """Stairs forwards from a position on; whether all targets can be reached.

    Only those that are early enough for the rest: the stairs backwards are right.
    """
    order, came, suffices = course.order, course.came, course.suffices
    for p in range(first, length):
        i, j = _before(rules, order, p), order[p]
        latest = suffices.time[j, 0]
        size = staircases.forwards(rules, lines, i, j, p > 0, came, i, latest, desk, came, j)
        if size == 0:
            return False
    return True


@kernel
def _time_back(rules, lines, course, length, last, settled, desk, trial):
    """Stairs backwards from a position on; whether all of them suffice.

    From the position ``settled`` down the stairs are right if those behind have not changed.
    """
    order, suffices = course.order, course.suffices
    for p in range(last, -1, -1):
        j = order[p]
        if p == length - 1:
            size = staircases.finish(rules, lines, j, rules.ready, desk, trial, 0)
        else:
            size = staircases.backwards(
                rules, lines, j, order[p + 1], True, suffices, order[p + 1], rules.ready,
                desk, trial, 0,
            )  # fmt: skip
        if size == 0:
            return False
        if staircases.take(trial, 0, suffices, j) and p <= settled:
            break
    return True


@kernel
def _copy(source, destination, bodies):
    """Copy a course, its stairs at all bodies."""
    write(destination.order, source.order)
    for side in range(2):
        one, other = source.came, destination.came
        if side == 1:
            one, other = source.suffices, destination.suffices
        for body in range(bodies):
            staircases.take(one, body, other, body)


@kernel
def _ruin(order, length, near, rng):
    """Take strings of targets out of an order.

    Returns
    -------
    length, first, last : int
        Targets left; positions before ``first`` are as they were, and so are those from ``last``
        on, counted anew.
    """
    targets = order.size
    place = np.empty(near.shape[0], np.int64)
    for p in range(near.shape[0]):
        place[p] = -1
    for p in range(length):
        place[order[p]] = p
    out = np.zeros(length, np.bool_)
    seed = order[rng.integers(0, length)]
    if length < targets and rng.random() < 0.5:
        seed = order[rng.integers(length, targets)]
    wanted = rng.integers(1, MOST_STRINGS + 1)
    longest = rng.integers(1, LONGEST_STRING + 1)
    for rank in range(near.shape[1]):
        p = place[near[seed, rank]]
        if wanted == 0:
            break
        if p < 0 or out[p]:
            continue
        size = min(rng.integers(1, longest + 1), length)
        begin = min(max(p - rng.integers(0, size), 0), length - size)
        for q in range(begin, begin + size):
            out[q] = True
        wanted -= 1
    kept = np.empty(targets, np.int64)
    size, first, last, taken = 0, length, 0, 0
    for p in range(length):
        if out[p]:
            first = min(first, p)
            last = size
            taken += 1
        else:
            kept[size] = order[p]
            size += 1
    missing = size
    for p in range(length):
        if out[p]:
            kept[missing] = order[p]
            missing += 1
    for p in range(length):
        order[p] = kept[p]
    return size, min(first, size), last


@kernel
def _insert(order, source, position):
    """Move the target at a later place to a position."""
    j = order[source]
    for p in range(source, position, -1):
        order[p] = order[p - 1]
    order[position] = j


@kernel
def _best_position(rules, lines, course, length, j, desk, trial, rng):
    """Where most time is left once a target is put in; −1 if it fits in nowhere."""
    lines, course, trial = borrowed(lines), borrowed(course), borrowed(trial)
    best, most = -1, -np.inf
    order, came, suffices = course.order, course.came, course.suffices
    for p in range(length + 1):
        if rng.random() < PASSED_OVER:
            continue
        i = _before(rules, order, p)
        latest = rules.duration
        if p < length:
            latest = suffices.time[order[p], 0]
        if came.time[i, 0] > latest:
            continue
        size = staircases.forwards(rules, lines, i, j, p > 0, came, i, latest, desk, trial, 0)
        if size == 0:
            continue
        earliest = trial.time[0, 0]
        if p == length:
            size = staircases.finish(rules, lines, j, earliest, desk, trial, 1)
        else:
            size = staircases.backwards(
                rules, lines, j, order[p], True, suffices, order[p], earliest, desk, trial, 1
            )
        if size == 0:
            continue
        left = staircases.slack(trial, 0, trial, 1)
        if left > most:
            best, most = p, left
    return best


@kernel
def _recreate(rules, lines, course, length, far, absent, desk, trial, rng):
    """Put missing targets back in, as far as they fit; returns how many are visited."""
    order = course.order
    missing = order.size - length
    keys = np.empty(missing)
    way = rng.random()
    for m in range(missing):
        j = order[length + m]
        keys[m] = rng.random()
        if way < 0.3:
            keys[m] -= absent[j]
        elif way < 0.6:
            keys[m] = -far[j] * (0.8 + 0.4 * keys[m])
    ranks = rising(keys, missing)
    turns = np.empty(missing, np.int64)
    for m in range(missing):
        turns[m] = order[length + ranks[m]]
    for j in turns:
        if length == rules.most_targets:
            break
        position = _best_position(rules, lines, course, length, j, desk, trial, rng)
        if position < 0:
            continue
        source = length
        while order[source] != j:
            source += 1
        _insert(order, source, position)
        length += 1
        _time_back(rules, lines, course, length, position, position - 1, desk, trial)
        _time(rules, lines, course, length, position, desk)
    return length


@kernel
def _new_course(order, bodies):
    return Course(order.copy(), staircases.new_stairs(bodies), staircases.new_stairs(bodies))


@kernel
def _prize(rules, course, length):
    """What an order collects."""
    prize = 0.0
    for p in range(length):
        prize += rules.prize[course.order[p]]
    return prize


@kernel
def _spare(course, length):
    """Time that the chaser might be later by, in the mean over all targets of an order [s]."""
    total = 0.0
    for p in range(length):
        j = course.order[p]
        total += staircases.slack(course.came, j, course.suffices, j)
    return total / max(length, 1)


@kernel
def _with_refuelling(rules, course, length):
    """The sequence of bodies that ends first, refuelling stops included."""
    order, came = course.order, course.came
    backwards = np.empty(2 * length, np.int64)
    moves, stair = 0, 0
    for p in range(length - 1, -1, -1):
        j = order[p]
        backwards[moves] = j
        moves += 1
        if came.via[j, stair] != STRAIGHT:
            backwards[moves] = came.via[j, stair]
            moves += 1
        stair = came.parent[j, stair]
    return backwards[:moves][::-1].copy()


@kernel
def anneal(rules, lines, order, length, near, far, absent, weights, iterations, rng, halt):
    """Improve an order.

    Parameters
    ----------
    rules : Rules
    lines : Lines
    order : (targets,) int64
        All targets: those visited in order, as far as they can be timed, then the others. Left as
        the last order accepted.
    length : int
        How many are visited.
    near : (bodies, targets) int64
        The targets by how near they are to each body, itself first.
    far : (bodies,) float64
        How far each target is from others.
    absent : (bodies,) float64
        Share of the iterations in which each target was missing, smoothed; updated.
    weights : tuple of float
        Worth of a second [prizes per s], temperature at the beginning and at the end [prizes].
    iterations : int
    rng : numpy.random.Generator
    halt : (1,) bool
        Once another thread sets it, the annealing ends.

    Returns
    -------
    best : (moves,) int64
        Bodies in the order of the best plan: most prize, then the earliest end.
    length : int
        Of the last order accepted.
    """
    rules, lines = borrowed(rules), borrowed(lines)
    worth, hot, cold = weights
    bodies = rules.service.size
    desk = staircases.new_desk(lines)
    trial = staircases.new_stairs(2)
    here, there = _new_course(order, bodies), _new_course(order, bodies)
    for course in (here, there):
        start, came = rules.start, course.came
        came.size[start], came.time[start, 0], came.tank[start, 0] = 1, rules.ready, rules.budget
    while not (
        _time_back(rules, lines, here, length, length - 1, -1, desk, trial)
        and _time(rules, lines, here, length, 0, desk)
    ):
        # A schedule over all connections may get farther than these lines do.
        length -= 1
    _copy(here, there, bodies)
    prize = _prize(rules, here, length)
    value = prize + worth * _spare(here, length)
    best, best_value = _with_refuelling(rules, here, length), value
    best_prize = prize
    for iteration in range(iterations):
        if halt[0]:
            break
        temperature = hot * (cold / hot) ** (iteration / iterations)
        size, first, last = length, 0, 0
        if length > 0:
            size, first, last = _ruin(there.order, length, near, rng)
        possible = _time_back(
            rules, lines, there, size, min(last, size) - 1, first - 1, desk, trial
        ) and _time(rules, lines, there, size, 0, desk)
        new_value = -np.inf
        if possible:
            size = _recreate(rules, lines, there, size, far, absent, desk, trial, rng)
            prize = _prize(rules, there, size)
            new_value = prize + worth * _spare(there, size)
        if new_value >= value + temperature * math.log(1.0 - rng.random()):
            length, value = size, new_value
            _copy(there, here, bodies)
            if prize > best_prize or (prize == best_prize and value > best_value):
                best, best_prize = _with_refuelling(rules, here, length), prize
                best_value = value
        else:
            _copy(here, there, bodies)
        for p in range(order.size):
            j = here.order[p]
            absent[j] = 0.99 * absent[j] + (0.01 if p >= length else 0.0)
    write(order, here.order)
    return best, length
