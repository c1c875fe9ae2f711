"""Forward label extension in time, pruned by completion values: the kernels.

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
says that it is too late. It has no use for legs that are no better than one it could take before.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from adr_opt.kernels.core.compile import inlined, kernel
from adr_opt.kernels.core.memory import borrowed
from adr_opt.kernels.rules import resources as resource_kernels
from adr_opt.kernels.rules.falls import Falls, lost_at
from adr_opt.kernels.rules.loads import Loads, is_possible
from adr_opt.kernels.rules.resources import CountLimits
from adr_opt.mission.evidence import WORD

from ..networks.layers import SLACK
from .pending import is_preceded, next_of, send, take
from .row_cuts import CutTolls, count_row, toll_at
from .waiting import FINE, Candidate, LabelTerms, arrive, is_dominated, keep, resources_of

MOST_PAID = 2.0**60
"""Upper limit on the price of time of a walk, beyond which it is useless [fine units]."""

EXHAUSTED, CHUNK_DONE, FULL, CROWDED, PILED = 0, 1, 2, 3, 4


class CompletionValues(NamedTuple):
    """Completion values: the most a walk can still collect, by body, time and ΔV left.

    Attributes
    ----------
    bucket : (rows,) int32
        Where the values of a row lie.
    best, second : (kinds, layers·layer) int32
        The values of each kind, packed as :class:`solvers.walks.sweeps.Values` says; a layer for
        each number of kits aboard.
    layer, bits, width, top : int
    slot : float
        As of the bound that they come from [m/s].
    """

    bucket: np.ndarray
    best: np.ndarray
    second: np.ndarray
    layer: int
    bits: int
    width: int
    top: int
    slot: float


class LabelQuery(NamedTuple):
    """Goal of a label search, and the memory it must keep.

    Attributes
    ----------
    values : CompletionValues
        Of one kind, or several where ΔV is paid for.
    shift : (kinds,) float64
        What worth adds to the value of a walk to make its value of that kind [fine units].
    need : (kinds,) int64
        Value of each kind below which a walk is of no use, with the time paid for since the first
        mission of the network began [fine units].
    gain : (bodies,) int64
        Prize less multiplier [fine units].
    neighbourhood : (bodies, words) int64
        What walks remember at each body.
    compared : (bodies, words) int64
        What of it tells labels apart there. All of it in a proof.
    budget : float
        [m/s].
    loads : Loads or None
    limits : CountLimits
        As in :class:`adr_opt.kernels.rules.rules.Rules`.
    price : (kits + 1,) float64
        What a m/s takes off the value of a walk, by number of kits aboard [fine units].
    pays : bool
        Whether ΔV is paid for.
    time_price : float
        What a second takes off the value of a walk when it ends, where the network has ends of
        services [fine units].
    since : float
        When that time begins [s].
    goal : int
        Value, after that, of walks that are asked for [fine units].
    worths : (bodies,) float64
        What targets are worth, where it is; one each where labels of different targets are to be
        told apart, whatever they remember; else nothing.
    least_worth : float
        Walks worth less are of no use, where it is.
    reach : CompletionValues
        Most worth that is still to be had, where it is.
    reach_unit : float
        Worth of a unit of these values.
    cuts : CutTolls or None
        What walks pay at a second row; completion values know nothing of it.
    falls : Falls or None
        Losses of prizes with the end of the service, which take off values.
    unit : float
        Prize that a fine unit is worth.
    """

    values: CompletionValues
    shift: np.ndarray
    need: np.ndarray
    gain: np.ndarray
    neighbourhood: np.ndarray
    compared: np.ndarray
    budget: float
    loads: Loads | None
    limits: CountLimits
    price: np.ndarray
    pays: bool
    time_price: float
    since: float
    goal: int
    worths: np.ndarray
    least_worth: float
    reach: CompletionValues
    reach_unit: float
    cuts: CutTolls | None
    falls: Falls | None
    unit: float


class RowOrder(NamedTuple):
    """Order of the rows of a network.

    Attributes
    ----------
    body : (rows,) int32
        Body of each row.
    by_departure : (rows,) int64
        Rows by departure.
    """

    body: np.ndarray
    by_departure: np.ndarray


@inlined
def _layer_of(loads, values, kits):
    """Index of the layer for a number of kits."""
    if loads is None:
        return 0
    return kits * values.layer


@inlined
def _place(loads, values, row, left, kits):
    """Index of the completion values at a row, by ΔV left and kits."""
    slots = min(int(left / values.slot + SLACK), values.top)
    return _layer_of(loads, values, kits) + (values.bucket[row] + 1) * values.width + slots


@inlined
def _completion(values, kind, at, came_from):
    """Most that a walk can still collect without an immediate return [units]."""
    packed = values.best[kind, at]
    if packed & ((1 << values.bits) - 1) == came_from:
        packed = values.second[kind, at]
    return np.int64(packed >> values.bits)


@inlined
def _promises(search, row, has, value, worth, came_from):
    """Whether a walk that is ready by a row can still reach the goal."""
    values = search.values
    at = _place(search.loads, values, row, has.left, has.kits)
    for kind in range(search.need.size):
        most = value + (_completion(values, kind, at, came_from) << FINE)
        if most + np.int64(search.shift[kind] * worth) < search.need[kind]:
            return False
    if not search.pays:
        return True
    at = _place(search.loads, search.reach, row, has.left, has.kits)
    most_worth = _completion(search.reach, 0, at, came_from) * search.reach_unit
    return worth + most_worth >= search.least_worth


@inlined
def _stay(search, labels, waiting, row, i, kept):
    """Drop labels at body i that are too late by a row, and so by all later ones."""
    for k in range(waiting.size[i]):
        label = waiting.label[i, k]
        kept[k] = label >= 0 and _promises(
            search,
            row,
            resources_of(labels, label),
            labels.value[label],
            labels.worth[label],
            labels.came_from[label],
        )
    keep(waiting, i, kept, 2 * search.neighbourhood.shape[1])
    waiting.bucket[i] = search.values.bucket[row]


@inlined
def _after(network, search, row, here, cost):
    """Resources after a leg of a row, whose times are known by row."""
    j = network.destination[row]
    return resource_kernels.extend(
        here, j, network.is_station[j], cost, 0.0, search.loads, search.budget
    )


@inlined
def _time_paid(search, end):
    """Price of time for a walk that ends with a service [fine units]."""
    return np.int64(min(search.time_price * max(end - search.since, 0.0), MOST_PAID))


@inlined
def _useful(network, search, row, value, here, worth, i):
    """Range of the legs of a row that may be useful.

    The later they land, the less they cost. So none is of use that lands too late even for the
    least ΔV of all, nor one that costs too much even for the earliest landing.
    """
    j, first, last = network.destination[row], network.first[row], network.first[row + 1] - 1
    least = network.delta_v[last]
    if least > here.left:
        return first, first
    then = _after(network, search, row, here, least)
    if not is_possible(search.loads, then.left):
        return first, first
    most = value + search.gain[j] - np.int64(search.price[here.kits] * least)
    if not _promises(search, network.landing[first], then, most, worth, i):
        return first, first
    begin, end = first + 1, last + 1
    while begin < end:
        middle = (begin + end) // 2
        if _promises(search, network.landing[middle], then, most, worth, i):
            begin = middle + 1
        else:
            end = middle
    stop = end
    begin, end = first, last
    while begin < end:
        middle = (begin + end) // 2
        cost = network.delta_v[middle]
        most = value + search.gain[j] - np.int64(search.price[here.kits] * cost)
        then = _after(network, search, row, here, cost)
        possible = cost <= here.left and is_possible(search.loads, then.left)
        if possible and _promises(search, network.landing[first], then, most, worth, i):
            end = middle
        else:
            begin = middle + 1
    return end, stop


@kernel
def extend(network, rows, search, labels, pending, waiting, cursor, effort):
    """Extend labels for a while, row by row in order of departure.

    Parameters
    ----------
    network : Network
    rows : RowOrder
    search : LabelQuery
    labels : Labels
    pending : Pending
        Updated.
    waiting : Waiting
        Updated.
    cursor : (3,) int64
        Position in the order, number of labels, extensions tried; updated.
    effort : int
        Extensions to make.

    Returns
    -------
    state : int
        EXHAUSTED when all rows are done, CHUNK_DONE, FULL when there is no room for labels,
        CROWDED when there is none at a body, PILED when there is none on the way. Then the row is
        begun again later; what it has made already dominates its doubles.
    """
    network, search, labels = borrowed(network), borrowed(search), borrowed(labels)
    waiting, pending = borrowed(waiting), borrowed(pending)
    body, order = rows
    cuts = search.cuts
    words = search.neighbourhood.shape[1]
    terms = LabelTerms(search.loads, search.limits, cuts)
    timed = network.end.size > 0
    remembered = np.empty(words, dtype=np.int64)
    target_effort = cursor[2] + effort
    kept = np.empty(waiting.label.shape[1], np.bool_)
    # Whatever arrives in time for a row was made by a row that departs earlier: when its turn
    # comes, all labels that could take its legs have been sent to it or to an earlier row of its
    # body, and none comes later. Closing rows come last, and nothing leaves there.
    while cursor[0] < order.size and network.departure[order[cursor[0]]] < np.inf:
        row = order[cursor[0]]
        i = body[row]
        while next_of(pending, row) >= 0:
            if not arrive(waiting, labels, i, next_of(pending, row), search.compared[i], terms):
                return CROWDED
            take(pending, row, words)
        if waiting.bucket[i] != search.values.bucket[row]:
            _stay(search, labels, waiting, row, i, kept)
        j = network.destination[row]
        to_station, compared = network.is_station[j], search.compared[j]
        behind = -1 if network.is_station[i] else i
        for k in range(waiting.size[i] - 1, -1, -1):
            here = waiting.label[i, k]
            # Who was there by an earlier row could take a leg that is no worse than each of these.
            if here < 0 or labels.row[here] <= network.fresh[row]:
                continue
            if not to_station and labels.memory[here, j // WORD] >> (j % WORD) & 1:
                continue
            has = resources_of(labels, here)
            if not (to_station or resource_kernels.may_service(has, search.limits)):
                continue
            value, collected = labels.value[here], labels.worth[here] + search.worths[j]
            value -= toll_at(cuts, labels, here, search.neighbourhood, j)
            begin, end = _useful(network, search, row, value, has, collected, behind)
            if begin >= end:
                continue
            # What the new label remembers does not depend on the leg. Forgetting only adds walks,
            # so a search that finds none proves that there is none; who has just left is remembered
            # on top.
            for w in range(words):
                remembered[w] = labels.memory[here, w] & search.neighbourhood[j, w]
            count_row(cuts, remembered, j)
            if behind >= 0:
                remembered[i // WORD] |= 1 << (i % WORD)
            for leg in range(begin, end):
                if labels.row[here] <= network.since[leg]:
                    continue
                landing = network.landing[leg]
                then = _after(network, search, row, has, network.delta_v[leg])
                paid = np.int64(search.price[has.kits] * network.delta_v[leg])
                most = value + search.gain[j] - paid
                if search.falls is not None:
                    lost = lost_at(search.falls, j, network.end[leg])
                    most -= np.int64(math.floor(lost / search.unit))
                if not _promises(search, landing, then, most, collected, behind):
                    continue
                cursor[2] += 1
                candidate = Candidate(most, then, collected)
                if is_dominated(waiting, labels, j, candidate, remembered, compared, terms):
                    continue
                preceded = is_preceded(
                    pending, landing, labels, candidate, remembered, compared, terms
                )
                # A label ready by the same row may have been ready later: if the walk ends here,
                # it may pay for less time than the one that dominates it.
                if preceded and not (
                    timed
                    and network.may_end[j]
                    and collected >= search.least_worth
                    and most - _time_paid(search, network.end[leg]) >= search.goal
                ):
                    continue
                count = cursor[1]
                if count == labels.row.size:
                    return FULL
                labels.row[count], labels.parent[count] = landing, here
                labels.value[count], labels.left[count] = most, then.left
                labels.counts[count] = resource_kernels.counts_of(then)
                labels.worth[count] = collected
                labels.came_from[count] = behind
                if timed:
                    labels.final[count] = most - _time_paid(search, network.end[leg])
                for w in range(words):
                    labels.memory[count, w] = remembered[w]
                if not preceded and not send(pending, landing, labels, count):
                    return PILED
                cursor[1] += 1
        cursor[0] += 1
        if cursor[2] >= target_effort:
            break
    else:
        return EXHAUSTED
    return CHUNK_DONE
