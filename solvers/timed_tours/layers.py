"""Layers of labels: earliest arrivals at a target after servicing a set of targets.

A layer holds all sets of as many targets. A label is dropped if a target left out of it can no
longer be reached in time, or if the relaxed rest of its tour ends too late.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from adr_opt.kernels.core.compile import inlined, kernel

from .relaxation import Relaxation
from .tour import TimedTour, reached

BITS = 63
"""Number of targets whose set fits a word."""


class Layer(NamedTuple):
    """Labels with equally many serviced targets.

    Attributes
    ----------
    done : (room, words) int64
        The targets that are done, as a set of :class:`Deadlines`.
    place : (room,) int8
    time : (room,) float64
        Since when the chaser is free there [s].
    bound : (room,) int32
        Lower bound on the end of the tour, since the start [units].
    rest : (room,) int64
        Multipliers of what is not done [units].
    parent : (room,) int32
        Label of the layer before.
    """

    done: npt.NDArray[np.int64]
    place: npt.NDArray[np.int8]
    time: npt.NDArray[np.float64]
    bound: npt.NDArray[np.int32]
    rest: npt.NDArray[np.int64]
    parent: npt.NDArray[np.int32]


class Deadlines(NamedTuple):
    """Deadlines for unserviced targets, by place, and the words in which sets are stored.

    Attributes
    ----------
    word, bit : (targets,) int64
        The word of a set in which a target is, and its bit there.
    time : (targets, targets) float64
        Latest times at a place for the others, in ascending order [s].
    missed : (targets, targets + 1, words) int64
        Targets whose times are before that of an index, as a set.
    """

    word: npt.NDArray[np.int64]
    bit: npt.NDArray[np.int64]
    time: npt.NDArray[np.float64]
    missed: npt.NDArray[np.int64]


def empty_layer(room: int, words: int) -> Layer:
    """A layer with room for labels."""
    return Layer(
        np.empty((room, words), np.int64),
        np.empty(room, np.int8),
        np.empty(room),
        np.empty(room, np.int32),
        np.empty(room, np.int64),
        np.empty(room, np.int32),
    )


def windows_of(latest: npt.NDArray[np.float64], bits: int = BITS) -> Deadlines:
    """Deadlines in order, from :func:`.tour.deadlines`; ``bits`` targets go into a word."""
    targets = latest.shape[0] - 1
    word, at = np.divmod(np.arange(targets), bits)
    bit, time = np.left_shift(1, at), np.full((targets, targets), np.inf)
    missed = np.zeros((targets, targets + 1, int(word.max()) + 1), dtype=np.int64)
    for place in range(targets):
        others = [j for j in range(targets) if j != place]
        order = [others[rank] for rank in np.argsort(latest[place, others], kind="stable")]
        time[place, : targets - 1] = latest[place, order]
        for rank, j in enumerate(order):
            missed[place, rank + 1] = missed[place, rank]
            missed[place, rank + 1, word[j]] |= bit[j]
        missed[place, targets] = missed[place, targets - 1]
    return Deadlines(word, bit, time, missed)


@inlined
def _slot_of(table, sets, places, done, place):
    """Slot of the label with a set and a place, or where it should be entered.

    Open addressing with linear probing: the table holds numbers of labels, −1 where it is empty,
    and has a power of two of slots. Sets are multiplied by odd constants (Knuth, The Art of
    Computer Programming 3, 6.4).
    """
    mask, mixed = table.size - 1, np.int64(place + 1) * 0x1E3779B97F4A7C15
    for word in range(done.size):
        mixed = (mixed + done[word]) * 0x5851F42D4C957F2D
    slot = (mixed ^ (mixed >> 29)) & mask
    while table[slot] >= 0:
        label = table[slot]
        same = places[label] == place
        for word in range(done.size):
            same = same and sets[label, word] == done[word]
        if same:
            break
        slot = (slot + 1) & mask
    return slot


@kernel
def reenter(table, layer, count):
    """Enter all labels of a layer into a larger table, which is empty."""
    for label in range(count):
        slot = _slot_of(table, layer.done, layer.place, layer.done[label], layer.place[label])
        table[slot] = label


@inlined
def _misses(windows, done, place, time):
    """Whether an unserviced target can no longer be reached in time."""
    low, high = 0, windows.time.shape[1]
    while low < high:
        middle = (low + high) // 2
        if windows.time[place, middle] < time:
            low = middle + 1
        else:
            high = middle
    missed = 0
    for word in range(done.size):
        missed |= windows.missed[place, low, word] & ~done[word]
    return missed != 0


@inlined
def _memory_of(near, windows, done, place):
    """The memory at a place for a set of serviced targets."""
    memory = 0
    for q in range(near.shape[1]):
        j = near[place, q]
        if j >= 0 and done[windows.word[j]] & windows.bit[j]:
            memory |= 1 << q
    return memory


@kernel
def extend(tour, relaxation, windows, most, before, after, table, cursor):
    """Extend labels by each target, until storage is full.

    Parameters
    ----------
    most : int
        Labels are dropped whose tours end later [units].
    before : Layer
        Those to extend.
    after : Layer
        Written.
    table : (2^n,) int32
        Numbers of its labels by set and place, −1 for none.
    cursor : (4,) int64
        Labels in ``after``, targets still to do there, the first label that is not extended yet
        and the one after the last; the first and the third are updated.
    """
    targets, left = tour.targets, cursor[1]
    steps, memories, bands, multipliers, values = relaxation
    room, count = after.place.size, cursor[0]
    label, extended = cursor[2], np.empty(before.done.shape[1], np.int64)
    while label < cursor[3] and count + targets <= room:
        here, time = np.int64(before.place[label]), before.time[label]
        for j in range(targets):
            if before.done[label, windows.word[j]] & windows.bit[j]:
                continue
            end = reached(tour, here, j, time)
            step = max(0, int((end - tour.ready) / steps.length - 1e-9)) if end < np.inf else -1
            if step < bands.low[left, j] or step > bands.high[left, j]:
                continue
            for word in range(extended.size):
                extended[word] = before.done[label, word]
            extended[windows.word[j]] |= windows.bit[j]
            if _misses(windows, extended, j, end):
                continue
            row = bands.begin[left, j] + step - bands.low[left, j]
            rest = before.rest[label] - multipliers[j]
            bound = values[row, _memory_of(memories.near, windows, extended, j)] - rest
            if bound > most:
                continue
            slot = _slot_of(table, after.done, after.place, extended, j)
            known = np.int64(table[slot])
            if known < 0:
                known = count
                table[slot] = count
                for word in range(extended.size):
                    after.done[count, word] = extended[word]
                after.place[count], after.rest[count] = j, rest
                after.time[count] = np.inf
                count += 1
            if end < after.time[known]:
                after.time[known], after.bound[known] = end, bound
                after.parent[known] = label
        label += 1
    cursor[2], cursor[0] = label, count


@kernel
def best_end(tour, layer, count):
    """The last layer's label whose tour ends first, and its end [s]; +inf if none ends in time."""
    best, found = np.inf, -1
    for label in range(count):
        end = reached(tour, np.int64(layer.place[label]), tour.targets + 1, layer.time[label])
        if end < best:
            best, found = end, label
    return found, best


class Outcome(NamedTuple):
    """The outcome of a search.

    Attributes
    ----------
    order : (targets,) int64 or None
        The best tour found.
    end_s : float
        Its end, +inf without one.
    whole : bool
        Whether no label was left out, so that no tour ends earlier, or by the end asked for.
    labels : int
    """

    order: npt.NDArray[np.int64] | None
    end_s: float
    whole: bool
    labels: int


FIRST_ROOM, CHUNK = 1 << 14, 20_000
"""Initial storage of a layer, and number of labels extended between checks of the clock."""


def _at(layer: Layer, labels: npt.NDArray[np.int64]) -> Layer:
    """The labels of a layer at some indices."""
    return Layer(
        layer.done[labels],
        layer.place[labels],
        layer.time[labels],
        layer.bound[labels],
        layer.rest[labels],
        layer.parent[labels],
    )


class LayerSearch:
    """Search of a tour layer by layer, of all labels or the most promising ones.

    Parameters
    ----------
    tour : TimedTour
    relaxation : Relaxation
    windows : Deadlines
    over : callable
        Whether the time is over.
    """

    def __init__(
        self, tour: TimedTour, relaxation: Relaxation, windows: Deadlines, over: Callable[[], bool]
    ) -> None:
        self._tour, self._relaxation, self._windows = tour, relaxation, windows
        self._over, self._words = over, windows.missed.shape[2]

    def search(self, most: int, room: int, width: int | None = None) -> Outcome:
        """Search for the tour that ends first, of those that end by a number of units.

        Parameters
        ----------
        most : int
            Since the start [units].
        room : int
            Maximum number of labels in a layer; nothing is found beyond it.
        width : int, optional
            Number of labels of each layer that go on, those of least bound; all by default.
        """
        tour, targets = self._tour, self._tour.targets
        layer = empty_layer(1, self._words)
        layer.done[0], layer.place[0], layer.time[0] = 0, targets, tour.ready
        layer.rest[0] = self._relaxation.multipliers.sum()
        count, total, whole = 1, 0, True
        history: list[tuple[npt.NDArray[np.int8], npt.NDArray[np.int32]]] = []
        for left in range(targets - 1, -1, -1):
            made = self._extended(layer, count, left, most, room)
            if made is None:
                return Outcome(None, np.inf, False, total)
            layer, count = made
            if width is not None and count > width:
                kept = np.argpartition(layer.bound[:count], width)[:width]
                layer, count, whole = _at(layer, kept), width, False
            else:
                layer = _at(layer, np.arange(count))
            history.append((layer.place, layer.parent))
            total += count
            if not count:
                return Outcome(None, np.inf, whole, total)
        label, end = best_end(tour, layer, count)
        if label < 0:
            return Outcome(None, np.inf, whole, total)
        order = np.empty(targets, dtype=np.int64)
        for at in range(targets - 1, -1, -1):
            place, parent = history[at]
            order[at] = place[label]
            label = int(parent[label])
        return Outcome(order, float(end), whole, total)

    def _extended(
        self, before: Layer, count: int, left: int, most: int, room: int
    ) -> tuple[Layer, int] | None:
        """The next layer; None if there is no room or no time for it."""
        after = empty_layer(FIRST_ROOM, self._words)
        table = np.full(4 * FIRST_ROOM, -1, dtype=np.int32)
        cursor = np.array([0, left, 0, 0])
        while cursor[2] < count:
            if self._over():
                return None
            cursor[3] = min(int(cursor[2]) + CHUNK, count)
            extend(self._tour, self._relaxation, self._windows, most, before, after, table, cursor)
            if cursor[2] < cursor[3]:
                if after.place.size >= room:
                    return None
                wider = empty_layer(2 * after.place.size, self._words)
                for name in Layer._fields:
                    getattr(wider, name)[: after.place.size] = getattr(after, name)
                after, table = wider, np.full(2 * table.size, -1, dtype=np.int32)
                reenter(table, after, int(cursor[0]))
        return after, int(cursor[0])
