"""Network of walks: rows of a body are aggregated into time buckets, and ΔV into slots.

Both only widen what is allowed. A walk at a body by the last row of a bucket is there by its first
one, so it may take all legs of the bucket; a leg costs its whole slots only. Many legs thus become
superfluous: those that cost no less in slots than another one to the same body, leave no later and
land in no earlier bucket. What is left is some times smaller than the network of all connections,
and so are the values of its states.
"""

from __future__ import annotations

import math
from concurrent.futures import ThreadPoolExecutor
from typing import NamedTuple

import numpy as np

from adr_opt.kernels.core.compile import kernel

from .arrays import Network, joined
from .layers import SLACK

LONGEST = 0.5
"""Largest share of the shortest leg that a bucket may span, so that none lands where it left."""


class Buckets(NamedTuple):
    """Buckets by body and time, with their undominated legs.

    One bucket more closes each body, where nothing leaves any more.

    Attributes
    ----------
    start : (bodies + 1,) int64
        First bucket of each body.
    of_row : (rows,) int32
        Bucket of each row of the network.
    opens, closes : (buckets,) float64
        First and last departure [s]; +inf in closing buckets.
    first : (buckets + 1,) int64
        First leg of each bucket.
    destination : (legs,) int32
    landing : (legs,) int32
        Bucket of the destination at the end of service.
    cost : (legs,) int32
        [slots].
    least : (legs,) float64
        Least ΔV of any leg between the same bodies in the same step of ΔV [m/s].
    is_station, may_end : (bodies,) bool
        As in :class:`adr_opt.kernels.rules.rules.Rules`.
    roots : (starts,) int32
        Bucket in which each of the missions begins that move on them.
    shortest : float
        No leg lands in a bucket that opens less than this after the one that it leaves [s].
    """

    start: np.ndarray
    of_row: np.ndarray
    opens: np.ndarray
    closes: np.ndarray
    first: np.ndarray
    destination: np.ndarray
    landing: np.ndarray
    cost: np.ndarray
    least: np.ndarray
    is_station: np.ndarray
    may_end: np.ndarray
    roots: np.ndarray
    shortest: float


@kernel
def _assign(network, length, start, of_row):
    """Assign rows to buckets of a length."""
    bucket = 0
    for i in range(network.start.size - 1):
        start[i] = bucket
        closing = network.start[i + 1] - 1
        for row in range(network.start[i], closing):
            if row > network.start[i]:
                now, before = network.departure[row], network.departure[row - 1]
                if length == 0.0 or math.floor(now / length) > math.floor(before / length):
                    bucket += 1
            of_row[row] = bucket
        bucket += closing > network.start[i]
        of_row[closing] = bucket
        bucket += 1
    start[network.start.size - 1] = bucket


@kernel
def _look_up(delta_v, landing, of_row, parts, slot, prices, buckets):
    """ΔV steps and landing buckets of legs: short loops that do not wait for memory."""
    for leg in range(prices.size):
        prices[leg] = max(0.0, math.floor(parts * delta_v[leg] / slot - SLACK))
    for leg in range(buckets.size):
        buckets[leg] = of_row[landing[leg]]


@kernel
def _keep(network, start, of_row, i, slot, parts, steps):
    """Undominated legs of body i.

    Returns
    -------
    first : (buckets of the body,) int64
        Without the closing one.
    destination, landing, cost : (legs kept,) int32
    least : (legs kept,) float64
    """
    bodies = network.start.size - 1
    low, high = network.start[i], network.start[i + 1] - 1
    base = start[i]
    never = np.int32(2**31 - 1)
    # Earliest landing bucket of the later legs to a body, by the most steps that they cost.
    earliest = np.full((bodies, steps), never, np.int32)
    cheapest = np.full((bodies, steps), np.inf)
    most = network.first[high] - network.first[low]
    # Filled from the end.
    destination, landing = np.empty(most, np.int32), np.empty(most, np.int32)
    cost, least = np.empty(most, np.int32), np.empty(most)
    first = np.empty(start[i + 1] - base, np.int64)
    at = most
    before = network.first[low]
    delta_v = network.delta_v[before : before + most]
    prices, buckets = np.empty(most, np.int32), np.empty(most, np.int32)
    _look_up(delta_v, network.landing[before : before + most], of_row, parts, slot, prices, buckets)
    for row in range(high - 1, low - 1, -1):
        j = network.destination[row]
        for leg in range(network.first[row] - before, network.first[row + 1] - before):
            price, there = prices[leg], buckets[leg]
            cheapest[j, price] = min(cheapest[j, price], delta_v[leg])
            if earliest[j, price] <= there:
                continue
            at -= 1
            destination[at], landing[at], cost[at] = j, there, price
            for c in range(price, steps):
                if earliest[j, c] <= there:
                    break
                earliest[j, c] = there
        first[of_row[row] - base] = at
    first[first.size - 1] = most
    for leg in range(at, most):
        least[leg] = cheapest[destination[leg], cost[leg]]
        cost[leg] //= parts
    return (
        first - at,
        destination[at:].copy(),
        landing[at:].copy(),
        cost[at:].copy(),
        least[at:].copy(),
    )


class Assignment(NamedTuple):
    """Assignment of rows to buckets.

    Attributes
    ----------
    start : (bodies + 1,) int64
    of_row : (rows,) int32
        As in :class:`Buckets`.
    length : float
        [s].
    """

    start: np.ndarray
    of_row: np.ndarray
    length: float


def assign(network: Network, share: float) -> Assignment:
    """Assign the rows of a network to buckets.

    Parameters
    ----------
    network : Network
    share : float
        Length of a bucket as a share of the shortest leg; 0 for exact times.
    """
    length = min(share, LONGEST) * network.shortest
    start = np.empty(network.start.size, dtype=np.int64)
    of_row = np.empty(network.departure.size, dtype=np.int32)
    _assign(network, length, start, of_row)
    return Assignment(start, of_row, length)


def build(
    network: Network,
    assignment: Assignment,
    budget: float,
    slot_m_s: float,
    *,
    parts: int,
    jobs: int,
) -> Buckets:
    """Build the network of walks.

    Parameters
    ----------
    network : Network
    assignment : Assignment
    budget : float
        [m/s].
    slot_m_s : float
        Slot of ΔV [m/s].
    parts : int
        Number of ΔV steps that legs are told apart in within each slot.
    jobs : int
        Threads. The result does not depend on it.
    """
    start, of_row, length = assignment
    steps = (math.floor(budget / slot_m_s + SLACK) + 1) * parts
    bodies = network.start.size - 1
    new = np.flatnonzero(np.diff(of_row)) + 1  # rows that open a bucket, but the first
    first_rows, last_rows = np.append(0, new), np.append(new - 1, of_row.size - 1)
    with ThreadPoolExecutor(jobs) as pool:
        kept = list(
            pool.map(
                lambda i: _keep(network, start, of_row, i, slot_m_s, parts, steps), range(bodies)
            )
        )
    return Buckets(
        start,
        of_row,
        network.departure[first_rows],
        network.departure[last_rows],
        joined([each[0] for each in kept]),
        np.concatenate([each[1] for each in kept]),
        np.concatenate([each[2] for each in kept]),
        np.concatenate([each[3] for each in kept]),
        np.concatenate([each[4] for each in kept]),
        network.is_station,
        network.may_end,
        of_row[network.roots],
        network.shortest - length,
    )
