"""Most that a walk can still collect, by body, time, ΔV left and kits: one pass back in time.

Times are counted in *steps* and ΔV in *slots*, always so that walks may do more than chasers: who
is ready within a step may take everything that leaves in it; a leg costs its whole slots only, and
a slot of the tank is worth all that it may hold, before a service and after it. A walk remembers
where it comes from, and nothing else. So no walk collects more than is said here.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from fractions import Fraction
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from ...common.constants import SLACK_S
from ...common.memory import available_bytes
from ...kernels.core.compile import kernel
from .cargo import left_after
from .legs import Legs

Array = npt.NDArray[Any]

SLOT_SLACK = 1e-9
"""Rounding guard of slots, in favour of the walk [slots]."""

NEVER = np.int32(-(2**30))
"""Packed value of what is not possible."""

LARGEST = 2**28
"""Largest sum of gains, packed."""

SHARE = 1.0 / 60.0
"""Step length as a share of the shortest leg."""

ROOM_BYTES, SHARE_OF_MEMORY = 1e9, 0.25
"""Memory limits of the values [bytes], [1 / free memory]; slots are widened until they fit."""

MOST_SLOTS = 32766
"""Number of slots beyond which they are widened as well, as they tell nothing more."""


class Completion(NamedTuple):
    """The table.

    A value is packed with the body that the walk goes to next, ``units << bits | body``: comparing
    compares values, and the body comes along. A walk that ends has no next body: all bits are set.

    Attributes
    ----------
    best : (kits + 1, steps + 1, bodies, slots + 1) int32
        Most that a walk collects from there, packed. From the last step nothing leaves, and in the
        last slot nothing is possible.
    second : the same shape
        Most of those that go to another body next.
    bits : int
    slot_m_s : float
        Width of a slot [m/s].
    unit : float
        What one unit is worth.
    last : (steps,) float64
        Last departure of each step [s].
    lands : (legs,) int64
        First step that something leaves in after each leg.
    """

    best: Array
    second: Array
    bits: int
    slot_m_s: float
    unit: float
    last: Array
    lands: Array


@kernel
def still(table, kits, step, body, left, came_from):
    """Units still to be had by walks that do not go straight back to where they come from.

    Parameters
    ----------
    kits, step, body, came_from : (walks,) int64
    left : (walks,) float64
        ΔV, at least 0 [m/s].
    """
    _, steps, bodies, width = table.best.shape
    slot = np.minimum(left / table.slot_m_s + SLOT_SLACK, width - 2.0).astype(np.int64)
    at = ((kits * steps + step) * bodies + body) * width + slot
    best, second = table.best.ravel()[at], table.second.ravel()[at]
    is_back = best & (1 << table.bits) - 1 == came_from
    return np.where(is_back, second, best).astype(np.int64) >> table.bits


class WalkMoves(NamedTuple):
    """Legs in whole numbers, by step of departure.

    Attributes
    ----------
    origin, destination, cost, lands : (moves,) int64
        Bodies, slots, and step.
    code, back : (moves,) int32
        What a move gives, packed with its destination; body that a walk does not go back to.
    first : (steps + 1,) int64
        First move of each step.
    """

    origin: Array
    destination: Array
    cost: Array
    lands: Array
    code: Array
    back: Array
    first: Array


@kernel
def _sweep(moves, takes, image, mask, never, best, second):
    """Fill the values, from the last step back to the first.

    Parameters
    ----------
    moves : WalkMoves
    takes : (bodies,) int64
        Kits that a service takes.
    image : (bodies, kits + 1, slots) int64
        Slot after the stay at each body, by kits and slot on arrival; −1 if that does not change.
    mask, never : int32
        Bits of the next body, and value of what is not possible.
    best, second
        As :class:`Completion` has them; those of the last step are given, the others written.
    """
    layers, steps, _, width = best.shape
    units = np.int32(~mask)
    for step in range(steps - 2, -1, -1):
        best[:, step], second[:, step] = best[:, step + 1], second[:, step + 1]
        for move in range(moves.first[step], moves.first[step + 1]):
            i, j, cost = moves.origin[move], moves.destination[move], moves.cost[move]
            for kits in range(takes[j], layers):
                rest, to = kits - takes[j], moves.lands[move]
                value, other_value = best[rest, to, j], second[rest, to, j]
                if image[j, kits, 0] < 0:  # nothing changes
                    value, other_value = value[: width - 1 - cost], other_value[: width - 1 - cost]
                else:
                    at = image[j, kits, : width - 1 - cost]
                    value, other_value = value[at], other_value[at]
                value = np.where(value & mask == moves.back[move], other_value, value)
                value = (value & units) + moves.code[move]
                own = best[kits, step, i, cost : width - 1]
                other = second[kits, step, i, cost : width - 1]
                most, less = np.maximum(own, value), np.minimum(own, value)
                less = np.where((most ^ less) & mask == 0, never, less)
                other[:] = np.maximum(other, less)
                own[:] = most


def _steps(departures: Array, length: float) -> Array:
    """Last departures of steps that are no longer than a length."""
    last, at = [], 0
    while at < departures.size:
        at = int(np.searchsorted(departures, departures[at] + length, side="right"))
        last.append(departures[at - 1])
    return np.array(last)


@kernel
def _mark_useful(pair, lands, cost, slots, useful):
    """Mark legs of which none of their pair leaves later, lands no later and costs no more.

    Parameters
    ----------
    pair, lands, cost : (legs,) int64
        By pair, the last departures first.
    slots : int
    useful : (legs,) bool
        Written.
    """
    none, last = np.int64(2**62), np.int64(-1)
    earliest = np.full(slots, none)
    for leg in range(pair.size):
        if pair[leg] != last:
            earliest[:], last = none, pair[leg]
        if cost[leg] < slots and earliest[cost[leg]] > lands[leg]:
            useful[leg] = True
            earliest[cost[leg] :] = np.minimum(earliest[cost[leg] :], lands[leg])


def _moves(legs: Legs, table: Completion, cost: Array, code: Array) -> WalkMoves:
    """The legs, without those that one of their pair leaves later to no loss."""
    leaves, lands = np.searchsorted(table.last, legs.departure), table.lands
    assert np.all(leaves < lands)  # a walk is a path forward in time
    order = np.argsort(legs.pair * (table.last.size + 1) - leaves, kind="stable")
    useful = np.zeros(order.size, dtype=np.bool_)
    _mark_useful(legs.pair[order], lands[order], cost[order], table.best.shape[3] - 1, useful)
    order = order[useful]
    order = order[np.argsort(leaves[order], kind="stable")]
    origin, destination = np.divmod(legs.pair[order], legs.terms.bodies)
    back = np.where(legs.terms.is_station[origin], -1, origin).astype(np.int32)
    first = np.searchsorted(leaves[order], np.arange(table.last.size + 1))
    return WalkMoves(origin, destination, cost[order], lands[order], code[order], back, first)


def slots_in(delta_v: Any, slot: float) -> Any:
    """Whole slots that there is ΔV for."""
    return np.floor(delta_v / slot + SLOT_SLACK).astype(np.int64)


def _images(legs: Legs, slots: int, slot: float) -> Array:
    """Slot after the stay at each body, by kits and slot on arrival; −1 if that does not change.

    It is the last one if the stay is not possible.
    """
    terms, cargo = legs.terms, legs.terms.cargo
    layers, tops = cargo.full.size, slots_in(cargo.full, slot)
    body, kits, at = np.indices((terms.bodies, layers, slots)).reshape(3, -1)
    # All that is in a slot is less than the next one.
    after = left_after(cargo, body, kits, (at + 1) * slot)
    top = tops[np.maximum(kits - cargo.takes[body], 0)]
    image = np.minimum(slots_in(np.maximum(after, 0.0), slot), top)
    same = (cargo.share[body, kits] == 1.0) & (cargo.lost[body, kits] == 0.0)
    image = np.where(same, -1, np.where(after < 0.0, slots, image))
    image = np.where(terms.is_station[body], tops[kits], image)
    return image.reshape(terms.bodies, layers, slots)


def most_slots(slot_bytes: float) -> float:
    """How many slots of a size in memory there may be."""
    return min(MOST_SLOTS, min(ROOM_BYTES, SHARE_OF_MEMORY * available_bytes()) / slot_bytes)


def completion(
    legs: Legs, gain: Sequence[Fraction], slot_m_s: float, per_m_s: float = 0.0
) -> Completion:
    """The table for given gains.

    Parameters
    ----------
    legs : Legs
    gain : sequence of Fraction
        What the service of each body is worth less its multiplier.
    slot_m_s : float
        Least width of a slot [m/s].
    per_m_s : float
        What a walk pays for ΔV [worth per m/s].
    """
    terms, cargo, bodies = legs.terms, legs.terms.cargo, len(gain)
    layers, tank = cargo.full.size, float(cargo.full[0])
    length = max(0.0, min(SHARE * legs.shortest, legs.shortest - 4.0 * SLACK_S))
    last = _steps(np.unique(legs.departure), length)
    most = most_slots(8.0 * layers * (last.size + 1) * bodies)
    while slot_m_s < tank and tank / slot_m_s > most:
        slot_m_s *= 2.0
    slots, bits = int(slots_in(tank, slot_m_s)) + 1, int(bodies).bit_length() + 1
    largest = max([Fraction(0), *gain]) or Fraction(1)
    # Each leg of a walk ends in a later step than it begins in.
    most_legs = last.size + 1
    if legs.shortest < math.inf:
        most_legs = min(most_legs, int((last[-1] - last[0]) / legs.shortest) + 2)
    unit = 2.0 ** math.ceil(math.log2(float(largest) * most_legs / (LARGEST >> bits)))
    # What costs more than anything is worth may as well cost no more than that.
    size = Fraction(unit)
    units = np.array([max(math.ceil(each / size), -math.ceil(largest / size)) for each in gain])
    # As much as costs in whole slots alone, and no more than anything is worth.
    cost = np.maximum(0.0, np.floor(legs.delta_v / slot_m_s - SLOT_SLACK)).astype(np.int64)
    paid = np.floor(cost * (slot_m_s * per_m_s * (1.0 - SLOT_SLACK) / unit))
    toll = np.minimum(paid, math.ceil(largest / size)).astype(np.int64)
    destination = legs.pair % bodies
    code = ((units[destination] - toll << bits) + destination).astype(np.int32)
    lands = np.searchsorted(last, legs.end - SLACK_S)
    best = np.full((layers, last.size + 1, bodies, slots + 1), NEVER)
    table = Completion(best, best.copy(), bits, slot_m_s, unit, last, lands)
    mask = np.int32((1 << bits) - 1)
    unused = cargo.heavy & (np.arange(layers) > 0)
    best[:, -1, :, :-1] = np.where(terms.may_end & ~unused[:, None], mask, NEVER)[..., None]
    moves, image = _moves(legs, table, cost, code), _images(legs, slots, slot_m_s)
    _sweep(moves, cargo.takes, image, mask, NEVER, table.best, table.second)
    return table
