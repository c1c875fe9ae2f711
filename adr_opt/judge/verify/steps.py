"""Check whether walks on a large field collect the stated amount, by a table of time steps.

Where there are too many legs for labels (:mod:`.walk_questions`) the table by which these look
ahead (:mod:`.completion`) is all there is, in steps of one length. It is coarser than walks are,
always so that they may do more. So amounts that it excludes are never collected.

A leg is four small numbers, and each body's legs are worked out and thinned before those of the
next one, so that hundreds of millions find room.

Either walks know how much is left of a tank, or ΔV has a price: a walk begins with the price of
what there is in the tank, pays for each leg, and gets the price of a full tank at every refuelling.
Every plan is such a walk, and what it got for its tanks is no less than what it paid.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from fractions import Fraction

import numpy as np

from ...common.constants import SLACK_S
from ...common.errors import InputError
from ...common.memory import available_bytes
from ...legs.connection_finder import ConnectionFinder
from .completion import Array, MoveGains, costs_of, in_units, never_of, slots_in, sweep, undominated
from .terms import Terms, flown_from

MOST = 2**15 - 2
"""Maximum number of steps, of bodies and of slots."""

MEMORY_SHARE, LEG_BYTES = 0.8, 20.0
"""Share of free memory that legs and values may take; what a leg takes while legs are sorted."""


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
    bodies, steps = terms.bodies, math.floor(max(terms.last, 0.0) / length_s) + 2
    slots = int(slots_in(terms.cargo.full[0], slot_m_s)) + 1
    if max(steps, slots, bodies) > MOST:
        raise InputError(
            f"cannot be verified: {steps} steps, {slots} slots and {bodies} bodies; none may "
            "exceed 32766"
        )
    if worth_per_m_s != 0 and (np.any(terms.cargo.share != 1.0) or np.any(terms.cargo.lost)):
        raise InputError(
            "field walks: where services change what is left of a tank, walks in steps must have "
            "worth_per_m_s = 0"
        )
    counted, price = worth_per_m_s is None, (worth_per_m_s or Fraction(0)) * Fraction(slot_m_s)
    kind, width = (np.dtype(np.int32), slots) if counted else (np.dtype(np.int64), 1)
    _find_room(2.0 * kind.itemsize * bodies * (steps + 1) * (width + 1))
    parts, shortest = [], steps
    for body, part in enumerate(_moves(terms, connecting, length_s, slot_m_s, steps)):
        shortest = min(shortest, int(np.min(part[2].astype(int) - part[0], initial=steps)))
        if shortest < 1:
            raise InputError(f"field time_step_s = {length_s!r}: some legs are shorter; give less")
        parts.append(undominated(body, *part))
        legs = sum(each[0].size for each in parts)
        _find_room(LEG_BYTES * legs * (bodies - body - 1) / (body + 1))
    # Gains are rounded up and tolls down, so that walks collect more than they would.
    bits, tank = bodies.bit_length(), price * (slots - 1)
    unit, units, _ = in_units(gains, tank, steps // shortest + 3, kind, bits)
    toll = math.floor(price / unit) if slots > 1 else 0  # nothing costs a whole slot
    column = np.tile(np.arange(width + 1), (bodies, 1, 1))
    if counted:
        column[terms.is_station, :, 1:] = slots
    given = MoveGains(
        units + toll * (slots - 1) * terms.is_station,
        toll * np.arange(slots),
        np.arange(slots) * counted,
        np.where(terms.is_station, -1, np.arange(bodies)),
        np.zeros(bodies, dtype=np.int64),
        column,
    )
    best = np.full((1, steps + 1, bodies, width + 1), never_of(kind), dtype=kind)
    second = best.copy()
    best[0, -1, terms.may_end, 1:] = (1 << bits) - 1
    sweep(parts, given, bits, best, second)
    begun, at = int(slots_in(terms.begun[-1], slot_m_s)), terms.starts
    step = np.maximum((terms.ready[at] - SLACK_S) // length_s, 0.0).astype(int)
    found = best[0, step, at, 1 + min(begun, width - 1)].astype(int) >> bits
    most = int(np.max(found + np.where(at == terms.home, 0, units[at])))
    none = most < never_of(kind) // 2 >> bits
    return None if none else Fraction(unit) * (most + toll * begun), legs


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


def _moves(
    terms: Terms, connecting: ConnectionFinder, length_s: float, slot_m_s: float, steps: int
) -> Iterator[tuple[Array, Array, Array, Array]]:
    """Steps of departure, destinations, steps of landing and slots of the legs from each body."""
    for body in range(terms.bodies):
        parts = [np.empty((4, 0), dtype=np.uint16)]
        for j, departure, end, delta_v in flown_from(body, terms, connecting):
            leaves, lands = departure // length_s, (end - SLACK_S) // length_s
            costs = costs_of(delta_v, slot_m_s)
            columns = leaves, np.full(leaves.size, j), np.minimum(lands, steps), costs
            parts.append(np.maximum(columns, 0.0).astype(np.uint16))
        leaves, destination, lands, cost = np.concatenate(parts, axis=1)
        yield leaves, destination, lands, cost
