"""Ruin and recreate for the earliest end of all targets.

Strings of targets are taken out of an order (:func:`.string_removal.ruin`) and put back where most
time is left, before a deadline that is drawn first: as early as the annealing would accept. While
not all targets are in, an order with others missing is accepted if those were missing less often
so far (Christiaens and Vanden Berghe, Transportation Science 54, 2020). The end says little where a
chaser waits for a connection late in the mission: what is gained before is not seen there. So the
mean slack of the targets counts as well.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from adr_opt.kernels.core.compile import kernel
from adr_opt.kernels.core.lists import rising
from adr_opt.kernels.core.memory import borrowed, write

from . import earliest_order
from .string_removal import ruin

PASSED_OVER = 0.05
"""Probability that a position is skipped."""


RENEWED = 20
"""Iterations after which another deadline is drawn, if no order was accepted before."""


MORE = 2.0
"""How much later than the annealing accepts an order may end that has more slack, as a multiple."""


class Cooling(NamedTuple):
    """Temperatures of a run, and its work.

    Attributes
    ----------
    hot, cold : float
        How much later an order may end, at first and at last [s].
    iterations : int
    latest : float
        No order may end later [s].
    spare : float
        What a second of mean slack is worth, in seconds of the end.
    """

    hot: float
    cold: float
    iterations: int
    latest: float
    spare: float


@kernel
def _recreate(legs, course, start, length, deadline, missed, rng):
    """Put missing targets in as far as they fit; returns how many are visited."""
    order = course.order
    total = order.size - length
    weight = np.empty(total)
    by_need = rng.random() < 0.5
    for place in range(total):
        weight[place] = rng.random()
        if by_need:
            weight[place] *= -missed[order[length + place]] - 1.0
    ranks = rising(weight, total)
    wanted = np.empty(total, np.int64)
    for place in range(total):
        wanted[place] = order[length + ranks[place]]
    for place in range(total):
        j = wanted[place]
        position = earliest_order.best_position(
            legs, course, start, length, j, deadline, PASSED_OVER, rng
        )
        if position < 0:
            continue
        source = length
        while order[source] != j:
            source += 1
        earliest_order.insert(course, source, position)
        length += 1
        earliest_order.time_forth(legs, course, start, length, position, position + 1)
        earliest_order.time_back(legs, course, start, length, position + 1, position, deadline)
    return length


@kernel
def _burden(order, length, missed):
    """How often the targets that are missing were missing."""
    total = 0.0
    for p in range(length, order.size):
        total += 1.0 + missed[order[p]]
    return total


@kernel
def _value(legs, course, start, spare):
    """End of an order of all targets, less what its mean slack is worth [s]."""
    order = course.order
    end = course.early[order[order.size - 1]]
    if spare == 0.0:
        return end
    earliest_order.time_back(legs, course, start, order.size, order.size, -1, end)
    total = 0.0
    for j in order:
        total += course.late[j] - course.early[j]
    return end - spare * total / order.size


@kernel
def search(legs, start, ready, order, length, near, missed, annealing, rng, halt):  # noqa: PLR0913
    """Improve an order.

    Parameters
    ----------
    legs : QuickestLegs
    start : int
        Body of the start.
    ready : float
        Since when the chaser is free there [s].
    order : (targets,) int64
        All targets: those visited in order, then the others. Left as the last order accepted.
    length : int
        How many are visited; they can be done by the latest end.
    near : (bodies, targets) int64
        Targets by how near they are to each body, itself first.
    missed : (bodies,) float64
        How often each target was missing; updated.
    annealing : Cooling
    rng : numpy.random.Generator
    halt : (1,) bool
        Once another thread sets it, the search ends.

    Returns
    -------
    best : (visited,) int64
        The order with most targets, of those the earliest.
    end : float
        Its end [s].
    length : int
        Targets visited by the last order accepted.
    """
    legs, near = borrowed(legs), borrowed(near)
    targets = order.size
    here = earliest_order.new_order(order, start, ready, legs.bodies)
    there = earliest_order.new_order(order, start, ready, legs.bodies)
    earliest_order.time_forth(legs, here, start, length, 0, length)
    while length > 0 and not here.early[here.order[length - 1]] <= annealing.latest:
        length -= 1
    earliest_order.number(here, length)
    end = here.early[here.order[length - 1]] if length > 0 else ready
    best, best_end = here.order[:length].copy(), end
    deadline, later, since = annealing.latest, 0.0, RENEWED
    value = math.inf
    if length == targets:
        value = _value(legs, here, start, annealing.spare)
    for iteration in range(annealing.iterations):
        if halt[0]:
            break
        since += 1
        if since > RENEWED:
            since = 0
            share = iteration / annealing.iterations
            allowed = annealing.hot * (annealing.cold / annealing.hot) ** share
            if length == targets:
                later = -allowed * math.log(1.0 - rng.random())
                deadline = min(end + MORE * later, annealing.latest)
            earliest_order.time_back(legs, here, start, length, length, -1, deadline)
            earliest_order.copy_order(here, there)
        size, first, last = length, 0, 0
        if length > 0:
            size, first, last = ruin(there.order, length, near, rng)
        earliest_order.number(there, size)
        earliest_order.time_forth(legs, there, start, size, first, last)
        earliest_order.time_back(legs, there, start, size, last, first, deadline)
        taken = False
        if there.late[start] >= there.early[start]:
            size = _recreate(legs, there, start, size, deadline, missed, rng)
            if size == targets:
                new = _value(legs, there, start, annealing.spare)
                taken = new <= value + later or length < targets
                if taken:
                    value = new
            elif length < targets:
                taken = _burden(there.order, size, missed) <= _burden(here.order, length, missed)
        for p in range(size, targets):
            missed[there.order[p]] += 1.0
        if taken:
            length, since = size, RENEWED if size == targets else since
            end = there.early[there.order[length - 1]]
            earliest_order.copy_order(there, here)
            if length > best.size or (length == best.size and end < best_end):
                best, best_end = here.order[:length].copy(), end
        else:
            earliest_order.copy_order(here, there)
    write(order, here.order)
    return best, best_end, length
