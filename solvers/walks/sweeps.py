"""Values of walks, computed backwards in time: the kernels of :mod:`.walks`.

What is left is whole slots here, and all of them are gone through at once: what
:func:`adr_opt.kernels.rules.resources.extend` does to one amount becomes a shift of all, a look at
the slot of a full tank, and the images of :mod:`solvers.networks.layers`.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from adr_opt.kernels.core.compile import inlined, kernel
from adr_opt.kernels.core.events import earliest_taken

from ..networks import simd
from ..networks.layers import after_service, top_of

NEVER = -(2**30)
"""Value of infeasible states, far enough from −2³¹ that additions cannot wrap around."""


class Values(NamedTuple):
    """Values of all states by number of kits aboard, in one layer if loads do not matter.

    A value is packed with the next body of the walk, ``value << bits | next``, so that comparing
    compares values and the better next body comes along. A walk that stops has itself as next.

    Attributes
    ----------
    best : (layers, slots before + buckets·width) int32
        Best walk of (bucket, ΔV slots left); ``width`` numbers before the first one keep reads in
        bounds.
    second : the same shape
        Best walk with another next body: what a chaser that just left the best's next may take.
    landed_best, landed_second : the same shape
        The same just after landing, before the service; the same arrays where a service
        leaves ΔV and kits as they are.
    """

    best: np.ndarray
    second: np.ndarray
    landed_best: np.ndarray
    landed_second: np.ndarray


class WalkTerms(NamedTuple):
    """Gains and costs of walks, with the packing and layout of their values.

    Attributes
    ----------
    code : (bodies,) int32
        What each service is worth, packed with its body as values are.
    toll : (kits + 1 or 1, legs) int32
        What each leg takes off a value [units]; empty for nothing.
    stop : (buckets,) int32
        What a walk that ends in a bucket pays for time, packed; empty for nothing.
    fall : (buckets,) int32 or None
        What a service that ends in a bucket has lost of its prize at least, packed; None, and
        kernels without it, where no prize falls.
    bits : int
        Of the next body in a packed value.
    width, top : int
        Numbers of a bucket, and the slot of a full tank.
    """

    code: np.ndarray
    toll: np.ndarray
    stop: np.ndarray
    fall: np.ndarray | None
    bits: int
    width: int
    top: int


class WalkState(NamedTuple):
    """A state of a walk: bucket, its body, kits aboard, slots of ΔV left."""

    bucket: int
    body: int
    kits: int
    left: int


@inlined
def _fallen(fall, bucket):
    """Loss of prize of a service that ends in a bucket, packed."""
    if fall is None:
        return np.int32(0)
    return fall[bucket]


@kernel
def _sweep_buckets(buckets, layer, terms, toll, full_tank, i, high, low):
    """Values of the buckets ``low`` to ``high`` − 1 (counted within body i), backwards.

    Parameters
    ----------
    layer : Values
        One layer of them, without that axis.
    toll : (legs,) int32
        That of the layer.
    full_tank : int
        Slot of a tank that a station has filled.
    """
    best, second, landed_best, landed_second = layer
    code, stop, bits, width = terms.code, terms.stop, terms.bits, terms.width
    fall = terms.fall
    mask = (1 << bits) - 1
    keep_value = simd.spread(~mask)
    keep_next = simd.spread(mask)
    never = simd.spread(NEVER)
    # From a station nothing is forbidden; no code has all bits set.
    came_from = simd.spread(mask if buckets.is_station[i] else i)
    base = buckets.start[i]
    priced, timed = toll.size > 0, stop.size > 0
    # A leg lands in a later bucket, and waiting leads to the next one, a width further on:
    # backwards, all that is read is done. What is kept of a state are its best value and the best
    # one with another next body. Of all walks that do not go straight back to any one body these
    # two hold the best, and no third is ever needed; that is why what is beaten (the loser) is
    # compared with the second if its next body differs.
    for bucket in range(base + high - 1, base + low - 1, -1):
        begin, end = buckets.first[bucket], buckets.first[bucket + 1]
        for c in range(0, width, simd.LANES):
            # to wait
            found = simd.load(best, (bucket + 2) * width + c)
            other = simd.load(second, (bucket + 2) * width + c)
            if timed:
                # Who stops here has paid for less time than who stops later.
                value = simd.spread(stop[bucket])
                loser = simd.smaller(found, value)
                found = simd.larger(found, value)
                other = simd.larger(other, simd.where_same(found, loser, keep_next, never))
            left = simd.plus(simd.count_up(), simd.spread(c))
            for leg in range(begin, end):
                cost = buckets.cost[leg]
                if c + simd.LANES <= cost:
                    continue
                j = buckets.destination[leg]
                landing = (buckets.landing[leg] + 1) * width
                if buckets.is_station[j]:
                    full = landed_best[landing + full_tank]
                    if full & mask == i:
                        full = landed_second[landing + full_tank]
                    value = simd.both(simd.spread(full), keep_value)
                else:
                    value = simd.load(landed_best, landing + c - cost)
                    instead = simd.load(landed_second, landing + c - cost)
                    value = simd.where_equal(simd.both(value, keep_next), came_from, instead, value)
                    value = simd.both(value, keep_value)
                gain = code[j]
                if priced:
                    gain -= toll[leg] << bits
                gain -= _fallen(fall, buckets.landing[leg])
                value = simd.plus(value, simd.spread(gain))
                value = simd.where_less(left, simd.spread(cost), never, value)
                loser = simd.smaller(found, value)
                found = simd.larger(found, value)
                loser = simd.where_same(found, loser, keep_next, never)
                other = simd.larger(other, loser)
            simd.store(best, (bucket + 1) * width + c, found)
            simd.store(second, (bucket + 1) * width + c, other)


@kernel
def _land(values, layers, width, i, first, last):
    """Values on landing in the buckets ``first`` to ``last`` − 1 of body i."""
    best, second, landed_best, landed_second = values
    for kits in range(best.shape[0]):
        rest = kits - layers.takes[i]
        for at in range((first + 1) * width, (last + 1) * width, width):
            for c in range(width):
                place = np.int64(layers.image[i, kits, c])
                if rest < 0 or place < 0:
                    landed_best[kits, at + c] = landed_second[kits, at + c] = NEVER
                else:
                    landed_best[kits, at + c] = best[rest, at + place]
                    landed_second[kits, at + c] = second[rest, at + place]


@kernel
def begin(buckets, values, layers, terms, begun):
    """Initialise closing buckets, where a walk may only stop; all earlier values are NEVER."""
    stop, width = terms.stop, terms.width
    for array in values:
        array[:, :width] = NEVER
    for i in range(buckets.start.size - 1):
        closing = buckets.start[i + 1] * width
        stops = i if buckets.may_end[i] else NEVER
        if stop.size > 0:
            stops = stop[buckets.start[i + 1] - 1]
        values.best[:, closing : closing + width] = stops
        values.second[:, closing : closing + width] = NEVER
        begun[i] = buckets.start[i + 1] - 1 - buckets.start[i]
        if layers is not None:
            _land(values, layers, width, i, buckets.start[i + 1] - 1, buckets.start[i + 1])


@kernel
def sweep_until(buckets, values, layers, terms, begun, begin, step, time):
    """Values of all buckets from a time on, of every step-th body from ``begin``."""
    toll, width = terms.toll, terms.width
    earliest = earliest_taken(time)
    best, second, landed_best, landed_second = values
    for i in range(begin, buckets.start.size - 1, step):
        high = begun[i]
        low = high
        while low > 0 and buckets.opens[buckets.start[i] + low - 1] >= earliest:
            low -= 1
        for kits in range(best.shape[0]):
            layer = Values(best[kits], second[kits], landed_best[kits], landed_second[kits])
            _sweep_buckets(
                buckets,
                layer,
                terms,
                toll[min(kits, toll.shape[0] - 1)],
                top_of(layers, terms.top, kits),
                i,
                high,
                low,
            )
        if layers is not None:
            _land(values, layers, width, i, buckets.start[i] + low, buckets.start[i] + high)
        begun[i] = low


@kernel
def trace(buckets, values, layers, terms, state, walk):
    """Follow the best walk from a state; returns its length."""
    code, toll, bits, width = terms.code, terms.toll, terms.bits, terms.width
    fall = terms.fall
    bucket, body, kits, left = state
    best, second, landed_best, landed_second = values
    mask = (1 << bits) - 1
    came_from = mask
    length = 0
    while True:
        packed = best[kits, (bucket + 1) * width + left]
        if packed & mask == came_from:
            packed = second[kits, (bucket + 1) * width + left]
        j = packed & mask
        if j == body:
            return length
        # The first leg that yields this value: waiting for it costs nothing.
        onward, leg = -1, buckets.first[bucket]
        while onward < 0:
            if buckets.destination[leg] == j and buckets.cost[leg] <= left:
                rest = left - buckets.cost[leg]
                if buckets.is_station[j]:
                    rest = top_of(layers, terms.top, kits)
                landing = buckets.landing[leg]
                ahead = landed_best[kits, (landing + 1) * width + rest]
                if not buckets.is_station[body] and ahead & mask == body:
                    ahead = landed_second[kits, (landing + 1) * width + rest]
                paid = toll[min(kits, toll.shape[0] - 1), leg] if toll.size > 0 else 0
                paid += _fallen(fall, landing) >> bits
                if (ahead >> bits) + (code[j] >> bits) - paid == packed >> bits:
                    onward = landing
            leg += 1
        walk[length] = j
        length += 1
        kits, left = after_service(layers, j, kits, rest)
        came_from = mask if buckets.is_station[body] else body
        bucket, body = onward, j
