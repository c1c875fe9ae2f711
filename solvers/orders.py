"""An order of targets, timed with the best refuelling stops between them.

Local search works on orders of targets alone. Where to refuel is not searched but solved: on the
way from one target to the next the chaser may pass by the station, and all ways to do so are kept
as *labels* (end of service, ΔV left), less those that are not earlier and not richer than another.
So moving, adding and dropping refuelling stops are part of every evaluation. The order is timed
exactly, but a better timing may be missed: a chaser may not let a departure go by, so one that
is later and poorer now and then meets a cheaper departure.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from adr_opt.kernels import rules as rule_kernels
from adr_opt.kernels.compile import kernel
from adr_opt.kernels.constants import STATION

MOST_LABELS = 6
"""Labels kept at a target: the earliest ones. More are rare, and only cost plans, not legality."""


class Labels(NamedTuple):
    """Labels by position in the order; position 0 is the start at the station.

    Attributes
    ----------
    size : (positions,) int64
        Number of labels.
    end, left : (positions, MOST_LABELS) float64
        End of service [s], ascending, and ΔV left then [m/s], ascending too.
    parent : (positions, MOST_LABELS) int8
        Label of the position before.
    refuels : (positions, MOST_LABELS) bool
        Whether the chaser comes by way of the station.
    """

    size: np.ndarray
    end: np.ndarray
    left: np.ndarray
    parent: np.ndarray
    refuels: np.ndarray


def make_labels(targets: int, budget: float) -> Labels:
    """Labels for orders of up to so many targets, the start filled in."""
    shape = (targets + 1, MOST_LABELS)
    labels = Labels(
        np.zeros(targets + 1, dtype=np.int64),
        np.zeros(shape),
        np.zeros(shape),
        np.zeros(shape, dtype=np.int8),
        np.zeros(shape, dtype=np.bool_),
    )
    labels.size[0] = 1
    labels.left[0, 0] = budget
    return labels


@kernel
def _add(labels, position, count, end, left, parent, refuels):
    """Add a label unless one there is as good; drop those that it makes useless."""
    for a in range(count):
        if labels.end[position, a] <= end and labels.left[position, a] >= left:
            return count
    kept = 0
    for a in range(count):
        if labels.end[position, a] < end or labels.left[position, a] > left:
            if kept < a:
                labels.end[position, kept] = labels.end[position, a]
                labels.left[position, kept] = labels.left[position, a]
                labels.parent[position, kept] = labels.parent[position, a]
                labels.refuels[position, kept] = labels.refuels[position, a]
            kept += 1
    if kept == MOST_LABELS:
        if end >= labels.end[position, kept - 1]:
            return kept
        kept -= 1
    at = kept
    while at > 0 and labels.end[position, at - 1] > end:
        labels.end[position, at] = labels.end[position, at - 1]
        labels.left[position, at] = labels.left[position, at - 1]
        labels.parent[position, at] = labels.parent[position, at - 1]
        labels.refuels[position, at] = labels.refuels[position, at - 1]
        at -= 1
    labels.end[position, at], labels.left[position, at] = end, left
    labels.parent[position, at], labels.refuels[position, at] = parent, refuels
    return kept + 1


@kernel
def extend(rules, order, labels, position):
    """Labels of the target at a position (counted from 0) from those of the one before it.

    Returns
    -------
    count : int
        0 if the target cannot be reached.
    """
    j = order[position]
    i = STATION if position == 0 else order[position - 1]
    count = 0
    for a in range(labels.size[position]):
        end, left = labels.end[position, a], labels.left[position, a]
        fits, delta_v, then = rule_kernels.fits(rules, i, end, left, j)
        if fits:
            count = _add(labels, position + 1, count, then, left - delta_v, a, False)
        if i == STATION:
            continue
        fits, _, then = rule_kernels.fits(rules, i, end, left, STATION)
        if fits:
            fits, delta_v, then = rule_kernels.fits(rules, STATION, then, rules.budget, j)
            if fits:
                rest = rules.budget - delta_v
                count = _add(labels, position + 1, count, then, rest, a, True)
    labels.size[position + 1] = count
    return count


@kernel
def time_order(rules, order, length, start, labels, changed, reference, patience):
    """Labels of the targets from a position on.

    Parameters
    ----------
    order : (targets,) int64
        Its first ``length`` targets are visited.
    start : int
        First position to time; the labels before it are right.
    changed : int
        From here on the order is the reference's again.
    reference : (positions,) float64
        Earliest end at each position in the order compared with [s].
    patience : float
        Give up where the order is the reference's again and still so much later [s].

    Returns
    -------
    end : float
        Earliest end of the last service [s]; +inf if not legal or given up.
    """
    for position in range(start, length):
        if extend(rules, order, labels, position) == 0:
            return np.inf
        if position >= changed and labels.end[position + 1, 0] > reference[position + 1] + patience:
            return np.inf
    return labels.end[length, 0]


@kernel
def with_refuelling(order, length, labels):
    """The sequence of bodies of the label that ends first, refuelling stops included."""
    backwards = np.empty(2 * length, np.int64)
    moves, label = 0, 0
    for position in range(length, 0, -1):
        backwards[moves] = order[position - 1]
        moves += 1
        if labels.refuels[position, label]:
            backwards[moves] = STATION
            moves += 1
        label = labels.parent[position, label]
    return backwards[:moves][::-1].copy()
