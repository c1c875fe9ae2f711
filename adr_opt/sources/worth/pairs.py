"""Sums over all pairs of objects, in blocks that threads share.

No matrix of pairs is kept: memory grows with the number of objects. Sums are added in the order of
blocks, so that they do not depend on the number of threads.
"""

from __future__ import annotations

from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from functools import cache
from itertools import pairwise
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from ...common.processors import usable_cores
from ...kernels.orbits.collisions import (
    CollidingObjects,
    CollisionTables,
    all_collisions,
    shared_worths,
    worths_with,
)
from ...problem.air import FLOAT

BLOCKS = 96
"""Number of blocks of about equally many pairs."""

INDICES = npt.NDArray[np.int64]

Show = Callable[[int, int], None]
"""Called with the number of finished blocks and the total."""


class Totals(NamedTuple):
    """Sums over all pairs.

    Attributes
    ----------
    sums : (object, 4) float64
        Fragment-years, encounters and catastrophic encounters a year, and the fragment-years of the
        worst pair.
    partners : (object,) int64
        The other object of that pair; −1 if an object meets no other one.
    cells : (cell, cell) float64
        Fragment-years of pairs of two cells, symmetric: a pair within a cell counts twice on the
        diagonal.
    """

    sums: FLOAT
    partners: INDICES
    cells: FLOAT


def threads(jobs: int) -> int:
    """Number of threads for a number of jobs, 0 for all cores."""
    return jobs or usable_cores()


def totals(
    objects: CollidingObjects, tables: CollisionTables, cells: int, jobs: int, show: Show
) -> Totals:
    """Sums over all pairs of objects that are sorted by perigee.

    Parameters
    ----------
    objects : CollidingObjects
    tables : CollisionTables
    cells : int
        Number of cells of the matrix of who meets whom, in either direction.
    jobs : int
        Number of threads; 0 for all cores.
    show : callable
        Told the blocks that are done, and their number.
    """
    count = len(objects.tilts)
    found = Totals(np.zeros((count, 4)), np.full(count, -1), np.zeros((cells, cells)))

    def block(ends: tuple[int, int]) -> Totals:
        own = Totals(np.zeros((count, 4)), np.full(count, -1), np.zeros((cells, cells)))
        all_collisions(objects, tables, *ends, *own)
        return own

    bounds = block_ends(count)
    with ThreadPoolExecutor(threads(jobs)) as pool:
        for done, part in enumerate(pool.map(block, bounds), 1):
            found.sums[:, :3] += part.sums[:, :3]
            worse = part.sums[:, 3] > found.sums[:, 3]
            found.sums[worse, 3] = part.sums[worse, 3]
            found.partners[worse] = part.partners[worse]
            found.cells[...] += part.cells
            show(done, len(bounds))
    return found._replace(cells=found.cells + found.cells.T)


def shared(objects: CollidingObjects, tables: CollisionTables, some: INDICES, jobs: int) -> FLOAT:
    """Fragment-years that each object of a set shares with the rest of the set.

    Parameters
    ----------
    objects : CollidingObjects
    tables : CollisionTables
    some : (n,) int64
        In ascending order.
    jobs : int
    """

    def block(ends: tuple[int, int]) -> FLOAT:
        own = np.zeros(len(some))
        shared_worths(objects, tables, some, *ends, own)
        return own

    with ThreadPoolExecutor(threads(jobs)) as pool:
        found: FLOAT = np.sum(list(pool.map(block, block_ends(len(some)))), axis=0)
    return found


def with_one(objects: CollidingObjects, tables: CollisionTables, one: int, some: INDICES) -> FLOAT:
    """Worth that one object shares with each of several others [fragment-years]."""
    found: FLOAT = worths_with(objects, tables, one, some)
    return found


def block_ends(count: int) -> list[tuple[int, int]]:
    """First and last object of blocks of about equally many pairs."""
    shares = 1.0 - np.sqrt(1.0 - np.arange(BLOCKS + 1) / BLOCKS)
    ends = np.unique(np.round(count * shares).astype(int)).tolist()
    return list(pairwise(ends))


STEP_DEG = 2
"""Step of inclinations of the table."""

POINTS = 2000
"""Points in latitude; the integrand has a logarithmic peak where inclinations nearly agree."""


@cache
def mean_speeds() -> FLOAT:
    """Mean relative speed of encounters over the speed of both orbits.

    Returns
    -------
    (tilt, tilt) float64
        By inclinations from 0° to 180°, :data:`STEP_DEG` apart. The mean is over encounters, not
        over time: fast ones count more.
    """
    # Half a step off the equator and the pole, where directions and latitudes degenerate.
    tilts = np.radians(np.clip(np.arange(0, 181, STEP_DEG), 0.25, 179.75))
    angles = 0.5 * np.pi * (np.arange(POINTS) + 0.5) / POINTS
    table = np.empty((len(tilts), len(tilts)))
    for row, tilt in enumerate(tilts):
        for column in range(row, len(tilts)):
            table[row, column] = table[column, row] = _mean(tilt, tilts[column], angles)
    table.setflags(write=False)
    return table


def _mean(tilt: float, other: float, angles: FLOAT) -> float:
    """Mean of the squared relative speed over that of the speed, over latitudes both reach."""
    low, high = sorted((np.sin(tilt), np.sin(other)))
    sines = low * np.sin(angles)
    cosines = 1.0 - sines**2
    density = 1.0 / np.sqrt(np.maximum(high**2 - sines**2, 1e-12))
    along = np.cos(tilt) * np.cos(other) / cosines
    across = np.sqrt(np.maximum(1.0 - np.cos(tilt) ** 2 / cosines, 0.0))
    across *= np.sqrt(np.maximum(1.0 - np.cos(other) ** 2 / cosines, 0.0))
    squares = [2.0 * np.maximum(1.0 - along + sign * across, 0.0) for sign in (1.0, -1.0)]
    first = sum(float(density @ square) for square in squares)
    second = sum(float(density @ np.sqrt(square)) for square in squares)
    return first / second
