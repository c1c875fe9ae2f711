"""Strings of an order: runs of consecutive stops that contain targets near one another.

J. Christiaens and G. Vanden Berghe, Transportation Science 54, 2020.
"""

from __future__ import annotations

import numpy as np

from adr_opt.kernels.core.compile import kernel

MOST_STRINGS, LONGEST_STRING = 3, 6
"""Maximum number of strings, and of targets in each."""


@kernel
def mark_strings(near, place, seed, length, rng, out):
    """Mark some strings of an order, each with a target near a given one.

    Parameters
    ----------
    near : (targets, ranks) int32
        Other targets, the nearest first.
    place : (targets,) int64
        Position of each target in the order; −1 if it is missing.
    seed : int
        The target near which they are.
    length : int
        Of the order.
    rng : numpy.random.Generator
    out : (length,) bool
        Changed.
    """
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


@kernel
def take_out(order, out, length):
    """Move the marked stops behind the rest of an order.

    Returns
    -------
    length, first, last : int
        Stops left; positions before ``first`` are as they were, and so are those from ``last`` on,
        counted anew.
    """
    taken = np.empty(length, np.int64)
    size, first, last, missing = 0, length, 0, 0
    for p in range(length):
        if out[p]:
            first, last = min(first, size), size
            taken[missing] = order[p]
            missing += 1
        else:
            order[size] = order[p]
            size += 1
    for m in range(missing):
        order[size + m] = taken[m]
    return size, min(first, size), last
