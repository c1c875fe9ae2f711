"""Labels forwards in time, pruned by completion values: the kernels.

A *label* is a partial walk: where it is and since when, exact ΔV left, value (prizes less
multipliers), and a memory of targets that it may not visit again. It is kept only if

    value + completion value + Σ π ≥ threshold ,

since no plan that begins with it can be worth more than the left side. Time and ΔV are exact here.
All that is relaxed is the memory: on the way to body j a walk forgets every target that is not in
the neighbourhood of j, except the body it comes from (ng-routes: Baldacci, Mingozzi and Roberti
2011).

A chaser that is at a body earlier and richer, with the same memory or less, may wait and do all
that the later one can. So labels of one body are compared across *all* times, exactly: rows are
gone through in order of departure, and each body has a list of the labels that are there and
ready, none dominated by another. A label stays in the list, waiting, until its completion value
says that it is too late.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from adr_opt.kernels.compile import kernel

from .network import SLACK

WORD = 63
"""Targets remembered in one integer."""

FINE = 16
"""Labels count in units finer than those of the completion values by so many bits."""

EXHAUSTED, CHUNK_DONE, FULL = 0, 1, 2


class Labels(NamedTuple):
    """Partial walks. Lists of a row, or of a body, are chained by ``following``.

    Attributes
    ----------
    row, parent, following : (labels,) int64
    value : (labels,) int64
        [fine units].
    left : (labels,) float64
        [m/s].
    visits : (labels,) int64
        Services so far.
    worth : (labels,) float64
        Worth of the targets serviced; only where ΔV is paid for.
    memory : (labels, words) int64
        Bit j % 63 of word j // 63: may not go to target j.
    """

    row: np.ndarray
    parent: np.ndarray
    following: np.ndarray
    value: np.ndarray
    left: np.ndarray
    visits: np.ndarray
    worth: np.ndarray
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
    most_visits : int
        Services that a walk may make.
    price : float
        What a m/s takes off the value of a walk [fine units]; 0 where ΔV is not paid for.
    worths : (bodies,) float64
        What targets are worth, where it is.
    least_worth : float
        Walks worth less are of no use, where it is.
    reach : (before + rows·width,) float32
        Most worth that is still to be had, as ``best`` is laid out, where it is.
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
    most_visits: int
    price: float
    worths: np.ndarray
    least_worth: float
    reach: np.ndarray


@kernel
def _completion(search, row, left, came_from):
    """Most that a walk can still collect from a row on without going back at once [fine units]."""
    at = (row + 1) * search.width + min(int(left / search.slot + SLACK), search.top)
    packed = search.best[at]
    if packed & ((1 << search.bits) - 1) == came_from:
        packed = search.second[at]
    return np.int64(packed >> search.bits) << FINE


@kernel
def _reaches(search, row, left, worth):
    """Whether a walk that has a worth can still be worth enough, where that counts."""
    if search.price == 0.0:
        return True
    at = (row + 1) * search.width + min(int(left / search.slot + SLACK), search.top)
    return worth + search.reach[at] >= search.least_worth


@kernel
def _dominates(labels, one, value, left, visits, worth, remembered):
    """Whether label ``one`` is worth as much, has as much left and remembers nothing more."""
    if labels.value[one] < value or labels.left[one] < left or labels.visits[one] > visits:
        return False
    if labels.worth[one] < worth:
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
                labels, other, labels.value[label], labels.left[label], labels.visits[label],
                labels.worth[label], labels.memory[label],
            ):  # fmt: skip
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
    counts = search.most_visits < search.gain.size
    remembered = np.empty(words, dtype=np.int64)
    target_effort = cursor[2] + effort
    while cursor[0] < order.size:
        row = order[cursor[0]]
        i = body[row]
        _arrive(labels, pending, ready, row, i)
        j = network.destination[row]
        behind = -1 if network.is_station[i] else i
        label, before = ready[i], -1
        while label >= 0:
            following = labels.following[label]
            parent = labels.parent[label]
            came_from = body[labels.row[parent]] if parent >= 0 else -1
            if came_from >= 0 and network.is_station[came_from]:
                came_from = -1
            left, value, worth = labels.left[label], labels.value[label], labels.worth[label]
            if value + _completion(search, row, left, came_from) < search.need or not _reaches(
                search, row, left, worth
            ):
                # Too late, now and at every later row.
                if before < 0:
                    ready[i] = following
                else:
                    labels.following[before] = following
                label = following
                continue
            before = label
            label, here = following, label
            to_station = network.is_station[j]
            if not to_station:
                if labels.memory[here, j // WORD] >> (j % WORD) & 1:
                    continue
                if labels.visits[here] == search.most_visits:
                    continue
            # What does not limit a walk is not counted, so that it tells no labels apart.
            visits = labels.visits[here] + (counts and not to_station)
            for leg in range(network.first[row], network.first[row + 1]):
                if network.delta_v[leg] > left:
                    continue
                landing = network.landing[leg]
                rest = search.budget if to_station else left - network.delta_v[leg]
                paid = np.int64(search.price * network.delta_v[leg])
                then = value + search.gain[j] - paid
                if then + _completion(search, landing, rest, behind) < search.need:
                    continue
                collected = worth
                if search.price > 0.0:
                    collected += search.worths[j]
                    if not _reaches(search, landing, rest, collected):
                        continue
                cursor[2] += 1
                for w in range(words):
                    remembered[w] = labels.memory[here, w] & search.neighbourhood[j, w]
                if not network.is_station[i]:
                    remembered[i // WORD] |= 1 << (i % WORD)
                other = ready[j]
                while other >= 0 and not _dominates(
                    labels, other, then, rest, visits, collected, remembered
                ):
                    other = labels.following[other]
                if other < 0:
                    other = pending[landing]
                    while other >= 0 and not _dominates(
                        labels, other, then, rest, visits, collected, remembered
                    ):
                        other = labels.following[other]
                if other >= 0:
                    continue
                count = cursor[1]
                if count == labels.row.size:
                    # The row is begun again later; what it has made already dominates its doubles.
                    return FULL
                labels.row[count], labels.parent[count] = landing, here
                labels.value[count], labels.left[count] = then, rest
                labels.visits[count], labels.worth[count] = visits, collected
                for w in range(words):
                    labels.memory[count, w] = remembered[w]
                labels.following[count] = pending[landing]
                pending[landing] = count
                cursor[1] += 1
        cursor[0] += 1
        if cursor[2] >= target_effort:
            break
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
def _counts(network, labels, body, label, least, least_worth):
    """Whether a label is of enough value and worth, at a body where a mission may end."""
    return (
        labels.value[label] >= least
        and labels.worth[label] >= least_worth
        and network.may_end[body[labels.row[label]]]
    )


@kernel
def learn(network, labels, body, count, least, least_worth, most_walks, neighbourhood, path):
    """Look at walks worth at least so much, and let the bodies inside their cycles remember.

    Parameters
    ----------
    network : Network
    labels : Labels
    body : (rows,) int32
        Body of each row.
    count : int
        Number of labels.
    least : int
        Walks of less value are not looked at [fine units].
    least_worth : float
        Nor are those of less worth.
    most_walks : int
        Walks to learn from, spread evenly over all of them: neighbours share their cycles.
    neighbourhood : (bodies, words) int64
        Updated.
    path : (legs,) int64
        Desk.

    Returns
    -------
    plan : int
        A label of the greatest value without any cycle, where a mission may end; −1 for none.
    grown : int
        How many memories were added.
    """
    walks = 0
    for label in range(count):
        walks += _counts(network, labels, body, label, least, least_worth)
    stride = max(1, walks // most_walks)
    seen = np.empty(neighbourhood.shape[0], dtype=np.int64)
    plan, grown, number = -1, 0, 0
    for label in range(count):
        if not _counts(network, labels, body, label, least, least_worth):
            continue
        number += 1
        length = path_of(labels, body, label, path)
        seen[:] = -1
        is_plan = True
        for a in range(length):
            j = path[a]
            if network.is_station[j]:
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


@kernel
def most_of(network, labels, body, count, least, least_worth):
    """Greatest value of the walks that count, see :func:`_counts`; ``least`` if all are below."""
    best = least
    for label in range(count):
        if _counts(network, labels, body, label, least, least_worth):
            best = max(best, labels.value[label])
    return best
