"""Check of a list of labels that proves that no walk collects a stated amount.

A *walk* W is a route of a chaser that may return to targets that it has forgotten; an *answer* is
one that may end where it is and has collected at least what is needed. A *label* L is a beginning
of walks: where it is and since when, what is left of the tank, kits aboard, what it has collected,
how many targets it has serviced, and which it remembers. L *dominates* W at the same body if it is
there no later, has at least as much left and collected with no more services, and remembers only
what W remembers: whatever W can still do, L can, and what dominates L dominates W. A list of
labels, which anybody may have made, is *closed* if

1. none of its labels is an answer,
2. one of them dominates every beginning of a walk,
3. every leg of every one of them ends in a label that one of them dominates, or that cannot become
   an answer any more, by the table of :mod:`.completion`, or later and no cheaper than another leg
   to the same body.

Then no walk W is an answer. Some L dominates its beginning, by 2. If L dominates it before a leg, L
can take that leg, too, and by 3 some L' dominates it afterwards, or no answer comes of it. Where W
ends some L dominates it, which is no answer by 1: nor is W. Each label is checked for itself, so
that their order does not matter. Times and ΔV are exact, or rounded in favour of walks.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from itertools import chain
from typing import Any, NamedTuple

import numpy as np

from ...common.constants import SLACK_S
from .cargo import left_after
from .completion import Array, Completion, still
from .cuts import WORD, Tolls, tolls
from .legs import Legs

FINE = 30
"""Collected amounts are in *fine units*, of which 2**FINE are a unit of the table."""

MOST = 2**60
"""Largest amount in a list, so that no sum is too large for an integer [fine units]."""

PAID_LESS = 64
"""Reduction of payments that covers the rounding of products up to 2**57 [fine units]."""

ROWS = 8192
"""Number of labels extended at once."""


class ClosedLabels(NamedTuple):
    """Labels, the last axis of every column.

    Attributes
    ----------
    body, kits : (labels,) int64
        Where; kits aboard.
    time, left : (labels,) float64
        Ready since [s], and what is left of the tank, with the slack of the model [m/s].
    value, worth : (labels,) int64
        Collected [fine units]; worth of what was serviced, where that matters, else 0.
    counts : (kinds, labels) int64
        Stays of each kind of :class:`.cargo.StayCounts`.
    memory : (words, labels) int64
        Bit j % 63 of word j // 63: may not go to target j, which a walk sets as it leaves j.
    odd : (cut words, labels) int64
        Cuts of which an odd number of services is remembered.
    """

    body: Array
    kits: Array
    time: Array
    left: Array
    value: Array
    worth: Array
    counts: Array
    memory: Array
    odd: Array

    def at(self, rows: Any) -> ClosedLabels:
        """The labels at some indices."""
        return ClosedLabels(*(column[..., rows] for column in self))


class Question(NamedTuple):
    """The claim on walks to be refuted; this check trusts the code that reads the certificate.

    Attributes
    ----------
    table, reach : Completion
        For the gains, and for the worth, of which nothing is paid.
    gain : (bodies,) int64
        What a service is worth less its multiplier, rounded up [fine units].
    need : int
        What a walk is to collect [fine units].
    lost : (legs,) int64
        By what the prize at each leg's end has fallen: no less at a later one [fine units].
    neighbourhoods : (words, bodies) int64
        What a walk that comes to a body still remembers.
    cuts : Tolls
        What each cut costs at every second service of its targets, rounded down [fine units].
    per_m_s, per_s : float
        At least 0, what walks pay for ΔV and the time until they end [fine units per m/s, per s].
    since : float
        When that time begins [s].
    worth : (bodies,) int64
        Of a service, rounded up [fine units of ``reach``].
    least : int
        What a walk is to be worth, or 0.
    """

    table: Completion
    reach: Completion
    gain: Array
    need: int
    lost: Array
    neighbourhoods: Array
    cuts: Tolls
    per_m_s: float
    per_s: float
    since: float
    worth: Array
    least: int


Finder = Callable[[ClosedLabels], Array]
"""Untrusted function that names, for each label, a row of the list that dominates it."""


def why_open(
    legs: Legs, question: Question, labels: ClosedLabels, starts: ClosedLabels, find: Finder
) -> str | None:
    """Why a list of labels does not prove that no walk is an answer; None if it does.

    Parameters
    ----------
    legs : Legs
    question : Question
    labels : ClosedLabels
        The list.
    starts : ClosedLabels
        The beginnings of walks.
    find : callable
        Asked for the starts, and then for the ends of the legs of the labels, some at a time: in
        the order of the list, and those of a label in order of legs.
    """
    pairs = zip(labels, starts, strict=True)
    labels = ClosedLabels(*(np.array(own, one.dtype) for own, one in pairs))
    shapes = [(*one.shape[:-1], labels.body.size) for one in starts]
    if [own.shape for own in labels] != shapes:
        return "labels have another number of memory words or counts than walks"
    ranges = (
        (labels.value, -MOST, MOST),
        (labels.worth, -MOST, MOST),
        (labels.body, 0, legs.terms.bodies - 1),
        (labels.kits, 0, legs.terms.cargo.full.size - 1),
    )
    inside = [np.all((least <= column) & (column <= most)) for column, least, most in ranges]
    if not (all(inside) and np.all(np.isfinite(labels.time) & np.isfinite(labels.left))):
        return "a label has no body of the instance, or a value that is not a number"
    if np.any(is_answer(legs, question, labels)):
        return "a walk collects as much"
    for ends in chain([starts], ends_of(legs, question, labels)):
        row = np.array(find(ClosedLabels(*map(np.copy, ends))), dtype=np.int64)
        if row.shape != ends.body.shape or np.any((row < 0) | (row >= labels.body.size)):
            return "no label covers the end of a leg, or a start"
        if not np.all(dominates(legs, question, labels.at(row), ends)):
            return "a label does not cover the end of a leg, or a start, that it is said to cover"
    return None


def dominates(legs: Legs, question: Question, some: ClosedLabels, others: ClosedLabels) -> Array:
    """Which labels dominate others, one by one."""
    # Where kits weigh something, one more aboard means less left once it is gone.
    aboard = np.equal if legs.terms.cargo.heavy else np.greater_equal
    found: Array = (some.body == others.body) & aboard(some.kits, others.kits)
    found &= (some.time <= others.time) & (some.left >= others.left)
    found &= some.worth >= others.worth
    found &= np.all(some.counts <= others.counts, axis=0)
    found &= np.all(some.memory & ~others.memory == 0, axis=0)
    # It may have to pay at once what the other one has paid.
    owing = tolls(some.odd & ~others.odd, question.cuts.toll)
    found &= some.value - owing >= others.value
    return found


def is_answer(legs: Legs, question: Question, labels: ClosedLabels) -> Array:
    """Mask of walks that may end and collect the stated amount."""
    waited = np.maximum(labels.time - question.since, 0.0)
    value = labels.value - _less(waited * question.per_s)
    unused = legs.terms.cargo.heavy & (labels.kits > 0)
    reaches = (value >= question.need) & (labels.worth >= question.least)
    ends: Array = legs.terms.may_end[labels.body] & ~unused & reaches
    return ends


def _less(product: Array) -> Any:
    """A payment, reduced to cover the rounding of products [fine units]."""
    return np.maximum(np.minimum(product, 2.0**57).astype(np.int64) - PAID_LESS, 0)


def ends_of(legs: Legs, question: Question, labels: ClosedLabels) -> Iterator[ClosedLabels]:
    """Extensions of labels by all legs that may lead to an answer, in blocks."""
    for begin in range(0, labels.body.size, ROWS):
        some = labels.at(np.s_[begin : begin + ROWS])
        row, pair, _ = ways = _first_legs(legs, some)
        onto = _after(legs, question, some.at(row), pair)
        way, leg, left, value = _flown(legs, question, some, onto, ways)
        ends = onto.at(way)._replace(time=legs.end[leg], left=left, value=value)
        yield ends.at(np.lexsort((leg, row[way])))


def _first_legs(legs: Legs, labels: ClosedLabels) -> Array:
    """Pairs of a label and a destination, with the first leg of each, shape (3, pairs).

    Row of the label, pair, and the first leg that may be in time. A pair is origin · bodies +
    destination.
    """
    terms, found = legs.terms, [np.empty((3, 0), dtype=np.int64)]
    counting, kits = terms.counting, labels.kits
    for i in np.unique(labels.body).tolist():
        here = np.flatnonzero(labels.body == i)
        for j in range(terms.bodies):
            pair = i * terms.bodies + j
            low, high = legs.first[pair], legs.first[pair + 1]
            if low == high:
                continue
            may = (labels.memory[j // WORD, here] >> (j % WORD) & 1 == 0) | terms.is_station[j]
            may &= kits[here] >= terms.cargo.takes[j]
            counts = labels.counts[:, here] * counting.keeps[:, j, None] + counting.adds[:, j, None]
            may &= np.all(counts <= counting.most[:, None], axis=0)
            rows = here[may]
            since = labels.time[rows] + legs.quickest[pair] - 2.0 * SLACK_S
            leg = low + np.searchsorted(legs.end[low:high], since)
            found.append(np.stack([rows, np.full(rows.size, pair), leg]))
    return np.concatenate(found, axis=1)


def _after(legs: Legs, question: Question, before: ClosedLabels, pair: Array) -> ClosedLabels:
    """Labels after legs of given pairs, before time and ΔV are applied."""
    terms, counting = legs.terms, legs.terms.counting
    i, j = np.divmod(pair, terms.bodies)
    memory = before.memory & question.neighbourhoods[:, j]
    word, bit = i // WORD, np.where(terms.is_station[i], 0, 1 << (i % WORD))
    for number in range(memory.shape[0]):
        memory[number] |= np.where(word == number, bit, 0)
    remembered, rows = before.odd & question.cuts.memory[:, j], question.cuts.rows[:, j]
    value = before.value + question.gain[j] - tolls(remembered & rows, question.cuts.toll)
    return before._replace(
        body=j,
        kits=before.kits - terms.cargo.takes[j],
        value=np.maximum(value, -MOST),
        worth=before.worth + question.worth[j],
        counts=before.counts * counting.keeps[:, j] + counting.adds[:, j],
        memory=memory,
        odd=remembered ^ rows,
    )


def _flown(
    legs: Legs, question: Question, labels: ClosedLabels, onto: ClosedLabels, ways: Array
) -> tuple[Array, ...]:
    """Legs that may lead to an answer, examined in order for all pairs at once.

    Those are from ``labels`` to ``onto``, of which there is one for each. Gives for each leg its
    way and number, and what is left and collected after the stay.
    """
    row, pair, leg = ways
    terms, way = legs.terms, np.arange(row.size)
    i, j = np.divmod(pair, terms.bodies)
    came_from, stop = np.where(terms.is_station[i], -1, i), legs.first[pair + 1]
    since, kits, tank = labels.time[row] - SLACK_S, labels.kits[row], labels.left[row]
    is_station, full = terms.is_station[j], terms.cargo.full[kits]

    def after(way: Array, leg: Array, cost: Array, lost: Any) -> tuple[Array, Array, Array]:
        """ΔV left and amount collected after legs of a cost, and whether an answer may follow."""
        left = left_after(terms.cargo, j[way], kits[way], tank[way] - cost)
        left = np.where(is_station[way] & (left >= 0.0), full[way], left)
        value = onto.value[way] - lost - _less(cost * question.per_m_s)
        at = onto.kits[way], question.table.lands[leg], j[way], np.maximum(left, 0.0)
        more = still(question.table, *at, came_from[way])
        may = (left >= 0.0) & (value + (more << FINE) >= question.need)
        if question.least > 0:
            more = still(question.reach, *at, came_from[way])
            may &= onto.worth[way] + (more << FINE) >= question.least
        return left, value, may

    least_paid, found = np.full(row.size, np.inf), [(way[:0], leg[:0], tank[:0], way[:0])]
    while way.size:
        way, leg = way[leg < stop[way]], leg[leg < stop[way]]
        # Not even by the cheapest of this leg and all later ones: then by none of them.
        may = after(way, leg, legs.cheapest[leg], 0)[2]
        way, leg = way[may], leg[may]
        cost = legs.delta_v[leg]
        # What costs no less than a leg of the pair that ends earlier is no use: that one leaves a
        # label that dominates, and if no answer comes of it none comes of this one.
        flies = (legs.departure[leg] >= since[way]) & (cost < least_paid[way]) & (cost <= tank[way])
        some, by = way[flies], leg[flies]
        least_paid[some] = cost[flies]
        left, value, may = after(some, by, cost[flies], question.lost[by])
        found.append((some[may], by[may], left[may], value[may]))
        leg = leg + 1
    return tuple(np.concatenate(column) for column in zip(*found, strict=True))
