"""Check whether any walk collects the stated amount, by forward label setting.

A *label* is the beginning of a walk: where it is and since when, exact ΔV left, kits aboard, what
it has collected, how many targets it has serviced, and which it remembers. Labels are gone through
in order of time. One is dropped if another one at its body is there no later, has as much left, has
collected as much, has counted no more, and remembers nothing else: whatever the one can do later
the other can, if it has as many kits, or more of kits that weigh nothing. Where there are cuts
(:mod:`.cuts`) it also has to have collected enough to pay for those that it alone has serviced an
odd number of rows of. And one is not made whose value and the most that is still to be had
(:mod:`.ahead`) together stay below what is asked for. If labels run out, no walk collects as much.

Where walks pay for ΔV, they also have to be worth a least amount, which tells labels apart, too.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from ...common.constants import SLACK_S
from ...kernels.core.compile import inlined, kernel
from .ahead import Ahead, still
from .cargo import after_service, is_unused, none_beyond
from .cuts import Tolls, sum_of, toll_for

FINE = 30
"""Extra bits of precision of collected amounts over those of values."""

WORD = 63
"""Number of targets per integer of a memory."""

BLOCK = 64
"""Number of labels compared at once, so that loops are vectorised."""

PAID_LESS = 64
"""Amount that payments are lessened by, for the rounding of products [fine units]."""

NONE, FOUND, FULL = 0, 1, 2


class WalkLabels(NamedTuple):
    """Partial walks.

    Attributes
    ----------
    body, kits, came_from : (labels,) int32
    counts : (labels,) int64
        As :class:`.cargo.StayCounts` packs them.
    time, left : (labels,) float64
        Ready since [s], and what is left of the tank, with the slack of the model [m/s].
    value : (labels,) int64
        Collected [fine units].
    worth : (labels,) int64
        What is serviced is worth, where that matters; else 0 [fine units of worth].
    memory : (labels, words) int64
        Bit j % 63 of word j // 63: may not go to target j.
    odd : (labels, cut words) int64
        Cuts of which an odd number of services is remembered.
    following : (labels,) int64
        Next label that will be ready in the same step, −1 for none.
    head : (steps + 1,) int64
        First label that will be ready in each step, −1 for none.
    """

    body: npt.NDArray[np.int32]
    kits: npt.NDArray[np.int32]
    came_from: npt.NDArray[np.int32]
    counts: npt.NDArray[np.int64]
    time: npt.NDArray[np.float64]
    left: npt.NDArray[np.float64]
    value: npt.NDArray[np.int64]
    worth: npt.NDArray[np.int64]
    memory: npt.NDArray[np.int64]
    odd: npt.NDArray[np.int64]
    following: npt.NDArray[np.int64]
    head: npt.NDArray[np.int64]


class KeptLabels(NamedTuple):
    """Labels kept at each body for dominance checks, by kits aboard.

    *Places* are bodies · (most kits + 1) + kits.

    Attributes
    ----------
    size : (places,) int64
    left : (places, room) float64
    value, worth, counts : (places, room) int64
    came_from : (places, room) int32
    memory : (places, words, room) int64
    odd : (places, cut words, room) int64
    """

    size: npt.NDArray[np.int64]
    left: npt.NDArray[np.float64]
    value: npt.NDArray[np.int64]
    worth: npt.NDArray[np.int64]
    counts: npt.NDArray[np.int64]
    came_from: npt.NDArray[np.int32]
    memory: npt.NDArray[np.int64]
    odd: npt.NDArray[np.int64]


class Price(NamedTuple):
    """What walks pay for ΔV, and the least that they are to be worth.

    Attributes
    ----------
    pays : bool
        Whether they do; the rest does not matter otherwise.
    per_m_s, per_s : float
        [fine units per m/s, and per s that pass until a walk ends].
    since : float
        When that time begins [s].
    worth : (bodies,) int64
        Of each service, rounded up [fine units of worth].
    least : int
        [fine units of worth]; 0 where no worth is asked for.
    reach : Ahead
        Most worth that is still to be had, where it is.
    """

    pays: bool
    per_m_s: float
    per_s: float
    since: float
    worth: npt.NDArray[np.int64]
    least: int
    reach: Ahead


class Question(NamedTuple):
    """The claim about walks to be checked.

    Attributes
    ----------
    gain : (bodies,) int64
        What a service is worth less its multiplier, rounded up [fine units].
    need : int
        What a walk is to collect [fine units].
    neighbourhoods : (bodies, words) int64
        What a walk that comes to a body still remembers.
    tolls : Tolls
        Of cuts [fine units].
    price : Price
    lost : (legs,) int64
        What the prize of the service at the end of each leg has fallen by, rounded down [fine
        units]; empty where no prize falls.
    """

    gain: npt.NDArray[np.int64]
    need: int
    neighbourhoods: npt.NDArray[np.int64]
    tolls: Tolls
    price: Price
    lost: npt.NDArray[np.int64]


@inlined
def _first_at(times, time):
    """First index in ascending times at or after a time."""
    low, high = 0, times.size
    while low < high:
        middle = (low + high) // 2
        if times[middle] < time:
            low = middle + 1
        else:
            high = middle
    return low


class Compared(NamedTuple):
    """What a label is compared by at its body, but for the kits aboard.

    Attributes
    ----------
    left : float
    value, worth, counts : int
    memory : (words,) int64
    odd : (cut words,) int64
    """

    left: float
    value: int
    worth: int
    counts: int
    memory: npt.NDArray[np.int64]
    odd: npt.NDArray[np.int64]


@kernel
def _is_dominated(cargo, tolls, kept, body, kits, label):
    """Whether an earlier label dominates a label at any number of kits."""
    place = body * cargo.full.size + kits
    # One with a kit more weighs more, and what it has left is worth less once that is gone.
    beyond = place + 1 if cargo.heavy else (body + 1) * cargo.full.size
    for each in range(place, beyond):  # noqa: SIM110  no generators in kernels
        if _is_dominated_at(kept, tolls, each, label):
            return True
    return False


@inlined
def _owing(tolls, odd, place, k, label):
    """Tolls that a kept label may have to pay at once and another label does not."""
    owing = np.int64(0)
    for w in range(label.odd.size):
        owing += sum_of(tolls, odd[place, w, k] & ~label.odd[w], w)
    return owing


@kernel
def _is_dominated_at(kept, tolls, place, label):
    """Whether a kept label at one place dominates a label."""
    left, value, memory = label.left, label.value, label.memory
    words = memory.size
    lefts, values, counts = kept.left[place], kept.value[place], kept.counts[place]
    memories = kept.memory[place]
    for begin in range(0, kept.size[place], BLOCK):
        end = min(begin + BLOCK, kept.size[place])
        found = False
        if words == 1:
            beyond, own = ~memory[0], memories[0]
            for k in range(begin, end):
                found |= (
                    (lefts[k] >= left)
                    & (values[k] >= value)
                    & none_beyond(counts[k], label.counts)
                    & (own[k] & beyond == 0)
                )
        else:
            for k in range(begin, end):
                if lefts[k] >= left and values[k] >= value and none_beyond(counts[k], label.counts):
                    more = np.int64(0)
                    for w in range(words):
                        more |= memories[w, k] & ~memory[w]
                    found |= more == 0
        if found and label.odd.size == 0 and label.worth == 0:
            return True
        if found:  # one of them, unless it is for the tolls, or worth less
            for k in range(begin, end):
                better = kept.worth[place, k] >= label.worth
                better &= (
                    lefts[k] >= left and values[k] >= value and none_beyond(counts[k], label.counts)
                )
                for w in range(words):
                    better = better and memories[w, k] & ~memory[w] == 0
                if better and values[k] - _owing(tolls, kept.odd, place, k, label) >= value:
                    return True
    return False


@inlined
def _move(kept, place, k, to):
    """Move a kept label to another index of its place."""
    kept.left[place, to] = kept.left[place, k]
    kept.value[place, to] = kept.value[place, k]
    kept.worth[place, to] = kept.worth[place, k]
    kept.counts[place, to] = kept.counts[place, k]
    kept.came_from[place, to] = kept.came_from[place, k]
    for w in range(kept.memory.shape[1]):
        kept.memory[place, w, to] = kept.memory[place, w, k]
    for w in range(kept.odd.shape[1]):
        kept.odd[place, w, to] = kept.odd[place, w, k]


@kernel
def _forget_poorer(kept, tolls, place, label):
    """Drop kept labels at a place that a newly ready label dominates.

    They were there before it, but for all that comes later both are there in time.
    """
    size = 0
    for k in range(kept.size[place]):
        poorer = kept.left[place, k] <= label.left and kept.value[place, k] <= label.value
        poorer = poorer and none_beyond(label.counts, kept.counts[place, k])
        poorer = poorer and kept.worth[place, k] <= label.worth
        for w in range(label.memory.size):
            poorer = poorer and label.memory[w] & ~kept.memory[place, w, k] == 0
        if poorer and label.odd.size:
            owing = np.int64(0)
            for w in range(label.odd.size):
                owing += sum_of(tolls, label.odd[w] & ~kept.odd[place, w, k], w)
            poorer = label.value - owing >= kept.value[place, k]
        if not poorer:
            _move(kept, place, k, size)
            size += 1
    kept.size[place] = size


@inlined
def _is_worth(price, step, body, kits, left, came_from, worth):
    """Whether a walk may still be worth as much as is asked for."""
    if price.least <= 0:
        return True
    more = still(price.reach, step, body, kits, left, came_from)
    return worth + (more << FINE) >= price.least


@kernel
def _forget_late(ahead, question, kept, place, step):
    """Drop kept labels at a place that are too late to dominate anything."""
    layers, size = ahead.best.shape[0], 0
    body, kits = place // layers, place % layers
    for k in range(kept.size[place]):
        left, came_from = kept.left[place, k], kept.came_from[place, k]
        most = still(ahead, step, body, kits, left, came_from)
        useful = kept.value[place, k] + (most << FINE) >= question.need
        if useful and _is_worth(
            question.price, step, body, kits, left, came_from, kept.worth[place, k]
        ):
            _move(kept, place, k, size)
            size += 1
    kept.size[place] = size


@inlined
def _rest(cargo, to_station, j, kits, left):
    """ΔV left after the stay at j, from that on arrival; negative if infeasible."""
    if left < 0.0:
        return left
    if to_station:
        return cargo.full[kits]
    return after_service(cargo, j, kits, left)


@inlined
def _less(product):
    """A payment, a little less for the rounding of products [fine units]."""
    return max(np.int64(product) - PAID_LESS, np.int64(0))


@inlined
def _is_asked_for(question, label, time):
    """Whether a walk that ends with a label counts as much, and is worth as much, as is asked."""
    price, value = question.price, label.value
    if price.pays:
        value -= _less(max(time - price.since, 0.0) * price.per_s)
        if label.worth < price.least:
            return False
    return value >= question.need


@kernel
def _extend(legs, ahead, question, labels, kept, count, label):
    """Extend a label by all its legs; returns the new number of labels.

    Parameters
    ----------
    count : int
        Labels made so far.

    Returns
    -------
    count : int
        Less than 0 if there is no room for all: those made already will dominate their doubles.
    """
    memory, odd = np.empty_like(labels.memory[label]), np.empty_like(labels.odd[label])
    bodies, words, tolls = question.gain.size, memory.size, question.tolls
    price, counting = question.price, legs.terms.counting
    i, time, left = labels.body[label], labels.time[label], labels.left[label]
    kits, cargo, head = labels.kits[label], legs.terms.cargo, labels.head
    came_from = np.int32(-1) if legs.terms.is_station[i] else i
    for j in range(bodies):
        pair = i * bodies + j
        low, high = legs.first[pair], legs.first[pair + 1]
        to_station = legs.terms.is_station[j]
        if low == high:
            continue
        if not to_station and (
            labels.memory[label, j // WORD] >> (j % WORD) & 1 or kits < cargo.takes[j]
        ):
            continue
        counts = (labels.counts[label] & counting.keeps[j]) + counting.adds[j]
        if not none_beyond(counts, counting.most):
            continue
        aboard = kits - cargo.takes[j]
        gained = labels.value[label] + question.gain[j] - toll_for(tolls, labels.odd[label], j)
        worth = labels.worth[label] + (price.worth[j] if price.pays else 0)
        for w in range(odd.size):
            odd[w] = labels.odd[label, w] & tolls.memory[j, w] ^ tolls.rows[j, w]
        for w in range(words):
            memory[w] = labels.memory[label, w] & question.neighbourhoods[j, w]
        if came_from >= 0:
            memory[i // WORD] |= np.int64(1) << (i % WORD)
        best = np.inf
        for leg in range(low + _first_at(legs.end[low:high], time - SLACK_S), high):
            cost = legs.delta_v[leg]
            if legs.departure[leg] < time - SLACK_S or cost >= best or cost > left:
                continue
            step = _first_at(ahead.last, legs.end[leg] - SLACK_S)
            # Not even with the cheapest of all later ones: then with none of them.
            most_left = _rest(cargo, to_station, j, kits, left - legs.cheapest[leg])
            if most_left < 0.0:
                break
            most = still(ahead, step, j, aboard, most_left, came_from)
            value = gained
            if price.pays:
                value -= _less(legs.cheapest[leg] * price.per_m_s)
            if value + (most << FINE) < question.need:
                break
            if not _is_worth(price, step, j, aboard, most_left, came_from, worth):
                break
            best, value = cost, gained
            if question.lost.size > 0:
                value -= question.lost[leg]
            if price.pays:
                value -= _less(cost * price.per_m_s)
            rest = _rest(cargo, to_station, j, kits, left - cost)
            if rest < 0.0:
                continue
            most = still(ahead, step, j, aboard, rest, came_from)
            if value + (most << FINE) < question.need:
                continue
            if not _is_worth(price, step, j, aboard, rest, came_from, worth):
                continue
            reached = Compared(rest, value, worth, counts, memory, odd)
            if _is_dominated(cargo, tolls, kept, j, aboard, reached):
                continue
            if count == labels.body.size:
                return -count
            labels.body[count], labels.kits[count], labels.counts[count] = j, aboard, counts
            labels.came_from[count] = came_from
            labels.time[count], labels.left[count] = legs.end[leg], rest
            labels.value[count], labels.worth[count] = value, worth
            for w in range(words):
                labels.memory[count, w] = memory[w]
            for w in range(odd.size):
                labels.odd[count, w] = odd[w]
            labels.following[count], head[step] = head[step], count
            count += 1
    return count


@kernel
def search(legs, ahead, question, labels, kept, cursor, ready):
    """Process all labels, step by step.

    Parameters
    ----------
    cursor : (4,) int64
        Step, labels made, and those of the step that were gone through of how many; updated.
    ready : (labels,) int64
        Desk: the labels of the step in order of time.

    Returns
    -------
    state : int
        NONE if labels have run out, FOUND if one of them collects as much as is asked for, FULL if
        there is no room.
    """
    cargo, head, tolls = legs.terms.cargo, labels.head, question.tolls
    while cursor[0] < head.size:
        step = cursor[0]
        if cursor[3] < 0:
            size, label = 0, head[step]
            while label >= 0:
                ready[size] = label
                size += 1
                label = labels.following[label]
            times = np.empty(size)
            for k in range(size):
                times[k] = labels.time[ready[k]]
            order = np.argsort(times)
            chosen = np.empty(size, np.int64)
            for k in range(size):
                chosen[k] = ready[order[k]]
            for k in range(size):
                ready[k] = chosen[k]
            for place in range(kept.size.size):
                _forget_late(ahead, question, kept, place, step)
            cursor[2], cursor[3] = 0, size
        while cursor[2] < cursor[3]:
            label = ready[cursor[2]]
            body, kits = labels.body[label], labels.kits[label]
            own = Compared(
                labels.left[label],
                labels.value[label],
                labels.worth[label],
                labels.counts[label],
                labels.memory[label],
                labels.odd[label],
            )
            if not _is_dominated(cargo, tolls, kept, body, kits, own):
                ends = legs.terms.may_end[body] and not is_unused(cargo, kits)
                if ends and _is_asked_for(question, own, labels.time[label]):
                    return FOUND
                place = body * cargo.full.size + kits
                _forget_poorer(kept, tolls, place, own)
                at = kept.size[place]
                if at == kept.left.shape[1]:
                    return FULL
                count = _extend(legs, ahead, question, labels, kept, cursor[1], label)
                cursor[1] = abs(count)
                if count < 0:
                    return FULL
                kept.left[place, at], kept.value[place, at] = own.left, own.value
                kept.counts[place, at], kept.worth[place, at] = own.counts, own.worth
                kept.came_from[place, at] = labels.came_from[label]
                for w in range(own.memory.size):
                    kept.memory[place, w, at] = own.memory[w]
                for w in range(own.odd.size):
                    kept.odd[place, w, at] = own.odd[w]
                kept.size[place] = at + 1
            cursor[2] += 1
        cursor[0] += 1
        cursor[3] = -1
    return NONE
