"""Best schedule of an order of bodies: labels along the order, over all connections.

An order says where to go, not when: at each body the chaser may wait for any connection to the next
one. A *label* is a way to have got so far: (ready, ΔV left, cost). One that is ready no later, has
no less left and cost no more makes another one superfluous, exactly, because a chaser may wait.
So connections are gone through in order of departure, and each is taken by those labels only that
are ready for it and that no other ready one beats in (ΔV left, cost).

The cost is ΔV; or, where expenses count, the least mass that a chaser has to start with that ends
here [kg], of what is left and the kits that are still aboard. A leg makes that one greater by what
it weighs to have been flown so far: the mass without propellant, times exp(ΔV so far / g₀ Isp),
times exp(ΔV / g₀ Isp) − 1. Of two ways that leave as many kits aboard, let one have no less left
and need no more if it ended here. Whatever follows, it needs no more: for what has to be left for
that the need of both is linear in the mass that has to be left, the first one needs no more at the
least such mass, and at the greatest one that the second has it does not need its whole tank, as the
second does.

Where prizes fall, what is lost of them comes before the cost, in one number: see :class:`Visit`.
"""

import math
from typing import NamedTuple

import numpy as np

from ..core.compile import inlined, kernel
from ..core.events import earliest_taken
from ..core.lists import chosen, first_at, rising, wider
from ..core.windows import Windows, service_end
from .falls import Falls, lost_at
from .resources import Resources, extend


@kernel
def _into(staircase_left, staircase_cost, names, size, left, cost, name):
    """Insert (left, cost) into a staircase where more ΔV left costs more; returns its size, or −1.

    −1 means that a stair is at least as good. This is :func:`.resources.dominates`, with the cost,
    for labels sorted by ready time and with equal cargo: bisection finds the one stair to compare.
    """
    low = first_at(staircase_left, 0, size, left)
    # Stairs from ``low`` on have as much left: the first is the cheapest of them.
    if low < size and staircase_cost[low] <= cost:
        return -1
    first = low
    while first > 0 and staircase_cost[first - 1] >= cost:
        first -= 1
    last = low
    if last < size and staircase_left[last] == left:
        last += 1
    shift = 1 - (last - first)
    if shift > 0:
        for q in range(size, first, -1):
            staircase_left[q], staircase_cost[q] = staircase_left[q - 1], staircase_cost[q - 1]
            names[q] = names[q - 1]
    elif shift < 0:
        for q in range(last, size):
            staircase_left[q + shift], staircase_cost[q + shift] = (
                staircase_left[q],
                staircase_cost[q],
            )
            names[q + shift] = names[q]
    staircase_left[first], staircase_cost[first], names[first] = left, cost, name
    return size + shift


@kernel
def undominated(ready, left, cost, count):
    """Labels that are not dominated by any earlier one.

    Of labels that are ready together a later one may beat an earlier one: harmless.

    Parameters
    ----------
    ready, left, cost : (count or more,) float64
    count : int

    Returns
    -------
    order : (count,) int64
        In order of the time ready; the first ``kept`` of it count.
    kept : int
    """
    order = rising(ready, count)
    best_left, best_cost = np.empty(count), np.empty(count)
    names = np.empty(count, np.int64)
    size, kept = 0, 0
    for place in range(count):
        which = order[place]
        grown = _into(best_left, best_cost, names, size, left[which], cost[which], which)
        if grown >= 0:
            size = grown
            order[kept] = which
            kept += 1
    return order, kept


class Visit(NamedTuple):
    """The next body of an order, as a stop.

    Attributes
    ----------
    body, kits : int
        The body, and the kits aboard on the way there.
    service : float
        Time at it [s].
    windows : Windows
        When services may begin.
    refuels : bool
        Whether it is at a station, where the tank is filled.
    budget : float
        As in :class:`.rules.Rules` [m/s].
    falls : Falls or None
        Losses of prizes, in units that exceed any cost, so that added to it they come first.
    caps : (connections,) float64 or None
        Most ΔV that may be left before each connection, as it is for lighter chasers alone; what is
        left beyond that is vented [m/s]. None, and kernels without them, where nothing is capped.
    """

    body: int
    kits: int
    service: float
    windows: Windows
    refuels: bool
    budget: float
    falls: Falls | None = None
    caps: np.ndarray | None = None


@inlined
def _capped(caps, c, left):
    """ΔV left before a connection, after venting [m/s]."""
    if caps is None:
        return left
    return min(left, caps[c])


@inlined
def _has_vented(caps, c, left):
    """Whether propellant is vented before a connection, or the cap is met exactly."""
    if caps is None:
        return False
    return left >= caps[c]


@kernel
def follow(ready, left, cost, weight, connections, visit, loads):
    """Labels at the next body of an order.

    Parameters
    ----------
    ready, left, cost : (labels,) float64
        Labels at the body before, in order of the time ready [s], [m/s], [m/s or kg].
    weight : (labels,) float64
        What one of the price of a connection adds to the cost of each; empty for one.
    connections : tuple of (connections,) float64
        Departure [s], arrival [s], ΔV [m/s] and price of the pair, in order of departure.
    visit : Visit
    loads : Loads or None

    Returns
    -------
    ready, left, cost : (labels,) float64
        None dominates another, in order of the time ready.
    parent, taken : (labels,) int64
        Label before, and connection.
    """
    departure, arrival, delta_v, price = connections
    body, kits, service, windows, refuels, budget, falls, caps = visit
    alike = weight.size == 0
    room = 256
    ends, lefts, costs = np.empty(room), np.empty(room), np.empty(room)
    parents, takens = np.empty(room, np.int64), np.empty(room, np.int64)
    count = 0
    front_left, front_cost = np.empty(ready.size), np.empty(ready.size)
    front = np.empty(ready.size, np.int64)
    size, label = 0, 0
    for c in range(departure.size):
        while label < ready.size and earliest_taken(ready[label]) <= departure[c]:
            grown = _into(front_left, front_cost, front, size, left[label], cost[label], label)
            if grown >= 0:
                size = grown
            label += 1
        end = service_end(windows, body, arrival[c], service)
        if end == math.inf or delta_v[c] > _capped(caps, c, math.inf):
            continue
        lost = lost_at(falls, body, end)
        # The stairs that can afford it; where the tank is filled the cheapest of them is enough, if
        # all pay as much.
        low = first_at(front_left, 0, size, delta_v[c])
        last = min(low + 1, size) if refuels and alike else size
        for stair in range(low, last):
            here = Resources(departure[c], _capped(caps, c, front_left[stair]), 0, 0, kits)
            rest = extend(here, body, refuels, delta_v[c], end, loads, budget).left
            if rest < 0.0:
                continue
            if count == room:
                ends, lefts, costs = wider(ends, count), wider(lefts, count), wider(costs, count)
                parents, takens = wider(parents, count), wider(takens, count)
                room = ends.size
            ends[count] = end
            lefts[count] = rest
            paid = price[c] if alike else weight[front[stair]] * price[c]
            costs[count] = front_cost[stair] + paid + lost
            parents[count], takens[count] = front[stair], c
            count += 1
            # Of those that have to vent down to as much, the first is the cheapest, if all pay
            # as much.
            if alike and _has_vented(caps, c, front_left[stair]):
                break
    order, kept = undominated(ends, lefts, costs, count)
    return (
        chosen(ends, order, kept),
        chosen(lefts, order, kept),
        chosen(costs, order, kept),
        chosen(parents, order, kept),
        chosen(takens, order, kept),
    )
