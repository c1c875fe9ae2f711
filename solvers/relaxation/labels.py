"""Is there a plan worth so much, where chasers may wait? Labels forwards in time, once a body.

As :mod:`solvers.ng_routes`, on the network with waiting arcs. A chaser that is at a body earlier
and richer, with the same memory or less, may wait and do all that the later one can. So labels of
one body are compared across *all* times, exactly: rows are gone through in order of departure, and
each body has a list of the labels that are there and ready, none dominated by another. A label
stays in the list, waiting, until its completion value says that it is too late.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from adr_opt.kernels.compile import kernel
from adr_opt.kernels.constants import STATION

from ..ng_routes import CHUNK_DONE, EFFORT, EXHAUSTED, FINE, FULL, WALKS, WORD, learn, path_of
from .network import SLACK
from .walks import WaitingBound


class Labels(NamedTuple):
    """Partial walks, in lists chained by ``following``.

    Attributes
    ----------
    row : (labels,) int64
        Body, for :func:`solvers.ng_routes.path_of`; ``parent`` is −1 for the first label.
    parent, following : (labels,) int64
    value : (labels,) int64
        [fine units].
    left : (labels,) float64
        [m/s].
    memory : (labels, words) int64
        Bit j % 63 of word j // 63: may not go to target j.
    """

    row: np.ndarray
    parent: np.ndarray
    following: np.ndarray
    value: np.ndarray
    left: np.ndarray
    memory: np.ndarray


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
    beyond = 0
    for w in range(remembered.size):
        beyond |= labels.memory[one, w] & ~remembered[w]
    return beyond == 0


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
            came_from = labels.row[parent] if parent >= 0 else STATION
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
                labels.row[count], labels.parent[count] = j, here
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


class WaitingRoutes:
    """Searches with the completion values of a bound, and the memory that grows meanwhile.

    Parameters
    ----------
    bound : WaitingBound
        Its network and values are used, and its values overwritten.

    Attributes
    ----------
    neighbourhood : (bodies, words) int64
        What walks remember at each body; kept from search to search.
    greatest_prize : float
    labels_made, searches : int
    """

    def __init__(self, bound: WaitingBound) -> None:
        self._bound = bound
        self.greatest_prize = bound.greatest_prize
        network = bound.network
        bodies = bound.prize.size
        self.neighbourhood = np.zeros((bodies, (bodies - 1) // WORD + 1), dtype=np.int64)
        self.labels_made = 0
        self.searches = 0
        self._body = np.repeat(np.arange(bodies, dtype=np.int32), np.diff(network.start))
        self._order = np.argsort(network.departure, kind="stable")
        self._labels = self._room(1 << 16)
        self._gain = np.zeros(bodies, dtype=np.int64)
        self._total = 0.0
        self._unit = bound.unit * 2.0**-FINE

    def _room(self, size: int) -> Labels:
        words = self.neighbourhood.shape[1]
        row, parent, following, value = (np.empty(size, dtype=np.int64) for _ in range(4))
        memory = np.empty((size, words), dtype=np.int64)
        return Labels(row, parent, following, value, np.empty(size), memory)

    def use(self, multipliers: np.ndarray) -> None:
        """Work out the completion values of some multipliers, for the searches to come."""
        bound = self._bound
        # What is left of rounding to units would count for every target that is left out.
        kept = np.where(multipliers < bound.unit, 0.0, multipliers)
        bound.evaluate(kept, keep=True)
        self._gain = np.ceil((bound.prize - kept) / self._unit).astype(np.int64)
        self._gain[STATION] = 0
        self._total = float(kept[1:].sum())

    def search(
        self, threshold: float, most_labels: int, enough: Callable[[], bool]
    ) -> tuple[bool, float, np.ndarray | None, int]:
        """One search for walks worth at least ``threshold``, and what was learnt from them.

        Parameters and returns are those of :meth:`solvers.ng_routes.NgRoutes.search`.
        """
        bound = self._bound
        network = bound.network
        # A little lower, so that no rounding of the sum of multipliers counts.
        need = math.ceil((threshold - self._total) / self._unit - 1e-3)
        search = Search(
            bound.values.best, bound.values.second, bound.bits, bound.width, bound.top, bound.slot,
            self._gain, need, self.neighbourhood, bound.budget,
        )  # fmt: skip
        pending = np.full(network.departure.size, -1, dtype=np.int64)
        ready = np.full(bound.prize.size, -1, dtype=np.int64)
        pending[network.start[STATION]] = 0
        labels = self._labels
        labels.row[0], labels.parent[0], labels.following[0] = STATION, -1, -1
        labels.value[0], labels.left[0], labels.memory[0] = 0, bound.budget, 0
        cursor = np.array([0, 1, 0], dtype=np.int64)
        self.searches += 1
        while True:
            labels = self._labels
            state = extend(
                network, self._body, self._order, search, labels, pending, ready, cursor, EFFORT
            )
            if state == EXHAUSTED:
                break
            if enough() or cursor[1] >= most_labels:
                self.labels_made += int(cursor[1])
                return False, math.inf, None, 0
            if state == FULL:
                self._labels = self._room(2 * labels.row.size)
                for new, old in zip(self._labels, labels, strict=True):
                    new[: cursor[1]] = old[: cursor[1]]
        count = int(cursor[1])
        self.labels_made += count
        best = int(labels.value[:count].max())
        if best < need:
            return True, -math.inf, None, 0
        bodies = np.arange(bound.prize.size, dtype=np.int32)
        path = np.empty(bound.most_legs + 1, dtype=np.int64)
        plan, grown = learn(labels, bodies, count, need, WALKS, self.neighbourhood, path)
        sequence = None
        if plan >= 0:
            sequence = path[: path_of(labels, bodies, plan, path)].copy()
        return True, best * self._unit + self._total, sequence, int(grown)
