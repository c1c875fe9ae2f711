"""Upper bounds on the units a walk can still collect, by body, time, ΔV left and kits.

One pass backwards in time, with times in *steps* and ΔV in *slots*, always so that walks may do
more than chasers. A walk ready within a step may take everything that leaves in it; a leg costs its
whole slots only, and a tank holds all that it begins, before a service and after it. So no walk
collects more than is said here, and labels that even with this much would collect too little need
not be followed (:mod:`.labels`).
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from fractions import Fraction
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from ...common.constants import SLACK_S
from ...common.memory import available_bytes
from ...kernels.core.compile import inlined, kernel
from .cargo import after_service, changes, is_unused
from .legs import Legs

SLOT_SLACK = 1e-9
"""Rounding guard of slots, in favour of the walk [slots]."""

NEVER = -(2**30)
"""Packed value of infeasible states."""

LARGEST = 2**28
"""Largest sum of gains, packed."""

SHARE = 1.0 / 60.0
"""Step length as a share of the shortest leg."""

ROOM_BYTES, SHARE_OF_MEMORY = 1e9, 0.25
"""Memory limits of the values [bytes], [1 / free memory]; slots are widened until they fit."""

MOST_SLOTS = 32766
"""Number of slots beyond which they are widened as well, as they tell nothing more."""


class Ahead(NamedTuple):
    """Upper bounds on what can still be collected.

    A value is packed with the body that the walk goes to next, ``units << bits | body``: comparing
    compares values, and the body comes along. A walk that ends has no next body: all bits are set.

    Attributes
    ----------
    last : (steps,) float64
        Last departure of each step [s].
    best : (kits + 1, steps + 1, bodies, slots) int32
        Most that a walk collects from there, packed; from the last step nothing leaves.
    second : the same shape
        Most of those that go to another body next.
    bits : int
    slot : float
        [m/s].
    unit : float
        What one unit is worth.
    """

    last: npt.NDArray[np.float64]
    best: npt.NDArray[np.int32]
    second: npt.NDArray[np.int32]
    bits: int
    slot: float
    unit: float


class StepLegs(NamedTuple):
    """Legs in integer units, by step of departure.

    Attributes
    ----------
    origin, destination : (legs,) int64
    cost : (legs,) int64
        [slots].
    toll : (legs,) int32
        What is paid for that, packed.
    lands_in : (legs,) int64
        Step.
    first : (steps + 1,) int64
        First leg of each step.
    """

    origin: npt.NDArray[np.int64]
    destination: npt.NDArray[np.int64]
    cost: npt.NDArray[np.int64]
    toll: npt.NDArray[np.int32]
    lands_in: npt.NDArray[np.int64]
    first: npt.NDArray[np.int64]


class Onward(NamedTuple):
    """One leg as applied to the values of its origin.

    Attributes
    ----------
    cost : int
        [slots].
    top : int
        Slot of the tank that is filled where it lands; −1 at a target.
    code : int
        What the destination gives, packed with it.
    came_from : int
        Body that the walk leaves, to which it does not go straight back.
    """

    cost: int
    top: int
    code: int
    came_from: np.int32


class Packing(NamedTuple):
    """Number of bits for the next body in a packed value, and the value of infeasible states."""

    mask: np.int32
    never: np.int32


@inlined
def slots_in(delta_v, slot):
    """Number of slots of ΔV in a tank with a given remainder."""
    return int(delta_v / slot + SLOT_SLACK)


@inlined
def still(ahead, step, body, kits, left, came_from):
    """Largest number of units that a walk can still collect without an immediate return."""
    slots = min(slots_in(left, ahead.slot), ahead.best.shape[3] - 1)
    packed = ahead.best[kits, step, body, slots]
    mask = (1 << ahead.bits) - 1
    if packed & mask == came_from:
        packed = ahead.second[kits, step, body, slots]
    return np.int64(packed >> ahead.bits)


@kernel
def _images(cargo, slot, slots, tops, image):
    """Slots after each service by kits aboard; −1 if infeasible.

    Parameters
    ----------
    tops : (kits + 1,) int64
        Slot of a full tank by number of kits.
    image : (bodies, kits + 1, slots) int64
        Written.
    """
    for body in range(image.shape[0]):
        for kits in range(cargo.takes[body], tops.size):
            for s in range(slots):
                # All that is in a slot is less than the next one.
                left = after_service(cargo, body, kits, (s + 1) * slot)
                image[body, kits, s] = -1
                if left >= 0.0:
                    most = tops[kits - cargo.takes[body]]
                    image[body, kits, s] = min(slots_in(left, slot), most)


@inlined
def _served(values, image, buffer):
    """The values before a service, from those after it."""
    for s in range(image.size):
        buffer[s] = values[image[s]] if image[s] >= 0 else NEVER
    return buffer


@kernel
def put(own, other, landed, landed_second, leg, packing):
    """Improve the values of a body and step by one leg.

    Parameters
    ----------
    own, other : (slots,) int32
        Best and second best; updated.
    landed, landed_second : (slots,) int32
        Those where the leg lands.
    leg : Onward
    packing : Packing
    """
    cost, top, code, came_from = leg
    mask, never = packing
    for c in range(cost, own.size):
        at = c - cost if top < 0 else top
        value = landed[at]
        if value & mask == came_from:
            value = landed_second[at]
        value = (value & ~mask) + code
        best = own[c]
        loser = min(best, value)
        best = max(best, value)
        own[c] = best
        if (best ^ loser) & mask == 0:
            loser = never
        other[c] = max(other[c], loser)


@kernel
def _steps(departure, length, last):
    """Last departures of steps no longer than a length, and the number of steps."""
    steps, begin = 0, -np.inf
    for time in departure:
        if time > begin + length:
            begin = time
            steps += 1
        last[steps - 1] = time
    return steps


@kernel
def _mark_useful(first, departure, lands_in, cost, slots, steps, useful):
    """Mark legs not dominated by a later leg of their pair: as cheap and as early."""
    earliest = np.empty(slots, np.int64)
    for pair in range(first.size - 1):
        for c in range(slots):
            earliest[c] = steps + 1
        begin, end = first[pair], first[pair + 1]
        order = np.argsort(-departure[begin:end])
        for at in order:
            leg = begin + at
            useful[leg] = earliest[cost[leg]] > lands_in[leg]
            if useful[leg]:
                for c in range(cost[leg], slots):
                    earliest[c] = min(earliest[c], lands_in[leg])


@kernel
def _sweep(legs, code, terms, tops, image, bits, best, second):
    """Fill the values, from the last step back to the first.

    Parameters
    ----------
    legs : StepLegs
    code : (bodies,) int32
        What each body gives, packed with it.
    terms : Terms
    tops, image
        As of :func:`_images`.
    bits : int
    best, second : (kits + 1, steps + 1, bodies, slots) int32
        Written, as :class:`Ahead` has them.
    """
    origin, destination, cost, toll, lands_in, first = legs
    is_station, may_end, cargo = terms.is_station, terms.may_end, terms.cargo
    layers, steps, bodies, slots = best.shape[0], best.shape[1] - 1, best.shape[2], best.shape[3]
    mask = np.int32((1 << bits) - 1)
    packing = Packing(mask, np.int32(NEVER))
    buffer, second_buffer = np.empty(slots, np.int32), np.empty(slots, np.int32)
    for kits in range(layers):
        for i in range(bodies):
            ends = may_end[i] and not is_unused(cargo, kits)
            for c in range(slots):
                best[kits, steps, i, c] = mask if ends else NEVER
                second[kits, steps, i, c] = NEVER
    for step in range(steps - 1, -1, -1):
        for kits in range(layers):
            for i in range(bodies):
                for c in range(slots):
                    best[kits, step, i, c] = best[kits, step + 1, i, c]
                    second[kits, step, i, c] = second[kits, step + 1, i, c]
        for leg in range(first[step], first[step + 1]):
            i, j, to = origin[leg], destination[leg], lands_in[leg]
            # A station may be gone back to.
            came_from = np.int32(-1) if is_station[i] else np.int32(i)
            for kits in range(cargo.takes[j], layers):
                rest = kits - cargo.takes[j]
                landed, landed_second = best[rest, to, j], second[rest, to, j]
                if changes(cargo, j, kits):
                    landed = _served(landed, image[j, kits], buffer)
                    landed_second = _served(landed_second, image[j, kits], second_buffer)
                top = tops[kits] if is_station[j] else -1
                put(
                    best[kits, step, i],
                    second[kits, step, i],
                    landed,
                    landed_second,
                    Onward(cost[leg], top, code[j] - toll[leg], came_from),
                    packing,
                )


def most_slots(slot_bytes: float) -> float:
    """How many slots of a size in memory there may be."""
    return min(MOST_SLOTS, min(ROOM_BYTES, SHARE_OF_MEMORY * available_bytes()) / slot_bytes)


def look_ahead(
    legs: Legs, gain: Sequence[Fraction], slot_m_s: float, per_m_s: float = 0.0
) -> Ahead:
    """Compute upper bounds on what can still be collected, for given gains.

    Parameters
    ----------
    legs : Legs
    gain : sequence of Fraction
        What the service of each body is worth less its multiplier.
    slot_m_s : float
        [m/s].
    per_m_s : float
        What a walk pays for ΔV [worth per m/s].
    """
    bodies, cargo = len(gain), legs.terms.cargo
    layers, tank = cargo.full.size, float(cargo.full[0])
    departures = np.unique(legs.departure)
    last = np.empty(departures.size)
    length = max(0.0, min(SHARE * legs.shortest, legs.shortest - 4.0 * SLACK_S))
    last = last[: _steps(departures, length, last)]
    tables = 8.0 * layers * (last.size + 1) * bodies
    most = most_slots(tables)
    while slot_m_s < tank and tank / slot_m_s > most:
        slot_m_s *= 2.0
    tops = np.array([slots_in(full, slot_m_s) for full in cargo.full.tolist()])
    slots = int(tops[0]) + 1
    left_in = np.searchsorted(last, legs.departure)
    lands_in = np.searchsorted(last, legs.end - SLACK_S)
    assert np.all(left_in < lands_in)
    cost = np.maximum(0.0, np.floor(legs.delta_v / slot_m_s - SLOT_SLACK)).astype(np.int64)
    useful = np.empty(cost.size, dtype=np.bool_)
    _mark_useful(legs.first, legs.departure, lands_in, cost, slots, last.size, useful)
    order = np.flatnonzero(useful)
    order = order[np.argsort(left_in[order], kind="stable")]
    first = np.searchsorted(left_in[order], np.arange(last.size + 1))
    bits = int(bodies).bit_length() + 1
    largest = max([Fraction(0), *gain]) or Fraction(1)
    # Each leg of a walk ends in a later step than it begins in.
    most_legs = last.size + 1
    if legs.shortest < math.inf:
        most_legs = min(most_legs, int((last[-1] - last[0]) / legs.shortest) + 2)
    unit = 2.0 ** math.ceil(math.log2(float(largest) * most_legs / (LARGEST >> bits)))
    # What costs more than anything is worth may as well cost no more than that.
    size = Fraction(unit)
    units = [max(math.ceil(each / size), -math.ceil(largest / size)) for each in gain]
    code = ((np.array(units) << bits) + np.arange(bodies)).astype(np.int32)
    image = np.empty((bodies, layers, slots), dtype=np.int64)
    _images(cargo, slot_m_s, slots, tops, image)
    shape = layers, last.size + 1, bodies, slots
    best, second = np.empty(shape, dtype=np.int32), np.empty(shape, dtype=np.int32)
    pair = legs.pair[order]
    # As much as costs in whole slots alone, and no more than anything is worth.
    paid = np.floor(cost[order] * (slot_m_s * per_m_s * (1.0 - SLOT_SLACK) / unit))
    toll = np.minimum(paid, math.ceil(largest / size)).astype(np.int32) << bits
    counted = StepLegs(pair // bodies, pair % bodies, cost[order], toll, lands_in[order], first)
    _sweep(counted, code, legs.terms, tops, image, bits, best, second)
    return Ahead(last, best, second, bits, slot_m_s, unit)
