"""Most that a walk can still collect, by body, time, ΔV left and kits: one backward pass.

Times are counted in *steps* and ΔV in *slots*, always so that the walks of this table may do more
than those of :mod:`.closed`: who is ready within a step may take everything that leaves in it; a
leg costs its whole slots only, and a slot of the tank is worth all that it may hold, before a
service and after it. They remember the body they come from, and nothing else. So none collects more
than is said here, from the last step back to the first::

    best(body, step) = max(end here, best(body, step + 1), gain − toll + best(j, landing)),

over the legs that leave the body in the step, to bodies j other than the one come from.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from fractions import Fraction
from itertools import pairwise, product
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from ...common.constants import SLACK_S
from ...common.memory import available_bytes
from .cargo import left_after
from .legs import Legs

Array = npt.NDArray[Any]

SLOT_SLACK, SHARE = 1e-9, 1.0 / 60.0
"""Rounding guard of slots in favour of walks [slots]; step length as a share of the least leg."""

ROOM_BYTES, SHARE_OF_MEMORY, MOST_SLOTS = 1e9, 0.25, 32766
"""Limits on the table [bytes], [share of free memory] and on the number of slots, which are widened
until the table fits."""

BLOCK = 2**18
"""Number of values computed at once, so that they stay in the processor's cache."""


class Completion(NamedTuple):
    """The table.

    A value is packed with the body that the walk goes to next, ``units << bits | body``: comparing
    compares values, and the body comes along. A walk that ends has no next body: all bits are set.

    Attributes
    ----------
    best : (kits + 1, steps + 1, bodies, slots + 1) int32
        Most that a walk collects from there, packed. From the last step nothing leaves. Column s is
        that of slot s − 1, and column 0 that of an overdrawn tank: nothing is possible.
    second : the same shape
        Most of those that go to another body next.
    bits : int
    slot_m_s : float
        Width of a slot [m/s].
    unit : Fraction
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
    unit: Fraction
    last: Array
    lands: Array


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
    # Each leg of a walk ends in a later step than it begins in; an eighth of the room is used.
    most_legs = min(last.size + 1, int(np.ptp(last) / legs.shortest) + 2) if last.size else 1
    unit, units, largest = in_units(gain, Fraction(0), most_legs, np.int32, bits)
    # A toll that is cut off favours the walk.
    paid = np.floor(np.arange(slots + 1) * (slot_m_s * per_m_s * (1.0 - SLOT_SLACK) / float(unit)))
    tolls = np.minimum(paid, largest).astype(np.int64)
    lands = np.searchsorted(last, legs.end - SLACK_S)
    best = np.full((layers, last.size + 1, bodies, slots + 1), never_of(np.int32))
    table = Completion(best, best.copy(), bits, slot_m_s, unit, last, lands)
    may_end = terms.may_end & ~(cargo.heavy & (np.arange(layers) > 0))[:, None]
    best[:, -1, :, 1:] = np.where(may_end, (1 << bits) - 1, never_of(np.int32))[..., None]
    leaves = np.searchsorted(last, legs.departure)
    cost, destination = np.minimum(costs_of(legs.delta_v, slot_m_s), slots), legs.pair % bodies
    parts = [
        undominated(body, leaves[a:b], destination[a:b], lands[a:b], cost[a:b])
        for body, (a, b) in enumerate(pairwise(legs.first[::bodies]))
    ]
    back = np.where(terms.is_station, -1, np.arange(bodies))
    after = _columns(legs, slots, slot_m_s)
    gains = MoveGains(units, tolls, np.arange(slots + 1), back, cargo.takes, after)
    sweep(parts, gains, bits, table.best, table.second)
    return table


def still(
    table: Completion, kits: Array, step: Array, body: Array, left: Array, came_from: Array
) -> Any:
    """Units that walks can still collect without returning at once to the previous body.

    Parameters
    ----------
    table : Completion
    kits, step, body, came_from : (walks,) int64
    left : (walks,) float64
        ΔV, at least 0 [m/s].
    """
    _, steps, bodies, width = table.best.shape
    slot = np.minimum(left / table.slot_m_s + SLOT_SLACK, width - 2.0).astype(np.int64)
    at = ((kits * steps + step) * bodies + body) * width + slot + 1
    best = table.best.ravel()[at]
    back = np.flatnonzero(best & (1 << table.bits) - 1 == came_from)
    best[back] = table.second.ravel()[at[back]]
    return best.astype(np.int64) >> table.bits


def never_of(kind: Any) -> Any:
    """Packed value of an impossible continuation, by the type of values."""
    return np.dtype(kind).type(np.iinfo(kind).min // 2)


def in_units(
    gains: Sequence[Fraction], more: Fraction, most_legs: int, kind: Any, bits: int
) -> tuple[Fraction, Array, int]:
    """Size of a unit, gains in units, rounded up, and the largest of them.

    What ``most_legs`` legs give, each a gain and ``more`` at most, packed into integers of a
    ``kind`` is no more than an eighth of what these hold.
    """
    largest = max([Fraction(0), *gains]) + more or Fraction(1)
    room = (int(np.iinfo(kind).max) // 8 + 1) >> bits
    unit = Fraction(2.0 ** math.ceil(math.log2(largest * most_legs / room)))
    most = math.ceil(largest / unit)
    # A loss that is cut off favours the walk.
    return unit, np.array([max(math.ceil(gain / unit), -most) for gain in gains]), most


class MoveGains(NamedTuple):
    """Gains and costs of moves.

    Attributes
    ----------
    units : (bodies,) int64
        What a service gives.
    tolls, spends : (slots,) int64
        What a move of so many slots pays, and takes off the tank.
    back : (bodies,) int64
        The body itself, as walks that come from there do not go straight back; −1 for stations.
    takes : (bodies,) int64
        Kits that a service takes.
    column : (bodies, kits + 1, slots + 1) int64
        Column after the stay at each body, by kits and column on arrival.
    """

    units: Array
    tolls: Array
    spends: Array
    back: Array
    takes: Array
    column: Array


Moves = tuple[Array, Array, Array, Array, Array]
"""Legs from one body in whole numbers: step of departure, origin, destination, step of landing, and
slots."""


def undominated(body: int, leaves: Array, destination: Array, lands: Array, cost: Array) -> Moves:
    """Moves from a body, without those that contain another move to the same body at equal cost."""
    if np.any(leaves >= lands):
        raise ValueError("a leg lands in the step that it leaves in: a walk goes forward in time")
    place = destination.astype(np.int64) * (int(cost.max(initial=0)) + 1) + cost
    order = np.argsort(place * (int(leaves.max(initial=0)) + 1) - leaves, kind="stable")
    # Of each place the latest first, and of these who lands earlier than all before: where another
    # place begins landings are lowered by more than they differ.
    begins = np.cumsum(np.diff(place[order], prepend=-1) != 0)
    earliest = np.minimum.accumulate(lands[order] - begins * (int(lands.max(initial=0)) + 1))
    order = order[np.diff(earliest, prepend=1) < 0]
    origin = np.full(order.size, body, dtype=destination.dtype)
    return leaves[order], origin, destination[order], lands[order], cost[order]


def sweep(parts: Sequence[Moves], gains: MoveGains, bits: int, best: Array, second: Array) -> None:
    """Fill the values, from the last step back to the first.

    Parameters
    ----------
    parts : sequence of Moves
        Those from every body.
    gains : MoveGains
    bits : int
    best, second
        As :class:`Completion` has them; those of the last step are given, the others written.
    """
    layers, steps, bodies, width = best.shape
    mask, never = best.dtype.type((1 << bits) - 1), never_of(best.dtype)
    columns_of = list(map(list, zip(*parts, strict=True)))
    leaves = np.concatenate(columns_of[0])
    order = np.argsort(leaves, kind="stable")
    first = np.searchsorted(leaves, np.arange(steps), sorter=order)
    moves = [np.concatenate(column)[order] for column in columns_of[1:]]
    changes = np.any(gains.column != np.arange(width), axis=2)

    for step in range(steps - 2, -1, -1):
        best[:, step], second[:, step] = best[:, step + 1], second[:, step + 1]
        some = slice(*first[step : step + 2])
        i, j, lands, cost = (column[some].astype(np.int64) for column in moves)
        if not i.size:
            continue
        code = (((gains.units[j] - gains.tolls[cost]) << bits) + j).astype(best.dtype)[:, None]
        back = gains.back[i].astype(best.dtype)[:, None]
        own, start, group = np.unique(i, return_index=True, return_inverse=True)
        pieces = np.array_split(np.arange(1, width), 1 + i.size * width // BLOCK)
        for kits, columns in product(range(layers), pieces):
            rest, changed = kits - gains.takes[j], np.flatnonzero(changes[j, kits])
            at = np.maximum(columns - gains.spends[cost, None], 0)
            at[changed] = gains.column[j[changed, None], kits, at[changed]]
            at += (((np.maximum(rest, 0) * steps + lands) * bodies + j) * width)[:, None]
            value = best.ravel().take(at)
            again = np.flatnonzero(value & mask == back)  # would go straight back
            value.ravel()[again] = second.ravel().take(at.ravel()[again])
            value = (value & ~mask) + code
            value[rest < 0] = never
            here = np.s_[kits, step, own[:, None], columns]
            most = np.maximum(best[here], np.maximum.reduceat(value, start))
            value[(value ^ most[group]) & mask == 0] = never  # what goes where the best goes
            others = np.maximum.reduceat(value, start)
            for mine in (best[here], second[here]):
                others = np.maximum(others, np.where((mine ^ most) & mask == 0, never, mine))
            best[here], second[here] = most, others


def _steps(departures: Array, length: float) -> Array:
    """Last departures of steps that are no longer than a length."""
    last, at = [], 0
    while at < departures.size:
        at = int(np.searchsorted(departures, departures[at] + length, side="right"))
        last.append(departures[at - 1])
    return np.array(last)


def slots_in(delta_v: Any, slot: float) -> Any:
    """Number of whole slots that some ΔV covers."""
    return np.floor(delta_v / slot + SLOT_SLACK).astype(np.int64)


def costs_of(delta_v: Any, slot: float) -> Any:
    """Costs of legs in whole slots."""
    return np.maximum(0.0, np.floor(delta_v / slot - SLOT_SLACK)).astype(np.int64)


def _columns(legs: Legs, slots: int, slot: float) -> Array:
    """Column after the stay at each body, by kits and column on arrival."""
    terms, cargo = legs.terms, legs.terms.cargo
    layers, tops = cargo.full.size, slots_in(cargo.full, slot)
    body, kits, at = np.indices((terms.bodies, layers, slots + 1)).reshape(3, -1)
    # All that is in a slot is less than the next one.
    after = left_after(cargo, body, kits, at * slot)
    top = tops[np.maximum(kits - cargo.takes[body], 0)]
    column = 1 + np.minimum(slots_in(np.maximum(after, 0.0), slot), top)
    same = (cargo.share[body, kits] == 1.0) & (cargo.lost[body, kits] == 0.0)
    column = np.where(same, at, np.where(after < 0.0, 0, column))
    column = np.where(terms.is_station[body], 1 + tops[kits], column)
    return np.where(at == 0, 0, column).reshape(terms.bodies, layers, slots + 1)


def most_slots(slot_bytes: float) -> float:
    """Maximum number of slots, by the memory that each takes."""
    return min(MOST_SLOTS, min(ROOM_BYTES, SHARE_OF_MEMORY * available_bytes()) / slot_bytes)
