"""The order of all targets with the earliest end, over all sets of targets.

Of all ways to a target with the same targets done the earliest is never worse than another, as a
chaser may wait (Held and Karp, 1962).
"""

from __future__ import annotations

import math

import numpy as np

from adr_opt.kernels.core.compile import kernel

from .quickest_legs import arrives

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
    targets = legs.bodies - first
    sets = 1 << targets
    time = np.empty((sets, targets))
    parent = np.full((sets, targets), -1, np.int64)
    for done in range(sets):
        for j in range(targets):
            time[done, j] = math.inf
    for done in range(1, sets):
        for j in range(targets):
            if not (done >> j) & 1:
                continue
            before = done & ~(1 << j)
            if before == 0:
                end = arrives(legs, start, first + j, ready)
                if end <= latest:
                    time[done, j] = end
                continue
            for i in range(targets):
                known = time[before, i]
                if known < math.inf:
                    end = arrives(legs, first + i, first + j, known)
                    if end <= latest and end < time[done, j]:
                        time[done, j], parent[done, j] = end, i
    end, here = math.inf, 0
    for j in range(targets):
        if time[sets - 1, j] < end:
            end, here = time[sets - 1, j], j
    if end == math.inf:
        return np.empty(0, np.int64), end
    order = np.empty(targets, np.int64)
    done = sets - 1
    for place in range(targets - 1, -1, -1):
        order[place] = first + here
        before = parent[done, here]
        done &= ~(1 << here)
        here = before
    return order, end
