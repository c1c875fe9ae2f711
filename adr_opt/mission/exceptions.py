"""Labels along an order of bodies, and their extension where exceptions are limited.

See docs/model.md section 9.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from ..legs.connections import Connections

FloatArray = npt.NDArray[np.float64]
IntArray = npt.NDArray[np.int64]


class Front(NamedTuple):
    """Undominated labels at the last body of an order.

    Attributes
    ----------
    ready, left, cost : (labels,) float64
        Since when the chaser is free there [s], ascending; ΔV left [m/s]; ΔV of all legs and tows
        [m/s], or, where expenses count, what it has to carry at the start if it ends here [kg].
    parent, taken : (labels,) int64
        Label at the body before, and the connection taken from there.
    spent : (labels,) float64
        ΔV of all legs where expenses count masses, else empty [m/s].
    used : (labels,) int64
        Exceptions among all legs where their number is limited, else empty. Labels are in order of
        this number first.
    """

    ready: FloatArray
    left: FloatArray
    cost: FloatArray
    parent: IntArray
    taken: IntArray
    spent: FloatArray = np.empty(0)
    used: IntArray = np.empty(0, dtype=np.int64)


def by_exceptions(
    here: Front, found: Connections, most: int, followed: Callable[[Front, Connections], Front]
) -> Front:
    """The labels after a move where exceptions are limited.

    With as many exceptions used as before are those that a usual connection leads to, and with one
    more those of an exception. One that dominates another of more exceptions is enough, so both are
    kept only to the end of the move.

    Parameters
    ----------
    here : Front
    found : Connections
    most : int
        Exceptions that may be used.
    followed : callable
        The labels after a move by some connections.
    """
    exceptional = found.revolutions > 0
    parts: list[Front] = []
    for used in range(int(here.used.max(initial=0)) + 2):
        for extra in (0, 1):
            labels = np.flatnonzero(here.used == used - extra)
            rows = np.flatnonzero(exceptional == bool(extra))
            if used > most or not labels.size or not rows.size:
                continue
            some = Front(
                here.ready[labels], here.left[labels], here.cost[labels], labels, labels,
                here.spent[labels] if here.spent.size else here.spent,
            )  # fmt: skip
            front = followed(some, found.at(rows))
            parts.append(
                front._replace(
                    parent=labels[front.parent], taken=rows[front.taken],
                    used=np.full(front.ready.size, used, dtype=np.int64),
                )
            )  # fmt: skip
    if not parts:
        nothing = np.empty(0, dtype=np.int64)
        return Front(np.empty(0), np.empty(0), np.empty(0), nothing, nothing)
    return _least_used(Front._make(map(np.concatenate, zip(*parts, strict=True))))


def _least_used(front: Front) -> Front:
    """Labels without those that another one with no more exceptions dominates, in order."""
    order = np.lexsort((front.ready, front.used))
    kept: list[int] = []
    columns = front.ready, front.left, front.cost
    held = np.empty((3, order.size))
    for label in order:
        ready, left, cost = (column[label] for column in columns)
        size = len(kept)
        better = (held[0, :size] <= ready) & (held[1, :size] >= left) & (held[2, :size] <= cost)
        if not better.any():
            held[:, size] = ready, left, cost
            kept.append(int(label))
    chosen = np.array(kept, dtype=np.int64)
    return Front._make(column[chosen] if column.size else column for column in front)
