"""Memories of relaxed tours: serviced targets near the present one are remembered.

The neighbourhoods of ng-routes (Baldacci, Mingozzi and Roberti, Operations Research 59(5), 2011).
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from adr_opt.kernels.core.compile import kernel
from adr_opt.kernels.legs.given import leg_of

from .tour import TimedTour


class NearMemories(NamedTuple):
    """Neighbourhoods, and transitions of memories from place to place.

    A memory is a number whose bit q says whether neighbour q of the place is done.

    Attributes
    ----------
    near : (targets + 1, size) int64
        Neighbours of each place, the start last; −1 for none.
    onward : (targets + 1, targets, 2^size) int32
        Memory at a destination, by origin, destination and memory; 2^size where it is done.
    """

    near: npt.NDArray[np.int64]
    onward: npt.NDArray[np.int32]


@kernel
def _onward(near, onward):
    """Fill the transitions of memories."""
    places, targets, count = onward.shape
    size = near.shape[1]
    place = np.full((places, places), -1, np.int64)
    for i in range(places):
        for q in range(size):
            if near[i, q] >= 0:
                place[i, near[i, q]] = q
    for i in range(places):
        for j in range(targets):
            for memory in range(count):
                if i == j or (place[i, j] >= 0 and memory >> place[i, j] & 1):
                    onward[i, j, memory] = count
                    continue
                after = 0
                for q in range(size):
                    if memory >> q & 1 and near[i, q] >= 0 and place[j, near[i, q]] >= 0:
                        after |= 1 << place[j, near[i, q]]
                if i < targets and place[j, i] >= 0:
                    after |= 1 << place[j, i]
                onward[i, j, memory] = after


@kernel
def _lengths(tour, time):
    """Length of the leg from place to place after a time, shape (targets + 1, targets) [s].

    Whatever the windows: of a target that closes soon the neighbours count as well.
    """
    lengths = np.empty((tour.targets + 1, tour.targets))
    for i in range(tour.targets + 1):
        for j in range(tour.targets):
            pair = i * tour.service.size + j
            leaves, lands = leg_of(
                tour.departure, tour.arrival, tour.first[pair], tour.first[pair + 1], time
            )
            lengths[i, j] = lands - leaves if lands < np.inf else 1e300
    return lengths


def memories_of(tour: TimedTour, size: int, until: float) -> NearMemories:
    """Memories of the nearest targets of each, by the mean time there and back in mid-tour."""
    targets = tour.targets
    lengths = _lengths(tour, 0.5 * (tour.ready + until))
    lengths[:targets] = lengths[:targets] + lengths[:targets].T
    near = np.full((targets + 1, size), -1, dtype=np.int64)
    for i in range(targets + 1):
        ranked = [j for j in np.argsort(lengths[i], kind="stable").tolist() if j != i]
        near[i, : min(size, len(ranked))] = ranked[:size]
    onward = np.empty((targets + 1, targets, 1 << size), dtype=np.int32)
    _onward(near, onward)
    return NearMemories(near, onward)
