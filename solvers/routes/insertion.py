"""Best insertion of a target into an order, in constant time per position.

As every stop has its earliest and its latest time, a target fits in between two of them if it is
reached from the one and leads to the other in time (Savelsbergh, Annals of Operations Research 4,
1985, for times that are constant). The *gaps* of an order hold side by side what that takes, so
that all but a few are passed by two sums and a comparison.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from adr_opt.kernels.core.compile import inlined, kernel
from adr_opt.kernels.core.memory import borrowed
from adr_opt.kernels.core.windows import opening

from .orders import cost_of, is_start, time_back, time_forth
from .ways import arrives

TIME_SPENT = 1e-3
"""Weight of the time to reach and service a target, as a tie-breaker between equal delays."""

MOST_KNOWN = 600
"""Number of nodes up to which look-ups are cached; beyond it, a cache is slower than they are."""


class Gaps(NamedTuple):
    """Gaps between the stops of an order, by the position of the second stop.

    Attributes
    ----------
    origin : (stops,) int64
        Body of the first stop.
    destination : (stops,) int64
        Body of the second stop, −1 for an end anywhere.
    chaser : (stops,) int64
    ready, latest : (stops,) float64
        When the first stop is done at the earliest, and the second must be at the latest; −inf
        where nothing may be inserted [s].
    due : (stops,) float64
        When the second stop is done so far [s].
    known : (nodes², 4) float64
        What was found last between a target and a stop before it, at target · nodes + stop: when
        that stop was done, the end at the target, the stop after it, and the end there. Most
        insertions are asked for again and again; without rows where there are too many nodes.
    """

    origin: np.ndarray
    destination: np.ndarray
    chaser: np.ndarray
    ready: np.ndarray
    latest: np.ndarray
    due: np.ndarray
    known: np.ndarray


@kernel
def new_gaps(stops, nodes):
    """Storage for the gaps of an order, up to a maximum number of stops."""
    rows = nodes * nodes if nodes <= MOST_KNOWN else 0
    known = np.empty((rows, 4))
    for row in range(rows):
        known[row, 0] = math.nan
    return Gaps(
        np.zeros(stops, np.int64),
        np.zeros(stops, np.int64),
        np.zeros(stops, np.int64),
        np.empty(stops),
        np.empty(stops),
        np.empty(stops),
        known,
    )


@kernel
def find_gaps(ways, terms, order, length, by_slack, gaps):
    """Fill in the gaps of an order; ``by_slack`` as of :func:`best_position`."""
    ways, terms, order = borrowed(ways), borrowed(terms), borrowed(order)
    gaps = borrowed(gaps)
    nodes, chaser = order.nodes, -1
    for p in range(length):
        node = nodes[p]
        gaps.latest[p] = -math.inf
        if is_start(ways, node):
            chaser += 1
            continue
        before, latest = nodes[p - 1], order.late[node]
        gaps.origin[p], gaps.chaser[p] = ways.body[before], chaser
        gaps.destination[p] = ways.body[node]
        gaps.ready[p] = order.early[before]
        gaps.due[p] = latest if by_slack else min(order.early[node], latest)
        if order.visited[chaser] < terms.most[chaser]:
            gaps.latest[p] = latest


@inlined
def _through(ways, gaps, i, j, k, ready, latest):
    """Ends of service at a target between two stops and at the second; +inf if that is late."""
    known, row = gaps.known, j * ways.body.size + i
    keeps = known.shape[0] > 0
    if keeps and known[row, 0] == ready:
        end = known[row, 1]
    else:
        end = arrives(ways, i, j, ready)
        if keeps:
            known[row, 0], known[row, 1], known[row, 2] = ready, end, -1.0
    after = math.inf
    if end <= latest:
        if keeps and known[row, 2] == k:
            after = known[row, 3]
        else:
            after = arrives(ways, j, k, end)
            if keeps:
                known[row, 2], known[row, 3] = k, after
    return end, after


@inlined
def best_position(ways, terms, order, gaps, length, j, passed_over, rng):
    """The position at which a target delays the following stops least, or leaves them most slack.

    Parameters
    ----------
    ways : Ways
    terms : EngineTerms
    order : Order
    gaps : Gaps
        Of the order; by slack, the time that is left counts in place of the delay.
    length : int
        Number of stops.
    j : int
    passed_over : float
        Probability that a position is not looked at; only if it is 0 a second one is asked for.
    rng : numpy.random.Generator

    Returns
    -------
    position, chaser : int
        −1 if it fits nowhere.
    delay, second : float
        By how much later the next stop is done, less the time that it had if that counts, and the
        same at the next best position [s].
    """
    nodes, spent, bodies = order.nodes, order.spent, ways.bodies
    best, least, second, known = -1, math.inf, math.inf, math.inf
    first_end, closes = opening(ways.windows, j) + ways.service[j], ways.closes[j]
    for p in range(1, length):
        # No way is quicker than the least of its pair: most positions need no closer look.
        soonest = gaps.ready[p] + ways.least_into[j * bodies + gaps.origin[p]]
        if soonest > gaps.latest[p]:
            continue
        k = gaps.destination[p]
        onward = ways.least[j * bodies + k] if k >= 0 else 0.0
        latest = min(closes, min(gaps.latest[p], gaps.due[p] + known) - onward)
        if not max(soonest, first_end) <= latest:
            continue
        if passed_over > 0.0 and rng.random() < passed_over:
            continue
        i, k = nodes[p - 1], nodes[p]
        end, after = _through(ways, gaps, i, j, k, gaps.ready[p], latest)
        if not after <= gaps.latest[p]:
            continue
        chaser = gaps.chaser[p]
        more = cost_of(ways, i, j) + cost_of(ways, j, k) - cost_of(ways, i, k)
        if spent[chaser] + more > terms.budget[chaser]:
            continue
        delay = after - gaps.due[p] + TIME_SPENT * (end - gaps.ready[p])
        if delay < least:
            best, least, second = p, delay, least
        elif delay < second:
            second = delay
        known = second if passed_over == 0.0 else least
    return best, (gaps.chaser[best] if best >= 0 else np.int64(-1)), least, second


@kernel
def insert(ways, order, length, j, position, chaser, deadline):
    """Insert a missing target at a position, and update the times that change."""
    ways, order = borrowed(ways), borrowed(order)
    nodes = order.nodes
    source = length
    while nodes[source] != j:
        source += 1
    for p in range(source, position, -1):
        nodes[p] = nodes[p - 1]
    nodes[position] = j
    i, k = nodes[position - 1], nodes[position + 1]
    order.spent[chaser] += cost_of(ways, i, j) + cost_of(ways, j, k) - cost_of(ways, i, k)
    order.visited[chaser] += 1
    time_forth(ways, order, position, length + 1, position + 1)
    time_back(ways, order, position, position - 1, deadline)
