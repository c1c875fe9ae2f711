"""Check whether walks of a large field collect the stated amount, in time steps, body by body.

Where there are too many legs for labels (:mod:`.walks`) a pass backwards in time, as they look
ahead by (:mod:`.completion`), is all there is. It is coarser than walks are, always so that they
may do more. Times are in *steps* of one length, ΔV in *slots*; a walk remembers where it is from
and nothing else. So amounts that it excludes are never collected.

A leg is four whole numbers in one, and each body's legs are worked out, counted and packed before
those of the next one, so that hundreds of millions find room.

Either walks know how much is left of a tank, or ΔV has a price: a walk begins with the price of
what there is in the tank, pays for each leg, and gets the price of a full tank at every refuelling.
Every plan is such a walk, and what it got for its tanks is no less than what it paid.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from fractions import Fraction
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from ...common.constants import SLACK_S
from ...common.errors import InputError
from ...common.memory import available_bytes
from ...kernels.core.compile import kernel
from ...legs.connection_finder import ConnectionFinder
from .completion import SLOT_SLACK, slots_in
from .terms import Terms, flown_from

DEPARTURE, DESTINATION, AHEAD, FIELD = 48, 32, 16, 0xFFFF
"""Bit offsets in a packed leg: departure step, destination, steps to landing, slots (16 bits)."""

MOST = 2**15 - 2
"""Maximum number of steps, of bodies and of slots."""

MEMORY_SHARE = 0.8
"""Share of free memory that legs and values may take."""


class Counting(NamedTuple):
    """How walks are discretised.

    Attributes
    ----------
    kind : type
        Integers of values: ones of 32 bits where there is one for each slot.
    largest : int
        No sum of gains is larger, packed with the next body; none of losses either.
    never : int
        Packed value of what is not possible.
    """

    kind: Any
    largest: int
    never: int


OF_TANKS = Counting(np.int32, 2**28, -(2**30))
OF_PRICES = Counting(np.int64, 2**60, -(2**62))


class StepGrid(NamedTuple):
    """Units of time and ΔV.

    Attributes
    ----------
    length : float
        Of a step [s].
    slot : float
        Of ΔV [m/s].
    slots, steps : int
        How many there are.
    """

    length: float
    slot: float
    slots: int
    steps: int


class StepTerms(NamedTuple):
    """Gains and costs of walks in steps; *values* are integers of one type.

    Attributes
    ----------
    code : (bodies,) values
        What each body gives, packed with it.
    toll : values
        Of a slot, packed; 0 where walks know how much is left.
    is_station : (bodies,) bool
    top : int
        Slot of a full tank; −1 where ΔV has a price.
    mask, never : values
        Bits of the next body in a packed value, and the value of what is not possible.
    """

    code: npt.NDArray[Any]
    toll: Any
    is_station: npt.NDArray[np.bool_]
    top: int
    mask: Any
    never: Any


class StepValues(NamedTuple):
    """Most that walks collect, and most with another next body, packed."""

    best: npt.NDArray[Any]
    second: npt.NDArray[Any]


@kernel
def _packed(departure, end, delta_v, j, grid, earliest, legs):
    """Pack the undominated legs of one pair, in order of departure.

    Parameters
    ----------
    grid : StepGrid
    earliest : (slots,) int64
        Scratch: earliest landing of the legs that leave no sooner and cost no more.
    legs : (legs,) int64
        Written from the front.

    Returns
    -------
    count : int
    shortest : int
        Least steps of one of them.
    """
    length, slot, slots, steps = grid
    count, shortest = 0, steps + 1
    earliest[:] = steps + 1
    for leg in range(departure.size - 1, -1, -1):
        left = max(0, math.floor(departure[leg] / length))
        lands = min(max(0, math.floor((end[leg] - SLACK_S) / length)), steps)
        cost = int(max(0.0, math.floor(delta_v[leg] / slot - SLOT_SLACK)))
        if earliest[cost] <= lands:
            continue
        for dearer in range(cost, slots):
            if earliest[dearer] <= lands:
                break
            earliest[dearer] = lands
        shortest = min(shortest, lands - left)
        legs[count] = (
            (np.int64(left) << DEPARTURE)
            | (np.int64(j) << DESTINATION)
            | (np.int64(max(lands - left, 0)) << AHEAD)
            | np.int64(cost)
        )
        count += 1
    return count, shortest


@kernel
def _sweep(legs, behind, i, came_from, terms, values, high, low):
    """Fill the values of a body for steps ``low`` to ``high`` − 1; returns the legs still to come.

    Parameters
    ----------
    legs : (legs,) int64
        Those of the body, in order of departure.
    behind : int
        Number of them that depart before ``high``.
    came_from : values
        The body, to which walks do not go straight back, or nothing at a station.
    terms : StepTerms
    values : StepValues
        By body, step and slot.
    """
    code, toll, is_station, top, mask, never = terms
    best, second = values
    gives = code[:1].copy()  # of the type of values
    for step in range(high - 1, low - 1, -1):
        own, other = best[i, step], second[i, step]
        own[:] = best[i, step + 1]
        other[:] = second[i, step + 1]
        while behind > 0 and legs[behind - 1] >> DEPARTURE >= step:
            behind -= 1
            leg = legs[behind]
            j, cost = (leg >> DESTINATION) & FIELD, leg & FIELD
            lands = step + ((leg >> AHEAD) & FIELD)
            landed, landed_second = best[j, lands], second[j, lands]
            gives[0] = code[j]
            if top < 0:
                gives[0] -= cost * toll
                cost = 0
            given, fills = gives[0], top >= 0 and is_station[j]
            for c in range(cost, own.size):
                at = top if fills else c - cost
                value = landed[at]
                if value & mask == came_from:
                    value = landed_second[at]
                value = (value & ~mask) + given
                most = own[c]
                less = min(most, value)
                most = max(most, value)
                own[c] = most
                if (most ^ less) & mask == 0:
                    less = never
                other[c] = max(other[c], less)
    return behind


def most_in_steps(
    terms: Terms,
    connecting: ConnectionFinder,
    gains: Sequence[Fraction],
    length_s: float,
    slot_m_s: float,
    worth_per_m_s: Fraction | None,
) -> tuple[Fraction | None, int]:
    """Upper bound on what a walk collects; None if there is no walk.

    Parameters
    ----------
    terms : Terms
    connecting : ConnectionFinder
    gains : sequence of Fraction
        What the service of each body is worth, less its multiplier.
    length_s, slot_m_s : float
        Of a step [s], and of a slot of ΔV [m/s].
    worth_per_m_s : Fraction, optional
        Price of ΔV; by default walks know how much is left of a tank.

    Returns
    -------
    most : Fraction or None
    legs : int
        How many were gone through.

    Raises
    ------
    InputError
        Steps or slots are too short or too long for the instance, they would take more memory than
        there is, or services change what is left of a tank and ΔV is looked at all the same.
    """
    steps = math.floor(max(terms.last, 0.0) / length_s) + 2
    slots = int(slots_in(terms.cargo.full[0], slot_m_s)) + 1
    if max(steps, slots, terms.bodies) > MOST:
        raise InputError(
            f"not verifiable: {steps} steps, {slots} slots and {terms.bodies} bodies are too many; "
            "none may be above 32766"
        )
    if worth_per_m_s != 0 and (np.any(terms.cargo.share != 1.0) or np.any(terms.cargo.lost)):
        raise InputError(
            "field walks: where services change what is left of a tank, walks in steps must have "
            "worth_per_m_s = 0"
        )
    counting, width = (OF_TANKS, slots) if worth_per_m_s is None else (OF_PRICES, 1)
    size = terms.bodies * (steps + 1) * width
    _find_room(2.0 * np.dtype(counting.kind).itemsize * size)
    legs, shortest = _legs(terms, connecting, StepGrid(length_s, slot_m_s, slots, steps))
    count = sum(each.size for each in legs)
    price = Fraction(0) if worth_per_m_s is None else worth_per_m_s * Fraction(slot_m_s)
    unit, units, toll = _in_units(gains, price, slots, steps // max(1, shortest) + 2, counting)
    bits, kind = terms.bodies.bit_length(), counting.kind
    mask = kind((1 << bits) - 1)
    begun = int(slots_in(terms.begun[-1], slot_m_s))
    worths = list(units)
    for body in np.flatnonzero(terms.is_station):
        worths[body] += toll * (slots - 1)
    code = np.array([(worth << bits) + body for body, worth in enumerate(worths)], dtype=kind)
    shape = terms.bodies, steps + 1, width
    best, second = np.empty(shape, dtype=kind), np.empty(shape, dtype=kind)
    best[:, steps] = np.where(terms.may_end, mask, counting.never)[:, None]
    second[:, steps] = counting.never
    step_terms = StepTerms(
        code,
        kind(toll << bits),
        terms.is_station,
        slots - 1 if worth_per_m_s is None else -1,
        mask,
        kind(counting.never),
    )
    values = StepValues(best, second)
    behind = [each.size for each in legs]
    high = steps
    while high > 0:
        low = max(0, high - shortest)  # no leg that departs in these steps lands in one of them
        for i in range(terms.bodies):
            came_from = kind(-1 if terms.is_station[i] else i)
            behind[i] = _sweep(legs[i], behind[i], i, came_from, step_terms, values, high, low)
        high = low
    found = [
        int(best[body, _step(float(terms.ready[body]) - SLACK_S, length_s), min(begun, width - 1)])
        + ((units[body] << bits) if body != terms.home else 0)
        for body in terms.starts.tolist()
    ]
    most = max(found)
    if most < counting.never // 2:
        return None, count
    return Fraction(unit) * ((most >> bits) + toll * begun), count


def _step(time_s: float, length_s: float) -> int:
    return max(0, math.floor(time_s / length_s))


def _find_room(size: float) -> None:
    """Check that memory is available.

    Raises
    ------
    InputError
    """
    if size > MEMORY_SHARE * available_bytes():
        raise InputError(
            f"not verifiable here: it takes {size / 2**30:.3g} GiB, and "
            f"{available_bytes() / 2**30:.3g} GiB of memory are free"
        )


def _legs(
    terms: Terms, connecting: ConnectionFinder, grid: StepGrid
) -> tuple[list[npt.NDArray[np.int64]], int]:
    """Legs of each body in order of departure, and the least number of steps.

    Raises
    ------
    InputError
        A leg ends in the step that it leaves in, or there is no room for all of them.
    """
    earliest, legs = np.empty(grid.slots, dtype=np.int64), []
    shortest = grid.steps + 1
    for i in range(terms.bodies):
        parts = [np.empty(0, dtype=np.int64)]
        for j, departure, end, delta_v in flown_from(i, terms, connecting):
            assert np.all(departure[1:] >= departure[:-1])  # what is superfluous depends on it
            part = np.empty(departure.size, dtype=np.int64)
            count, least = _packed(departure, end, delta_v, j, grid, earliest, part)
            shortest = min(shortest, least)
            parts.append(part[:count].copy())
        legs.append(np.sort(np.concatenate(parts)))
        used_bytes = sum(each.nbytes for each in legs)
        _find_room(used_bytes * (terms.bodies - i - 1) / (i + 1))
    if shortest < 1:
        raise InputError(
            f"field time_step_s = {grid.length!r}: there are legs that do not take as long"
        )
    return legs, shortest


def _in_units(
    gains: Sequence[Fraction], price: Fraction, slots: int, most_legs: int, counting: Counting
) -> tuple[float, list[int], int]:
    """Size of a unit, and gains and ΔV slots in units.

    Gains are rounded up and tolls down, so that walks collect more than they would.
    """
    tank = price * (slots - 1)
    largest = max([Fraction(0), *gains]) + tank
    most = counting.largest >> len(gains).bit_length()
    # Below the largest by so much nobody comes to a body who need not.
    each = most // (most_legs + 1)
    share = largest / each or Fraction(1)
    unit = 2.0 ** math.ceil(math.log2(share)) if share > 0 else 1.0
    size = Fraction(unit)
    toll = math.floor(price / size) if slots > 1 else 0  # nothing costs a whole slot
    units = [max(math.ceil(gain / size), -each) for gain in gains]
    return unit, units, toll
