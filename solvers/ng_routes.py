"""Is there a plan worth so much? Labels forwards in time, pruned by completion values.

The room shared by the Lagrangian bound and by proofs of optimality (MODEL section 7). A *label* is
a partial walk: row, exact ΔV left, value (prizes less multipliers), and a memory of targets that it
may not visit again. It is kept only if

    value + completion value + Σ π ≥ threshold ,

since no plan that begins with it can be worth more than the left side. Time and ΔV are exact here:
a row holds all that matters of a time, and ΔV is not rounded. All that is relaxed is the memory:
on the way to body j a walk forgets every target that is not in the neighbourhood of j, except the
body it comes from (ng-routes, Baldacci, Mingozzi & Roberti 2011). A label is dropped for another
one in the same row that is worth at least as much, has at least as much ΔV left and remembers
nothing more: whatever completes the first completes the other. So if the labels run out before the
threshold, no plan reaches it. If not, the best walks show which targets were visited twice; the
bodies in between learn to remember them, and the search begins again (decremental state space,
Righini & Salani 2008). A walk that repeats nothing is a plan, legal to the last digit.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from adr_opt.kernels.compile import kernel
from adr_opt.kernels.constants import STATION

from .network import SLACK
from .walks import WalkBound

WORD = 63
"""Targets remembered in one integer."""

FINE = 16
"""Labels count in units finer than those of the completion values by so many bits."""

EXHAUSTED, CHUNK_DONE, FULL = 0, 1, 2

EFFORT = 200_000
"""Extensions between two questions whether it is enough."""

WALKS = 64
"""Walks to learn from after a search."""


class Labels(NamedTuple):
    """Partial walks. Lists of a row are chained by ``following``.

    Attributes
    ----------
    row, parent, following : (labels,) int64
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


@kernel
def remembers_no_more(memory, k, remembered):
    """Whether label k remembers nothing beyond the given memory."""
    beyond = 0
    for w in range(remembered.size):
        beyond |= memory[k, w] & ~remembered[w]
    return beyond == 0


@kernel
def _remembers_all(memory, k, remembered):
    """Whether label k remembers all of the given memory."""
    missing = 0
    for w in range(remembered.size):
        missing |= remembered[w] & ~memory[k, w]
    return missing == 0


@kernel
def extend(
    network, delta_v, body, order, table_best, table_second, bits, width, top, slot, slack,
    gain, need, neighbourhood, budget, labels, first, cursor, effort,
):  # fmt: skip
    """Extend labels row by row in order of time, for a while.

    Parameters
    ----------
    network : Network
    delta_v : (rows,) float64
        Exact ΔV of the legs [m/s].
    body : (rows,) int32
        Origin of each row.
    order : (rows,) int64
        Rows by time.
    table_best, table_second, bits, width, top, slot, slack
        The completion values of the same multipliers.
    gain : (bodies,) int64
        Prize less multiplier [fine units].
    need : int
        Value below which a walk is of no use [fine units].
    neighbourhood : (bodies, words) int64
        What walks remember at each body.
    budget : float
        [m/s].
    labels : Labels
    first : (rows,) int64
        First label of each row, −1 for none; updated.
    cursor : (3,) int64
        Position in ``order``, number of labels, extensions tried; updated.
    effort : int
        Extensions to make.

    Returns
    -------
    state : int
        EXHAUSTED when all rows are done, CHUNK_DONE, or FULL when there is no room for labels.
    """
    mask = (1 << bits) - 1
    words = neighbourhood.shape[1]
    remembered = np.empty(words, dtype=np.int64)
    count = cursor[1]
    target_effort = cursor[2] + effort
    longest = 1
    for b in network.block:
        longest = max(longest, b)
    while cursor[0] < order.size:
        row = order[cursor[0]]
        label = first[row]
        i = body[row]
        while label >= 0:
            if count + longest > labels.row.size:
                # The row is begun again later; what it has made already dominates its doubles.
                cursor[1] = count
                return FULL
            for leg in range(row, network.last[row] + 1):
                landing = network.landing[leg]
                if landing < 0 or delta_v[leg] > labels.left[label]:
                    continue
                j = network.destination[leg]
                if j != STATION and labels.memory[label, j // WORD] >> (j % WORD) & 1:
                    continue
                left = budget if j == STATION else labels.left[label] - delta_v[leg]
                value = labels.value[label] + gain[j]
                at = (landing + 1) * width + min(int(left / slot + slack), top)
                packed = table_best[at]
                if i != STATION and packed & mask == i:
                    packed = table_second[at]
                if value + ((packed >> bits) << FINE) < need:
                    continue
                cursor[2] += 1
                for w in range(words):
                    remembered[w] = labels.memory[label, w] & neighbourhood[j, w]
                if i != STATION:
                    remembered[i // WORD] |= 1 << (i % WORD)
                other = first[landing]
                before = -1
                dominated = False
                while other >= 0:
                    following = labels.following[other]
                    if (
                        labels.value[other] >= value
                        and labels.left[other] >= left
                        and remembers_no_more(labels.memory, other, remembered)
                    ):
                        dominated = True
                        break
                    if (
                        labels.value[other] <= value
                        and labels.left[other] <= left
                        and _remembers_all(labels.memory, other, remembered)
                    ):
                        if before < 0:
                            first[landing] = following
                        else:
                            labels.following[before] = following
                    else:
                        before = other
                    other = following
                if dominated:
                    continue
                labels.row[count] = landing
                labels.parent[count] = label
                labels.value[count] = value
                labels.left[count] = left
                for w in range(words):
                    labels.memory[count, w] = remembered[w]
                labels.following[count] = first[landing]
                first[landing] = count
                count += 1
            label = labels.following[label]
        cursor[0] += 1
        if cursor[2] >= target_effort:
            break
    cursor[1] = count
    return EXHAUSTED if cursor[0] >= order.size else CHUNK_DONE


@kernel
def path_of(labels, body, label, path):
    """The bodies of a label's walk in order; returns how many."""
    length = 0
    while labels.parent[label] >= 0:
        path[length] = body[labels.row[label]]
        length += 1
        label = labels.parent[label]
    for a in range(length // 2):
        path[a], path[length - 1 - a] = path[length - 1 - a], path[a]
    return length


@kernel
def learn(labels, body, count, least, most_walks, neighbourhood, path):
    """Look at walks worth at least so much, and let the bodies inside their cycles remember.

    Parameters
    ----------
    least : int
        Walks worth less are not looked at [fine units].
    most_walks : int
        Walks to learn from, spread evenly over all of them: neighbours share their cycles.
    neighbourhood : (bodies, words) int64
        Updated.
    path : (legs,) int64
        Desk.

    Returns
    -------
    plan : int
        A label of the greatest value without any cycle; −1 if there is none.
    grown : int
        How many memories were added.
    """
    walks = 0
    for label in range(count):
        walks += labels.value[label] >= least
    stride = max(1, walks // most_walks)
    seen = np.empty(neighbourhood.shape[0], dtype=np.int64)
    plan, grown, number = -1, 0, 0
    for label in range(count):
        if labels.value[label] < least:
            continue
        number += 1
        length = path_of(labels, body, label, path)
        seen[:] = -1
        is_plan = True
        for a in range(length):
            j = path[a]
            if j == STATION:
                continue
            if seen[j] >= 0:
                is_plan = False
                if number % stride == 0:
                    bit = 1 << (j % WORD)
                    for b in range(seen[j] + 1, a):
                        if not neighbourhood[path[b], j // WORD] & bit:
                            neighbourhood[path[b], j // WORD] |= bit
                            grown += 1
            seen[j] = a
        if is_plan and (plan < 0 or labels.value[label] > labels.value[plan]):
            plan = label
    return plan, grown


class NgRoutes:
    """Searches with the completion values of a bound, and the memory that grows meanwhile.

    Parameters
    ----------
    bound : WalkBound
        Its network and values are used, and its values overwritten.

    Attributes
    ----------
    neighbourhood : (bodies, words) int64
        What walks remember at each body; kept from search to search.
    greatest_prize : float
    labels_made, searches : int
    """

    def __init__(self, bound: WalkBound) -> None:
        self._bound = bound
        self.greatest_prize = bound.greatest_prize
        network = bound.network
        bodies = bound.prize.size
        self.neighbourhood = np.zeros((bodies, (bodies - 1) // WORD + 1), dtype=np.int64)
        self.labels_made = 0
        self.searches = 0
        self._body = np.repeat(np.arange(bodies, dtype=np.int32), np.diff(network.start))
        self._order = np.argsort(network.departure, kind="stable")
        self._first = np.empty(network.departure.size, dtype=np.int64)  # label of each row
        self._labels = self._room(1 << 16)
        self._gain = np.zeros(bodies, dtype=np.int64)
        self._total = 0.0
        self._unit = bound.unit * 2.0**-FINE

    def _room(self, size: int) -> Labels:
        words = self.neighbourhood.shape[1]
        row, parent, following, value = (np.empty(size, dtype=np.int64) for _ in range(4))
        return Labels(
            row,
            parent,
            following,
            value,
            np.empty(size),
            np.empty((size, words), dtype=np.int64),
        )

    def use(self, multipliers: np.ndarray) -> None:
        """Work out the completion values of some multipliers, for the searches to come."""
        bound = self._bound
        # What is left of rounding to units would count for every target that is left out.
        kept = np.where(multipliers < bound.unit, 0.0, multipliers)
        bound.evaluate(kept, keep=True)
        self._gain = np.ceil((bound.prize - kept) / self._unit).astype(np.int64)
        self._gain[STATION] = 0
        self._total = float(kept[1:].sum())

    def _extension(self, need: int) -> Callable[[Labels, np.ndarray], int]:
        """What extends labels for a while, for one search: takes them and the cursor."""
        bound = self._bound

        def extend_labels(labels: Labels, cursor: np.ndarray) -> int:
            return extend(  # type: ignore[no-any-return]
                bound.network, bound.delta_v, self._body, self._order, bound.values.best,
                bound.values.second, bound.bits, bound.width, bound.top, bound.slot, SLACK,
                self._gain, need, self.neighbourhood, bound.budget, labels, self._first,
                cursor, EFFORT,
            )  # fmt: skip

        return extend_labels

    def search(
        self, threshold: float, most_labels: int, enough: Callable[[], bool]
    ) -> tuple[bool, float, np.ndarray | None, int]:
        """One search for walks worth at least ``threshold``, and what was learnt from them.

        Parameters
        ----------
        threshold : float
        most_labels : int
            Give up beyond so many.
        enough : callable
            Asked now and then whether to give up.

        Returns
        -------
        finished : bool
            False if it gave up: then nothing was proven.
        value : float
            If finished, no plan is worth more than the greater one of this and the threshold:
            the value of the best walk plus Σ π, −inf if there is none.
        plan : (moves,) int64 or None
            The best of the walks that visit no target twice: a plan.
        grown : int
            Memories added.
        """
        bound = self._bound
        # A little lower, so that no rounding of the sum of multipliers counts.
        need = math.ceil((threshold - self._total) / self._unit - 1e-3)
        self._first[:] = -1
        root = int(bound.network.start[STATION])
        self._first[root] = 0
        extend_labels = self._extension(need)
        labels = self._labels
        labels.row[0], labels.parent[0], labels.following[0] = root, -1, -1
        labels.value[0], labels.left[0], labels.memory[0] = 0, bound.budget, 0
        cursor = np.array([0, 1, 0], dtype=np.int64)
        self.searches += 1
        while True:
            labels = self._labels
            state = extend_labels(labels, cursor)
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
        path = np.empty(bound.most_legs + 1, dtype=np.int64)
        plan, grown = learn(labels, self._body, count, need, WALKS, self.neighbourhood, path)
        sequence = None
        if plan >= 0:
            sequence = path[: path_of(labels, self._body, plan, path)].copy()
        return True, best * self._unit + self._total, sequence, int(grown)
