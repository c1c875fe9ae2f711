"""Simulated annealing over orders of targets (Kirkpatrick, Gelatt and Vecchi 1983)."""

from __future__ import annotations

import math

import numpy as np

from adr_opt.kernels.core.compile import kernel
from adr_opt.kernels.core.memory import borrowed, write
from adr_opt.kernels.rules.rules import worth_at

from ...orders.cooling import temperature
from ...orders.timed_order import time_order, with_refuelling

SWAP, REPLACE, RELOCATE, REVERSE, INSERT, REMOVE, SUBSTITUTE = range(7)
NAMES = ("swap", "replace", "relocate", "reverse", "insert", "remove", "substitute")

LONGEST_SEGMENT = 3
LONGEST_REVERSAL = 8


@kernel
def _shift(order, source, destination):
    """Move the target at ``source`` to ``destination``, shifting the others."""
    target = order[source]
    if source < destination:
        for p in range(source, destination):
            order[p] = order[p + 1]
    else:
        for p in range(source, destination, -1):
            order[p] = order[p - 1]
    order[destination] = target


@kernel
def apply_move(kind, order, length, rng):
    """Apply one random move of a kind.

    Parameters
    ----------
    kind : int
        One of the constants above.
    order : (targets,) int64
        Changed in place.
    length : int
        Number of targets visited.
    rng : numpy.random.Generator

    Returns
    -------
    first, behind : int
        The visited part differs at positions first, …, behind − 1 at most; behind = 0 where the
        move is not possible.
    length : int
    """
    targets = order.size
    if kind == SWAP and length >= 2:
        # exchange two visited targets
        a, b = rng.integers(0, length), rng.integers(0, length)
        order[a], order[b] = order[b], order[a]
        return min(a, b), max(a, b) + 1, length
    if kind == REPLACE and 0 < length < targets:
        # a target that is not visited takes the place of one that is
        a, b = rng.integers(0, length), rng.integers(length, targets)
        order[a], order[b] = order[b], order[a]
        return a, a + 1, length
    if kind == RELOCATE and length >= 2:
        # or-opt: move a segment of up to three targets elsewhere
        size = min(rng.integers(1, LONGEST_SEGMENT + 1), length - 1)
        a, b = rng.integers(0, length - size + 1), rng.integers(0, length - size + 1)
        for p in range(size):
            if a < b:
                _shift(order, a, b + size - 1)
            else:
                _shift(order, a + p, b + p)
        return min(a, b), max(a, b) + size, length
    if kind == REVERSE and length >= 2:
        # 2-opt: reverse a segment
        a = rng.integers(0, length - 1)
        b = min(length - 1, a + rng.integers(1, LONGEST_REVERSAL))
        first, last = a, b
        while a < b:
            order[a], order[b] = order[b], order[a]
            a += 1
            b -= 1
        return first, last + 1, length
    if kind == INSERT and length < targets:
        # visit one more
        b = rng.integers(0, length + 1)
        _shift(order, rng.integers(length, targets), b)
        return b, length + 1, length + 1
    if kind == REMOVE and length > 0:
        # visit one less
        a = rng.integers(0, length)
        _shift(order, a, length - 1)
        return a, length - 1, length - 1
    if kind == SUBSTITUTE and 0 < length < targets:
        # take a target out here, and put one that is not visited in elsewhere
        a, b = rng.integers(0, length), rng.integers(0, length)
        outside = rng.integers(length, targets)
        _shift(order, a, length - 1)
        order[length - 1], order[outside] = order[outside], order[length - 1]
        _shift(order, length - 1, b)
        return min(a, b), max(a, b) + 1, length
    return 0, 0, length


PATIENCE_S = 4000.0
"""Delay of the end beyond which re-timing stops once the order is unchanged: about a node."""


@kernel
def _copy_labels(source, destination, first, last):
    for position in range(first, last + 1):
        destination.size[position] = source.size[position]
        write(destination.time[position], source.time[position])
        write(destination.left[position], source.left[position])
        write(destination.parent[position], source.parent[position])
        write(destination.via[position], source.via[position])


@kernel
def _most(rules, order, length):
    """Sum of the prizes of an order, each the greatest."""
    total = 0.0
    for p in range(length):
        total += rules.prize[order[p]]
    return total


@kernel
def _collected(rules, order, length, labels):
    """Sum of the prizes of an order at its earliest ends."""
    total = 0.0
    for p in range(length):
        total += worth_at(rules, order[p], labels.time[p + 1, 0])
    return total


@kernel
def anneal(rules, order, length, labels, kept, weights, schedule, rng):
    """Anneal an order; its value is the sum of prizes less the value of the time used.

    Parameters
    ----------
    rules : Rules
    order : (targets,) int64
        Permutation of all targets; its first ``length`` are visited, as far as they can be timed.
        Left as the last order accepted.
    length : int
    labels, kept : OrderLabels
        Desks.
    weights : (kinds,) float64
        Cumulative probabilities of the moves, see :data:`NAMES`.
    schedule : solvers.orders.cooling.AnnealingSchedule
    rng : numpy.random.Generator

    Returns
    -------
    best : (moves,) int64
        Bodies in the order of the best plan: most prize, then the earliest end.
    prize : float
    length : int
        Of the last order accepted.
    accepted : int
    """
    rules = borrowed(rules)
    trial = order.copy()
    reference = np.empty(order.size + 1)
    end = time_order(rules, order, length, 0, labels, order.size, reference, np.inf)
    while length > 0 and end == np.inf:
        # A schedule over all connections may get farther than the choice of the timetable does.
        length -= 1
        end = time_order(rules, order, length, 0, labels, order.size, reference, np.inf)
    if length == 0:
        end = rules.ready
    _copy_labels(labels, kept, 0, length)
    write(reference, labels.time[: length + 1, 0])
    prize = _collected(rules, order, length, labels)
    best = with_refuelling(order, length, labels)
    best_prize, best_end = prize, end
    accepted = 0
    for iteration in range(schedule.iterations):
        allowed = temperature(schedule, iteration)
        draw = rng.random()
        kind = 0
        while kind < weights.size - 1 and draw > weights[kind]:
            kind += 1
        first, behind, new_length = apply_move(kind, trial, length, rng)
        if behind == 0:
            continue
        slack = -allowed * math.log(1.0 - rng.random())
        new_prize = prize
        if rules.falls is not None or new_length != length or kind in (REPLACE, SUBSTITUTE):
            new_prize = _most(rules, trial, new_length)
        # The latest end that is accepted.
        latest = end + (new_prize - prize + slack) / schedule.worth
        new_end = np.inf
        if new_length > rules.limits.targets:
            new_end = np.inf
        elif new_length == 0:
            new_end = rules.ready
        elif new_length == length and rules.falls is None:
            new_end = time_order(
                rules,
                trial,
                new_length,
                first,
                labels,
                behind,
                reference,
                latest - end + PATIENCE_S,
            )
        else:
            new_end = time_order(
                rules, trial, new_length, first, labels, order.size, reference, np.inf
            )
        if rules.falls is not None and new_end < np.inf:
            new_prize = _collected(rules, trial, new_length, labels)
            latest = end + (new_prize - prize + slack) / schedule.worth
        if new_end <= latest:
            accepted += 1
            write(order, trial)
            length, prize, end = new_length, new_prize, new_end
            _copy_labels(labels, kept, first + 1, length)
            write(reference, kept.time[: length + 1, 0])
            if prize > best_prize or (prize == best_prize and end < best_end):
                best_prize, best_end = prize, end
                best = with_refuelling(order, length, labels)
        else:
            write(trial, order)
            _copy_labels(kept, labels, first + 1, length)
    return best, best_prize, length, accepted
