"""Lists of closed labels, for the verifier to check.

Nothing here has to be trusted: labels are gone on from by the functions that check the list
(:mod:`adr_opt.judge.verify.closed`), and those that are said to dominate others are checked.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from adr_opt.common.constants import SLACK_S
from adr_opt.judge.verify.closed import FINE, ClosedLabels, Finder, Question, ends_of, is_answer
from adr_opt.judge.verify.completion import still
from adr_opt.judge.verify.cuts import WORD
from adr_opt.judge.verify.legs import Legs
from adr_opt.kernels.core.compile import kernel

Array = npt.NDArray[Any]


class Expanded(NamedTuple):
    """Outcome of an expansion.

    Attributes
    ----------
    reached : bool
        Whether a walk is an answer; then there is no list.
    labels : ClosedLabels
        The list.
    made : int
        How many labels it took.
    """

    reached: bool
    labels: ClosedLabels
    made: int


class KnownLabels(NamedTuple):
    """Labels by place, body · (most kits + 1) + kits, in order of time, the better ones first.

    Attributes
    ----------
    labels : ClosedLabels
    first : (places + 1,) int64
        First label of each place.
    order : (labels,) int64
        Where each was before it was brought into order.
    """

    labels: ClosedLabels
    first: Array
    order: Array


def _known(legs: Legs, labels: ClosedLabels) -> KnownLabels:
    layers = legs.terms.cargo.full.size
    place = labels.body * layers + labels.kits
    order = np.lexsort((-labels.left, -labels.value, labels.time, place))
    first = np.searchsorted(place[order], np.arange(legs.terms.bodies * layers + 1))
    return KnownLabels(labels.at(order), first, order)


@kernel
def _covering(layers, heavy, toll, first, listed, labels, own):
    """Position of a known label that dominates each of some labels, −1 for none.

    Parameters
    ----------
    layers : int
        Numbers of kits that there may be aboard.
    heavy : bool
        Whether kits weigh something.
    toll : (cuts,) int64
    first : (places + 1,) int64
    listed : ClosedLabels
        As :class:`KnownLabels` has them.
    labels : ClosedLabels
    own : (labels,) int64
        Their own positions, where they are among the known: then only those before count.
    """
    all_left, all_value, all_worth = listed.left, listed.value, listed.worth
    all_counts, all_memory, all_odd = listed.counts, listed.memory, listed.odd
    found = np.full(labels.body.size, -1)
    for row in range(labels.body.size):
        kits = labels.kits[row]
        left, value, worth = labels.left[row], labels.value[row], labels.worth[row]
        for aboard in range(kits, kits + 1 if heavy else layers):
            place = labels.body[row] * layers + aboard
            low, end = first[place], first[place + 1]
            end = low + np.searchsorted(listed.time[low:end], labels.time[row], side="right")
            if aboard == kits and own[row] >= 0:
                end = min(end, own[row])
            for at in range(end - 1, low - 1, -1):  # the latest are likely to, but any will do
                if all_left[at] < left or all_value[at] < value or all_worth[at] < worth:
                    continue
                good = True
                for word in range(all_memory.shape[0]):
                    good = good and all_memory[word, at] & ~labels.memory[word, row] == 0
                for kind in range(all_counts.shape[0]):
                    good = good and all_counts[kind, at] <= labels.counts[kind, row]
                ahead = all_value[at] - value
                for cut in range(toll.size if good else 0):
                    word, bit = cut // WORD, np.int64(1) << (cut % WORD)
                    if all_odd[word, at] & ~labels.odd[word, row] & bit:
                        ahead -= toll[cut]
                if good and ahead >= 0:
                    found[row] = at
                    break
            if found[row] >= 0:
                break
    return found


def _covered(
    legs: Legs, question: Question, known: KnownLabels, labels: ClosedLabels, own: Array
) -> Array:
    cargo = legs.terms.cargo
    layers, toll = cargo.full.size, question.cuts.toll
    found: Array = _covering(layers, cargo.heavy, toll, known.first, known.labels, labels, own)
    return found


def _nowhere(labels: ClosedLabels) -> Array:
    return np.full(labels.body.size, -1)


def finder(legs: Legs, question: Question, labels: ClosedLabels) -> Finder:
    """Function that finds labels of a list that dominate others."""
    known = _known(legs, labels)

    def find(others: ClosedLabels) -> Array:
        found = _covered(legs, question, known, others, _nowhere(others))
        rows: Array = np.append(known.order, -1)[found]
        return rows

    return find


def _joined(parts: list[ClosedLabels]) -> ClosedLabels:
    return ClosedLabels(*(np.concatenate(columns, axis=-1) for columns in zip(*parts, strict=True)))


def expand(legs: Legs, question: Question, starts: ClosedLabels) -> Expanded:
    """Make the closed list: extend labels in order, and drop those dominated by earlier ones.

    Labels are gone through in windows of time shorter than every leg, so that all of a window are
    there when it begins.
    """
    pending, closed = [starts], [starts.at(np.s_[:0])]
    active, made = closed[0], starts.body.size
    while any(part.body.size for part in pending):
        waiting = _joined(pending)
        begin = float(waiting.time.min())
        is_due = waiting.time < begin + legs.shortest - 2.0 * SLACK_S
        due, pending = waiting.at(is_due), [waiting.at(~is_due)]
        if np.any(is_answer(legs, question, due)):
            return Expanded(True, closed[0], made)
        active = _useful(question, active, begin)
        known = _known(legs, _joined([active, due]))
        own = np.argsort(known.order)[active.body.size :]
        fresh = due.at(_covered(legs, question, known, due, own) < 0)
        closed.append(fresh)
        active = _joined([active, fresh])
        known = _known(legs, active)
        for ends in ends_of(legs, question, fresh):
            more = ends.at(_covered(legs, question, known, ends, _nowhere(ends)) < 0)
            pending.append(more)
            made += more.body.size
    return Expanded(False, _joined(closed), made)


def _useful(question: Question, labels: ClosedLabels, time_s: float) -> ClosedLabels:
    """Labels that may still dominate one that is ready later and may become an answer."""
    table = question.table
    step = np.full(labels.body.size, np.searchsorted(table.last, time_s - SLACK_S))
    more = still(table, labels.kits, step, labels.body, labels.left, _nowhere(labels))
    return labels.at(labels.value + (more << FINE) >= question.need)
