"""Is there a plan worth so much, where chasers may wait? Labels forwards in time, once a body.

As :mod:`solvers.ng_routes`, on the network with waiting arcs. A chaser that is at a body earlier
and richer, with the same memory or less, may wait and do all that the later one can. So labels of
one body are compared across *all* times, exactly: rows are gone through in order of departure, and
each body has a list of the labels that are there and ready, none dominated by another. A label
stays in the list, waiting, until its completion value says that it is too late.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from adr_opt.kernels.compile import kernel
from adr_opt.kernels.constants import STATION

from ..ng_routes import (
    CHUNK_DONE,
    EFFORT,
    EXHAUSTED,
    FINE,
    FULL,
    WORD,
    Labels,
    NgRoutes,
    remembers_no_more,
)
from .network import SLACK


class Search(NamedTuple):
    """What a search asks for, and what it may not forget.

    Attributes
    ----------
    best, second : (before + rows·width,) int32
        The completion values of the same multipliers; ``bits``, ``width``, ``top``, ``slot`` say
        how they are packed.
    gain : (bodies,) int64
        Prize less multiplier [fine units].
    need : int
        Value below which a walk is of no use [fine units].
    neighbourhood : (bodies, words) int64
        What walks remember at each body.
    budget : float
        [m/s].
    """

    best: np.ndarray
    second: np.ndarray
    bits: int
    width: int
    top: int
    slot: float
    gain: np.ndarray
    need: int
    neighbourhood: np.ndarray
    budget: float


@kernel
def _completion(search, row, left, came_from):
    """Most that a walk can still collect from a row on without going back at once [fine units]."""
    at = (row + 1) * search.width + min(int(left / search.slot + SLACK), search.top)
    packed = search.best[at]
    if came_from != STATION and packed & ((1 << search.bits) - 1) == came_from:
        packed = search.second[at]
    return np.int64(packed >> search.bits) << FINE


@kernel
def _dominates(labels, one, value, left, remembered):
    """Whether label ``one`` is worth as much, has as much left and remembers nothing more."""
    if labels.value[one] < value or labels.left[one] < left:
        return False
    return remembers_no_more(labels.memory, one, remembered)


@kernel
def _arrive(labels, pending, ready, row, i):
    """Move the labels that are ready by a row into the list of its body, unless dominated."""
    label = pending[row]
    pending[row] = -1
    while label >= 0:
        following = labels.following[label]
        other = ready[i]
        while other >= 0:
            if _dominates(
                labels, other, labels.value[label], labels.left[label], labels.memory[label]
            ):
                break
            other = labels.following[other]
        if other < 0:
            labels.following[label] = ready[i]
            ready[i] = label
        label = following


@kernel
def extend(network, body, order, search, labels, pending, ready, cursor, effort):
    """Extend labels row by row in order of departure, for a while.

    Parameters
    ----------
    network : WaitingNetwork
    body : (rows,) int32
        Body of each row.
    order : (rows,) int64
        Rows by departure.
    search : Search
    labels : Labels
    pending : (rows,) int64
        First of the labels that will be ready by a row, −1 for none; updated.
    ready : (bodies,) int64
        First of the labels that wait at a body; updated.
    cursor : (3,) int64
        Position in ``order``, number of labels, extensions tried; updated.
    effort : int
        Extensions to make.

    Returns
    -------
    state : int
        EXHAUSTED when all rows are done, CHUNK_DONE, or FULL when there is no room for labels.
    """
    words = search.neighbourhood.shape[1]
    remembered = np.empty(words, dtype=np.int64)
    target_effort = cursor[2] + effort
    while cursor[0] < order.size:
        row = order[cursor[0]]
        i = body[row]
        _arrive(labels, pending, ready, row, i)
        j = network.destination[row]
        label, before = ready[i], -1
        while label >= 0:
            following = labels.following[label]
            parent = labels.parent[label]
            came_from = body[labels.row[parent]] if parent >= 0 else STATION
            left, value = labels.left[label], labels.value[label]
            if value + _completion(search, row, left, came_from) < search.need:
                # Too late, now and at every later row.
                if before < 0:
                    ready[i] = following
                else:
                    labels.following[before] = following
                label = following
                continue
            before = label
            label, here = following, label
            if j != STATION and labels.memory[here, j // WORD] >> (j % WORD) & 1:
                continue
            for leg in range(network.first[row], network.first[row + 1]):
                if network.delta_v[leg] > left:
                    continue
                landing = network.landing[leg]
                rest = search.budget if j == STATION else left - network.delta_v[leg]
                worth = value + search.gain[j]
                if worth + _completion(search, landing, rest, i) < search.need:
                    continue
                cursor[2] += 1
                for w in range(words):
                    remembered[w] = labels.memory[here, w] & search.neighbourhood[j, w]
                if i != STATION:
                    remembered[i // WORD] |= 1 << (i % WORD)
                other = ready[j]
                while other >= 0 and not _dominates(labels, other, worth, rest, remembered):
                    other = labels.following[other]
                if other < 0:
                    other = pending[landing]
                    while other >= 0 and not _dominates(labels, other, worth, rest, remembered):
                        other = labels.following[other]
                if other >= 0:
                    continue
                count = cursor[1]
                if count == labels.row.size:
                    # The row is begun again later; what it has made already dominates its doubles.
                    return FULL
                labels.row[count], labels.parent[count] = landing, here
                labels.value[count], labels.left[count] = worth, rest
                for w in range(words):
                    labels.memory[count, w] = remembered[w]
                labels.following[count] = pending[landing]
                pending[landing] = count
                cursor[1] += 1
        cursor[0] += 1
        if cursor[2] >= target_effort:
            break
    return EXHAUSTED if cursor[0] >= order.size else CHUNK_DONE


class WaitingRoutes(NgRoutes):
    """As :class:`solvers.ng_routes.NgRoutes`, where chasers may wait."""

    def _extension(self, need: int) -> Callable[[Labels, np.ndarray], int]:
        bound = self._bound
        search = Search(
            bound.values.best, bound.values.second, bound.bits, bound.width, bound.top, bound.slot,
            self._gain, need, self.neighbourhood, bound.budget,
        )  # fmt: skip
        ready = np.full(bound.prize.size, -1, dtype=np.int64)

        def extend_labels(labels: Labels, cursor: np.ndarray) -> int:
            return extend(  # type: ignore[no-any-return]
                bound.network, self._body, self._order, search, labels, self._first, ready,
                cursor, EFFORT,
            )  # fmt: skip

        return extend_labels
