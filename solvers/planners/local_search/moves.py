"""Moves on an order of targets.

An order is a permutation of all targets; the first ``length`` of them are visited, the others are
not. A move changes a copy of it in place and says from where and up to where the visited part
differs, and how long that part is now. Every move leaves a permutation, so whatever it does, only
the timing decides whether a plan comes of it.
"""

from __future__ import annotations

from adr_opt.kernels.core.compile import kernel

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
