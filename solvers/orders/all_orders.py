"""The order of all targets with the earliest end, over all sets of targets.

Of all ways to a target with the same targets done and no more exceptions used the earliest is never
worse than another, as a chaser may wait (Held and Karp, 1962).
"""

from __future__ import annotations

import math

import numpy as np

from adr_opt.kernels.core.compile import kernel

from .quickest_legs import EXCEPTION, USUAL, arrives

MOST_TARGETS = 12
"""Maximum number of targets: their sets are looked at one by one."""


@kernel
def earliest_of_all(legs, start, ready, first, latest):
    """The order with the earliest end, and its end.

    Parameters
    ----------
    legs : QuickestLegs
    start : int
        Body of the start.
    ready : float
        Since when the chaser is free there [s].
    first : int
        Number of the first target; they are the last bodies.
    latest : float
        No order may end later [s].

    Returns
    -------
    order : (targets,) int64
        Bodies; none if no order ends in time.
    end : float
        [s]
    """
    targets, most = legs.bodies - first, legs.exceptions
    sets, levels = 1 << targets, most + 1
    time = np.empty((sets, targets, levels))
    parent = np.full((sets, targets, levels), -1, np.int64)
    for done in range(sets):
        for j in range(targets):
            for used in range(levels):
                time[done, j, used] = math.inf
    for done in range(1, sets):
        for j in range(targets):
            if not (done >> j) & 1:
                continue
            before = done & ~(1 << j)
            for kind in (USUAL, EXCEPTION):
                for used in range(kind, levels):
                    if before == 0:
                        if used == kind:
                            end = arrives(legs, kind, start, first + j, ready)
                            if end <= latest and end < time[done, j, used]:
                                time[done, j, used] = end
                        continue
                    for i in range(targets):
                        known = time[before, i, used - kind]
                        if known < math.inf:
                            end = arrives(legs, kind, first + i, first + j, known)
                            if end <= latest and end < time[done, j, used]:
                                time[done, j, used] = end
                                parent[done, j, used] = i * levels + used - kind
    end, here, used = math.inf, 0, 0
    for j in range(targets):
        for level in range(levels):
            if time[sets - 1, j, level] < end:
                end, here, used = time[sets - 1, j, level], j, level
    if end == math.inf:
        return np.empty(0, np.int64), end
    order = np.empty(targets, np.int64)
    done = sets - 1
    for place in range(targets - 1, -1, -1):
        order[place] = first + here
        back = parent[done, here, used]
        done &= ~(1 << here)
        if place:
            here, used = back // levels, back % levels
    return order, end
