"""An order of targets, timed with optimal refuelling stops between them.

Local search works on orders of targets alone. Where to refuel is not searched but solved: on the
way from one target to the next the chaser may pass by a station, and all ways to do so are kept
as *labels* (their resources), less those that another one dominates.
So moving, adding and dropping refuelling stops are part of every evaluation. The order is timed on
the timetable of the mission's choice; when to fly it best is for the schedule to say.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from adr_opt.kernels.core.compile import inlined, kernel
from adr_opt.kernels.core.memory import borrowed
from adr_opt.kernels.rules import rules as rule_kernels
from adr_opt.kernels.rules.resources import Resources, dominates
from adr_opt.kernels.rules.rules import State
from adr_opt.mission.mission import Mission

from ..beams.levels import STRAIGHT

MOST_LABELS = 6
"""Maximum number of labels per target, the earliest ones. More are rare, and dropping them only
costs quality, not legality."""


class OrderLabels(NamedTuple):
    """Labels by position in the order; position 0 is the start at the station.

    Attributes
    ----------
    size : (positions,) int64
        Number of labels.
    time, left : (positions, MOST_LABELS) float64
        End of service [s], ascending, and ΔV left then [m/s], ascending too: of the resources those
        that the position does not tell.
    parent : (positions, MOST_LABELS) int8
        Label of the position before.
    via : (positions, MOST_LABELS) int16
        Station that the chaser comes by, or STRAIGHT.
    """

    size: np.ndarray
    time: np.ndarray
    left: np.ndarray
    parent: np.ndarray
    via: np.ndarray


def make_labels(mission: Mission) -> OrderLabels:
    """Labels for orders of a mission's targets, with the start filled in."""
    targets, rules = len(mission.instance.targets), mission.rules
    shape = (targets + 1, MOST_LABELS)
    labels = OrderLabels(
        np.zeros(targets + 1, dtype=np.int64),
        np.zeros(shape),
        np.zeros(shape),
        np.zeros(shape, dtype=np.int8),
        np.zeros(shape, dtype=np.int16),
    )
    labels.size[0] = 1
    labels.time[0, 0], labels.left[0, 0] = rules.ready, rules.budget
    return labels


@inlined
def _has(labels, position, place):
    """Resources of a label: a service at each position, and no kits.

    With the first one a chaser may refuel; whether it has done so on the way is no matter then.
    """
    done = np.int64(position)
    return Resources(
        labels.time[position, place], labels.left[position, place], done, done, np.int64(0)
    )


@inlined
def _write(labels, position, place, has, parent, via):
    """Write a label to an index."""
    labels.time[position, place], labels.left[position, place] = has.time, has.left
    labels.parent[position, place], labels.via[position, place] = parent, via


@inlined
def _move(labels, position, place, to):
    """Move a label to another index."""
    parent, via = labels.parent[position, place], labels.via[position, place]
    _write(labels, position, to, _has(labels, position, place), parent, via)


@kernel
def _add(labels, position, count, has, parent, via, rules):
    """Add a label unless dominated, and drop those that it dominates."""
    labels = borrowed(labels)
    for a in range(count):
        if dominates(_has(labels, position, a), has, rules.loads, rules.limits):
            return count
    kept = 0
    for a in range(count):
        if not dominates(has, _has(labels, position, a), rules.loads, rules.limits):
            if kept < a:
                _move(labels, position, a, kept)
            kept += 1
    if kept == MOST_LABELS:
        if has.time >= labels.time[position, kept - 1]:
            return kept
        kept -= 1
    at = kept
    while at > 0 and labels.time[position, at - 1] > has.time:
        _move(labels, position, at - 1, at)
        at -= 1
    _write(labels, position, at, has, parent, via)
    return kept + 1


@kernel
def extend(rules, order, labels, position):
    """Labels at a position (from 0) of an order, extended from the previous one.

    Returns
    -------
    count : int
        0 if the target cannot be reached.
    """
    rules, labels = borrowed(rules), borrowed(labels)
    j = order[position]
    i = np.int64(rules.start if position == 0 else order[position - 1])
    count = 0
    for a in range(labels.size[position]):
        here = State(i, _has(labels, position, a))
        legal, _, then = rule_kernels.step(rules, here, j)
        if legal:
            count = _add(labels, position + 1, count, then.resources, a, STRAIGHT, rules)
        for s in range(rules.stations):
            if s == i:
                continue
            legal, _, full = rule_kernels.step(rules, here, s)
            if legal:
                legal, _, then = rule_kernels.step(rules, full, j)
                if legal:
                    count = _add(labels, position + 1, count, then.resources, a, s, rules)
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
        Give up where the order is the reference's again and still later by this [s].

    Returns
    -------
    end : float
        Earliest end of the last service [s]; +inf if not legal or given up.
    """
    labels, reference = borrowed(labels), borrowed(reference)
    ends = labels.time
    for position in range(start, length):
        if extend(rules, order, labels, position) == 0:
            return np.inf
        if position >= changed and ends[position + 1, 0] > reference[position + 1] + patience:
            return np.inf
    return ends[length, 0]


@kernel
def with_refuelling(order, length, labels):
    """Sequence of bodies of the label with the earliest end, refuelling stops included."""
    backwards = np.empty(2 * length, np.int64)
    moves, label = 0, 0
    for position in range(length, 0, -1):
        backwards[moves] = order[position - 1]
        moves += 1
        if labels.via[position, label] != STRAIGHT:
            backwards[moves] = labels.via[position, label]
            moves += 1
        label = labels.parent[position, label]
    return backwards[:moves][::-1].copy()
