"""ng augmentation at the end of a search: the best walk, and memory that would forbid its cycles.

A walk that visits a target twice is forbidden as soon as all bodies in between remember it. Every
memory makes fewer labels comparable, so only short cycles are forbidden: of each walk those that
few more memories forbid. Often the walks looked at after it are forbidden by then, too.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from adr_opt.kernels.core.compile import inlined, kernel
from adr_opt.kernels.core.memory import borrowed
from adr_opt.mission.evidence import WORD

SHORT = 4
"""Cycles that need at most this number of additional memories are all forbidden, and one of any."""


class WalkThreshold(NamedTuple):
    """Thresholds of walks that count.

    Attributes
    ----------
    value : int
        [fine units].
    worth : float
        Of their targets.
    """

    value: int
    worth: float


@kernel
def path_of(labels, body, label, path):
    """Bodies of a label's walk in order; returns their number."""
    length = 0
    while labels.parent[label] >= 0:
        path[length] = body[labels.row[label]]
        length += 1
        label = labels.parent[label]
    for a in range(length // 2):
        path[a], path[length - 1 - a] = path[length - 1 - a], path[a]
    return length


@inlined
def _value(network, labels, body, label, least_worth):
    """Value of a walk; −2⁶² if it does not count.

    It counts if it is worth enough, and at a body where a mission may end. What it is worth beyond
    the least counts, too: labels are compared by it, so one that is worth more may have taken the
    place of one that costs less.
    """
    if labels.worth[label] < least_worth or not network.may_end[body[labels.row[label]]]:
        return np.int64(-(2**62))
    return labels.final[label]


@inlined
def _missing(path, begin, end, neighbourhood):
    """Number of bodies between two visits of a target that do not remember it."""
    j = path[end]
    missing = 0
    for b in range(begin + 1, end):
        missing += not neighbourhood[path[b], j // WORD] >> (j % WORD) & 1
    return missing


@inlined
def _forbid(network, path, length, neighbourhood, seen, most):
    """Forbid cycles of a walk that need at most a number of memories; −1 forbids none.

    Returns
    -------
    fewest : int
        Fewest memories that forbid the walk: 0 if it is forbidden already, −1 if it is a plan.
    grown : int
        Memories added.
    """
    for j in range(seen.size):
        seen[j] = -1
    fewest, grown = -1, 0
    for a in range(length):
        j = path[a]
        if network.is_station[j]:
            continue
        if seen[j] >= 0:
            missing = _missing(path, seen[j], a, neighbourhood)
            if fewest < 0 or missing < fewest:
                fewest = missing
            if missing <= most:
                grown += missing
                for b in range(seen[j] + 1, a):
                    neighbourhood[path[b], j // WORD] |= 1 << (j % WORD)
        seen[j] = a
    return fewest, grown


@kernel
def learn(network, labels, body, count, least, most_walks, neighbourhood, path):
    """Examine walks above a threshold, and let bodies within their cycles remember the targets.

    Parameters
    ----------
    network : Network
    labels : Labels
    body : (rows,) int32
        Body of each row.
    count : int
        Number of labels.
    least : WalkThreshold
        Other walks are not looked at.
    most_walks : int
        Walks to learn from, spread evenly over all of them: neighbours share their cycles.
    neighbourhood : (bodies, words) int64
        Updated.
    path : (legs,) int64
        Written: the bodies of the walk of greatest value that has no cycle and ends where a mission
        may end.

    Returns
    -------
    length : int
        Number of its legs; −1 if there is no such walk.
    grown : int
        How many memories were added.
    """
    network, labels, body = borrowed(network), borrowed(labels), borrowed(body)
    walks = 0
    for label in range(count):
        walks += _value(network, labels, body, label, least.worth) >= least.value
    stride = max(1, walks // most_walks)
    seen = np.empty(neighbourhood.shape[0], dtype=np.int64)
    plan, grown, number, most = -1, 0, 0, least.value - 1
    for label in range(count):
        value = _value(network, labels, body, label, least.worth)
        if value < least.value:
            continue
        number += 1
        length = path_of(labels, body, label, path)
        fewest, _ = _forbid(network, path, length, neighbourhood, seen, -1)
        if fewest < 0:
            if value > most:
                plan, most = label, value
        elif fewest > 0 and number % stride == 0:
            grown += _forbid(network, path, length, neighbourhood, seen, max(fewest, SHORT))[1]
    return (path_of(labels, body, plan, path) if plan >= 0 else -1), grown


@kernel
def plans_of(network, labels, body, count, least, bodies, path, found):
    """Labels above a threshold whose walks are plans; returns their number.

    Parameters
    ----------
    network, labels, body, count, least, path
        As of :func:`learn`.
    bodies : int
    found : (labels,) int32
        Written.
    """
    network, labels, body = borrowed(network), borrowed(labels), borrowed(body)
    remembers_nothing = np.zeros((bodies, 1 + bodies // WORD), dtype=np.int64)
    seen = np.empty(bodies, dtype=np.int64)
    plans = 0
    for label in range(count):
        if _value(network, labels, body, label, least.worth) < least.value:
            continue
        length = path_of(labels, body, label, path)
        if _forbid(network, path, length, remembers_nothing, seen, -1)[0] < 0:
            found[plans] = label
            plans += 1
    return plans


@kernel
def most_of(network, labels, body, count, least):
    """Greatest value of walks that count, see :func:`_value`; the threshold if all are below."""
    network, labels, body = borrowed(network), borrowed(labels), borrowed(body)
    best = least.value
    for label in range(count):
        best = max(best, _value(network, labels, body, label, least.worth))
    return best
