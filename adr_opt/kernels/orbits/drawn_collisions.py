"""Collisions of a year, drawn by pair, or by object and cloud (docs/scenarios.md)."""

import math
from typing import NamedTuple

import numpy as np

from ..core.compile import kernel
from ..core.memory import borrowed
from .collisions import outcome
from .encounters import encounter_rate
from .keyed_draws import beginnings, joined, mixed


@kernel
def drawn_collisions(objects, tables, numbers, keys, first, last, sums, hits):
    """Rates and drawn collisions of each object of a block with all objects after it.

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
            # Objects are in order of their lowest radius: no later one shares a shell either.
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


class HitKeys(NamedTuple):
    """Identities of objects and of fragments.

    Attributes
    ----------
    numbers : (object,) int64
        Numbers of the objects.
    counts : (ring,) float64
        Number of fragments in each ring.
    clouds : (ring,) int64
        Number of its cloud; rings of a cloud are together.
    """

    numbers: np.ndarray
    counts: np.ndarray
    clouds: np.ndarray


@kernel
def fragment_hits(objects, tables, of, keys, first, last, sums, hits):
    """Rates and drawn collisions of some objects with fragments.

    Parameters
    ----------
    objects : CollidingObjects
        Of objects, and behind them of fragments, one for each ring.
    tables : CollisionTables
    of : HitKeys
    keys : (int, int, int)
        Seed, year and kind of draw.
    first, last : int
        Objects of the block, which ends before the last.
    sums : (3,) float64
        Increased: encounters and catastrophic ones a year, fragments that they are expected to
        make.
    hits : (n, 6) float64
        Set: place of the object, number of the cloud, the time within the year, radius [m],
        fragments, and 1 for a catastrophic collision.

    Returns
    -------
    int
        Number of collisions; those beyond the rows of ``hits`` are counted only.
    """
    objects, tables = borrowed(objects), borrowed(tables)
    numbers, counts, clouds = of.numbers, of.counts, of.clouds
    one, other = beginnings(keys[0], keys[1], keys[2])
    found, rings = 0, counts.size
    for i in range(first, last):
        # Rates of a cloud, and their products with radii and fragments.
        rate, heavy_rate, radii, made, heavy_made = 0.0, 0.0, 0.0, 0.0, 0.0
        for ring in range(rings):
            j = numbers.size + ring
            each, radius, speed = encounter_rate(
                objects.shells, objects.tilts, objects.widths, tables.speeds, i, j
            )
            if each > 0.0:
                each *= counts[ring] * tables.year
                mass = objects.masses[j]
                if 0.5 * mass * speed**2 >= tables.threshold * objects.masses[i]:
                    heavy_rate += each
                    heavy_made += each * tables.fragments * (mass + objects.masses[i]) ** 0.75
                else:
                    made += each * tables.fragments * (mass * speed / 1000.0) ** 0.75
                rate += each
                radii += each * radius
            # The sum of Poisson processes is one, of the sum of their rates: one draw for a cloud.
            if ring + 1 < rings and clouds[ring + 1] == clouds[ring]:
                continue
            if rate > 0.0:
                sums[0] += rate
                sums[1] += heavy_rate
                sums[2] += made + heavy_made
                high = mixed(mixed(one, numbers[i]), clouds[ring])
                low = mixed(mixed(other, numbers[i]), clouds[ring])
                time = -math.log1p(-joined(high, low)) / rate
                if time < 1.0:
                    if found < hits.shape[0]:
                        hits[found, 0], hits[found, 1] = i, clouds[ring]
                        hits[found, 2], hits[found, 3] = time, radii / rate
                        # A further round of both hashes tells the kind of collision.
                        heavy = joined(mixed(high, 1), mixed(low, 1)) * rate < heavy_rate
                        if heavy:
                            hits[found, 4], hits[found, 5] = heavy_made / heavy_rate, 1.0
                        else:
                            hits[found, 4], hits[found, 5] = made / (rate - heavy_rate), 0.0
                    found += 1
            rate, heavy_rate, radii, made, heavy_made = 0.0, 0.0, 0.0, 0.0, 0.0
    return found
