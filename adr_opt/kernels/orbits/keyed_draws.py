"""Random numbers by key: the same key draws the same number, whatever else is drawn.

A study with removals and one without then share every event that both can have. Two hashes of 32
bits, each of multiplications and shifts that fit into signed 64-bit integers, make one number.
"""

import numpy as np

from ..core.compile import inlined, kernel

MASK = 0xFFFFFFFF

FACTOR = 0x45D9F3B
"""Odd factor of T. Mueller's integer hash, small enough for a product below 2⁶³."""

ROUND = 0x1E3779B9
"""Added in each round, so that zeros do not stay zero."""

SALTS = (0x3C6EF372, 0x2545F491)
"""Beginnings of the two hashes."""


@inlined
def mixed(state, key):
    """State of a hash after one more key, both at least 0."""
    value = ((state ^ (key & MASK)) + ROUND) & MASK
    value = (((value >> 16) ^ value) * FACTOR) & MASK
    value = (((value >> 16) ^ value) * FACTOR) & MASK
    return (value >> 16) ^ value


@inlined
def joined(high, low):
    """Number in (0, 1) of two hashes."""
    return (high + (low + 0.5) / 4294967296.0) / 4294967296.0


@kernel
def beginnings(seed, year, kind):
    """States of both hashes after the keys that many draws have in common."""
    one = mixed(mixed(mixed(SALTS[0], seed), year), kind)
    other = mixed(mixed(mixed(SALTS[1], seed), year), kind)
    return one, other


@kernel
def keyed_draws(seed, year, kind, some):
    """Uniform numbers in (0, 1), one for each object.

    Parameters
    ----------
    seed, year, kind : int
        At least 0, below 2³².
    some : (n,) int64
        Numbers of objects.

    Returns
    -------
    (n,) float64
    """
    one, other = beginnings(seed, year, kind)
    found = np.empty(some.size)
    for place in range(some.size):
        found[place] = joined(mixed(one, some[place]), mixed(other, some[place]))
    return found
