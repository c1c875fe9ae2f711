"""Collisions of a year, drawn pair by pair from their rates (docs/scenarios.md)."""

import math

from ..core.compile import kernel
from ..core.memory import borrowed
from .collisions import outcome
from .keyed_draws import beginnings, joined, mixed


@kernel
def drawn_collisions(objects, tables, numbers, keys, first, last, sums, hits):
    """Rates and drawn collisions of some objects with all that follow them.

    Parameters
    ----------
    objects : CollidingObjects
    tables : CollisionTables
    numbers : (object,) int64
        Numbers of the objects, by which pairs are drawn.
    keys : (int, int, int)
        Seed, year and kind of draw.
    first, last : int
        Objects of the block, which ends before the last.
    sums : (3,) float64
        Increased: encounters and catastrophic ones a year, fragments that they are expected to
        make.
    hits : (n, 6) float64
        Set: places of both objects, the time within the year, radius [m], fragments, and 1 for a
        catastrophic collision.

    Returns
    -------
    int
        Number of collisions; those beyond the rows of ``hits`` are counted only.
    """
    objects, tables = borrowed(objects), borrowed(tables)
    one, other = beginnings(keys[0], keys[1], keys[2])
    found = 0
    for i in range(first, last):
        for j in range(i + 1, objects.tilts.size):
            if objects.shells[j, 0] >= objects.shells[i, 1]:
                break
            rate, radius, made, catastrophic = outcome(objects, tables, i, j)
            if rate == 0.0:
                continue
            sums[0] += rate
            sums[2] += rate * made
            if catastrophic:
                sums[1] += rate
            low, high = min(numbers[i], numbers[j]), max(numbers[i], numbers[j])
            drawn = joined(mixed(mixed(one, low), high), mixed(mixed(other, low), high))
            # The first of a Poisson process: its time is exponential.
            time = -math.log1p(-drawn) / rate
            if time < 1.0:
                if found < hits.shape[0]:
                    hits[found, 0], hits[found, 1] = i, j
                    hits[found, 2], hits[found, 3] = time, radius
                    hits[found, 4], hits[found, 5] = made, 1.0 if catastrophic else 0.0
                found += 1
    return found
