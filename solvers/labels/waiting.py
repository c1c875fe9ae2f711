"""Undominated labels waiting at each body, compared sixteen at a time.

Whether one label dominates another one is asked billions of times. So each body's list keeps a few
integers of each label side by side: ΔV left, value and memory, rounded so that none that dominates
is overlooked. What they let through is compared exactly.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from adr_opt.kernels.core.compile import inlined, kernel
from adr_opt.kernels.rules import resources as resource_kernels
from adr_opt.kernels.rules.loads import Loads
from adr_opt.kernels.rules.resources import CountLimits, Resources
from adr_opt.mission.evidence import WORD

from ..networks import simd
from .row_cuts import CutTolls

FINE = 30
"""Extra bits of precision of labels over completion values."""

NOBODY = -1
"""ΔV key of an empty place, below that of any label."""


class Labels(NamedTuple):
    """Partial walks.

    Attributes
    ----------
    row, parent : (labels,) int32
        By which row the walk is ready, and which one it goes on from.
    value : (labels,) int64
        [fine units].
    final : (labels,) int64
        The same if the walk ends there, less what it then pays for time; the same array where time
        has no price.
    left : (labels,) float64
        [m/s].
    counts : (labels,) int64
        See :func:`adr_opt.kernels.rules.resources.counts_of`.
    came_from : (labels,) int16
        The body that it may not go back to at once, −1 for none.
    worth : (labels,) float64
        Worth of the targets serviced, where ΔV is paid for, or their number, where all sets of
        targets are told apart; else 0.
    memory : (labels, words) int64
        Bit j % 63 of word j // 63: may not go to target j; and after those of all bodies, one for
        each cut of which a row is serviced, see :mod:`.row_cuts`.
    """

    row: np.ndarray
    parent: np.ndarray
    value: np.ndarray
    final: np.ndarray
    left: np.ndarray
    counts: np.ndarray
    came_from: np.ndarray
    worth: np.ndarray
    memory: np.ndarray


def labels_room(size: int, words: int = 1, *, timed: bool = False) -> Labels:
    """Storage for labels with a number of memory words; ``timed`` if time has a price."""
    row, parent = np.empty(size, dtype=np.int32), np.empty(size, dtype=np.int32)
    came_from = np.empty(size, dtype=np.int16)
    left, worth = np.empty(size), np.empty(size)
    value, counts = np.empty(size, dtype=np.int64), np.empty(size, dtype=np.int64)
    memory = np.empty((size, words), dtype=np.int64)
    final = np.empty(size, dtype=np.int64) if timed else value
    return Labels(row, parent, value, final, left, counts, came_from, worth, memory)


def bytes_each() -> int:
    """Memory of a label with one memory word [bytes]."""
    return sum(array.nbytes for array in {id(each): each for each in labels_room(1)}.values())


class Candidate(NamedTuple):
    """A partial walk before it becomes a label, without its memory; as in :class:`Labels`.

    Its time is no matter: see :func:`resources_of`.
    """

    value: np.int64
    resources: Resources
    worth: float


class LabelTerms(NamedTuple):
    """Data that distinguish labels besides their values and memories.

    Attributes
    ----------
    loads : Loads or None
    limits : CountLimits
        As in :class:`adr_opt.kernels.rules.rules.Rules`.
    cuts : CutTolls or None
        What walks pay at a second row.
    """

    loads: Loads | None
    limits: CountLimits
    cuts: CutTolls | None


class Waiting(NamedTuple):
    """Labels waiting at each body.

    Attributes
    ----------
    size : (bodies,) int64
    bucket : (bodies,) int64
        Where the list was last gone through for labels that are too late.
    label : (bodies, capacity) int32
        −1 where one was dominated. The capacity is a multiple of the lanes.
    keys : (bodies·(2 + 2·words)·capacity,) int32
        Of each body ΔV left, value, and two parts of each word of memory.
    """

    size: np.ndarray
    bucket: np.ndarray
    label: np.ndarray
    keys: np.ndarray


def room(bodies: int, words: int, capacity: int) -> Waiting:
    """Empty lists."""
    keys = np.full(bodies * (2 + 2 * words) * capacity, NOBODY, dtype=np.int32)
    label = np.empty((bodies, capacity), dtype=np.int32)
    none = np.full(bodies, -1, dtype=np.int64)
    return Waiting(np.zeros(bodies, dtype=np.int64), none, label, keys)


def larger(waiting: Waiting, words: int) -> Waiting:
    """The same lists in twice the storage."""
    bodies, capacity = waiting.label.shape
    twice = room(bodies, words, 2 * capacity)
    twice.size[:], twice.bucket[:] = waiting.size, waiting.bucket
    twice.label[:, :capacity] = waiting.label
    shape = (bodies, 2 + 2 * words, -1)
    twice.keys.reshape(shape)[:, :, :capacity] = waiting.keys.reshape(shape)
    return twice


@inlined
def _key_of(left):
    """Order-preserving integer key of a non-negative number."""
    return np.float32(left).view(np.int32)


@inlined
def _part(memory, part):
    """Half of a memory word."""
    return np.int32(memory[part // 2] >> 32 * (part % 2))


@inlined
def resources_of(labels, label):
    """Resources of a label, with a time common to all that wait with it."""
    return resource_kernels.with_counts(0.0, labels.left[label], labels.counts[label])


@inlined
def candidate_of(labels, label):
    """A label as a candidate."""
    return Candidate(labels.value[label], resources_of(labels, label), labels.worth[label])


@inlined
def dominates(labels, one, other, memory, compared, terms):
    """Whether a label dominates a candidate: at least equal worth and resources, no more memory.

    Of the memory only the targets in ``compared`` count. Its worth has to be enough for the tolls
    that it alone owes, too.
    """
    if labels.value[one] < other.value or labels.worth[one] < other.worth:
        return False
    if not resource_kernels.dominates(
        resources_of(labels, one), other.resources, terms.loads, terms.limits
    ):
        return False
    beyond = 0
    for w in range(memory.size):
        beyond |= labels.memory[one, w] & ~memory[w] & compared[w]
    return beyond == 0 and _pays_tolls(labels, one, other, memory, terms.cuts)


@inlined
def _pays_tolls(labels, one, other, memory, cuts):
    """Whether a label's lead over a candidate suffices for the tolls that it alone owes."""
    if cuts is None:
        return True
    lead = labels.value[one] - other.value
    for w in range(memory.size):
        owed = labels.memory[one, w] & ~memory[w] & cuts.bits[w]
        while owed:
            lead -= cuts.toll[w * WORD + simd.lowest_bit(owed)]
            owed &= owed - 1
    return lead >= 0


@inlined
def lanes_that_may(keys, at, stride, left, value, memory, compared):
    """Bit mask of sixteen labels that may dominate another one.

    Parameters
    ----------
    keys : (…,) int32
    at, stride : int
        Where the first key of the first of them lies, and how far on the next ones.
    left, value, memory, compared
        Of the other one, as for :func:`dominates`.
    """
    hits = simd.at_least(simd.load(keys, at), simd.spread(_key_of(left)))
    hits &= simd.at_least(simd.load(keys, at + stride), simd.spread(value >> FINE))
    for part in range(2 * memory.size):
        kept = simd.load(keys, at + (2 + part) * stride)
        beyond = ~_part(memory, part) & _part(compared, part)
        hits &= simd.disjoint(kept, simd.spread(beyond))
    return hits


@inlined
def fill_lane(keys, at, stride, labels, label):
    """Write the keys of a label to a lane."""
    keys[at] = _key_of(labels.left[label])
    keys[at + stride] = labels.value[label] >> FINE
    for part in range(2 * labels.memory.shape[1]):
        keys[at + (2 + part) * stride] = _part(labels.memory[label], part)


@kernel
def is_dominated(waiting, labels, j, candidate, memory, compared, terms):
    """Whether a label waiting at body j dominates a candidate."""
    left, value = candidate.resources.left, candidate.value
    capacity = waiting.label.shape[1]
    base = j * (2 + 2 * memory.size) * capacity
    for k in range(0, waiting.size[j], simd.LANES):
        hits = lanes_that_may(waiting.keys, base + k, capacity, left, value, memory, compared)
        lane = 0
        while hits >> lane:
            if hits >> lane & 1 and dominates(
                labels, waiting.label[j, k + lane], candidate, memory, compared, terms
            ):
                return True
            lane += 1
    return False


@kernel
def _drop_dominated(waiting, labels, j, label, compared, terms):
    """Mark labels at body j that are dominated by a new label."""
    capacity = waiting.label.shape[1]
    memory = labels.memory[label]
    parts = 2 * memory.size
    base = j * (2 + parts) * capacity
    most_left = simd.spread(_key_of(labels.left[label]))
    most_value = simd.spread(labels.value[label] >> FINE)
    for k in range(0, waiting.size[j], simd.LANES):
        hits = simd.at_least(most_left, simd.load(waiting.keys, base + k))
        hits &= simd.at_least(most_value, simd.load(waiting.keys, base + capacity + k))
        for part in range(parts):
            kept = simd.load(waiting.keys, base + (2 + part) * capacity + k)
            least = _part(memory, part) & _part(compared, part)
            hits &= simd.covers(kept, simd.spread(least))
        lane = 0
        while hits >> lane:
            if hits >> lane & 1 and k + lane < waiting.size[j]:
                other = waiting.label[j, k + lane]
                if other >= 0 and dominates(
                    labels,
                    label,
                    candidate_of(labels, other),
                    labels.memory[other],
                    compared,
                    terms,
                ):
                    waiting.label[j, k + lane] = -1
                    waiting.keys[base + k + lane] = NOBODY
            lane += 1


@kernel
def arrive(waiting, labels, j, label, compared, terms):
    """Add a label at body j unless dominated, and remove those that it dominates.

    Parameters
    ----------
    compared : (words,) int64
        Targets by whose memory labels are told apart there.
    terms : LabelTerms

    Returns
    -------
    possible : bool
        False if there is no room for it.
    """
    memory = labels.memory[label]
    candidate = candidate_of(labels, label)
    if is_dominated(waiting, labels, j, candidate, memory, compared, terms):
        return True
    at, capacity = waiting.size[j], waiting.label.shape[1]
    if at == capacity:
        return False
    _drop_dominated(waiting, labels, j, label, compared, terms)
    base = j * (2 + 2 * memory.size) * capacity + at
    waiting.label[j, at] = label
    fill_lane(waiting.keys, base, capacity, labels, label)
    waiting.size[j] = at + 1
    return True


@kernel
def keep(waiting, j, kept, parts):
    """Compact the list of body j: keep only the places marked in ``kept``."""
    capacity = waiting.label.shape[1]
    base = j * (2 + parts) * capacity
    size = 0
    for k in range(waiting.size[j]):
        if kept[k]:
            if size < k:
                waiting.label[j, size] = waiting.label[j, k]
                for field in range(2 + parts):
                    at = base + field * capacity
                    waiting.keys[at + size] = waiting.keys[at + k]
            size += 1
    for k in range(size, waiting.size[j]):
        waiting.keys[base + k] = NOBODY
    waiting.size[j] = size
