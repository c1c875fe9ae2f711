"""Lower bounds on the end of a tour, by place, time and number of unserviced targets.

Relaxed tours do as many targets as there are, but may do one again that they have forgotten
(:mod:`.memories`), for which a multiplier charges them. Time is counted in steps, always rounded
down: as nobody overtakes, whoever is there earlier can do no worse. Values are whole *units*, so
that no sum is rounded.
"""

from __future__ import annotations

import math
from concurrent.futures import ThreadPoolExecutor
from functools import partial
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from adr_opt.kernels.core.compile import inlined, kernel

from .memories import NearMemories
from .tour import TimedTour, reached

NEVER = 2**30
"""Value of a state from which no tour ends in time."""

UNITS = 2**20
"""Number of units in the time of a tour."""


class TimeSteps(NamedTuple):
    """Moves in steps of time.

    Attributes
    ----------
    length, unit : float
        Of a step, and of a unit [s].
    total : int
        Number of steps.
    after : (targets + 1, targets, steps + 1) int32
        Step in which a service ends, by origin, destination and the step before; beyond all steps
        for never.
    ends : (targets + 1, steps + 1) int32
        End of the tour from a last target [units], or NEVER.
    """

    length: float
    unit: float
    total: int
    after: npt.NDArray[np.int32]
    ends: npt.NDArray[np.int32]


class Bands(NamedTuple):
    """Steps in which a place may be left, by number of unserviced targets.

    Attributes
    ----------
    low, high : (targets + 1, targets + 1) int64
        First and last step, by number of targets still to do and place.
    begin : (targets + 1, targets + 1) int64
        Row of the first one.
    rows : int
    """

    low: npt.NDArray[np.int64]
    high: npt.NDArray[np.int64]
    begin: npt.NDArray[np.int64]
    rows: int


class Relaxation(NamedTuple):
    """Completion values of relaxed tours.

    Attributes
    ----------
    steps : TimeSteps
    memories : NearMemories
    bands : Bands
    multipliers : (targets,) int64
        Charge of each service [units].
    values : (rows, 2^size + 1) int32
        Least end and charges of the rest of a relaxed tour, by memory [units].
    """

    steps: TimeSteps
    memories: NearMemories
    bands: Bands
    multipliers: npt.NDArray[np.int64]
    values: npt.NDArray[np.int32]


@kernel
def _fill_steps(tour, length, unit, until, shift, after, ends):
    """Fill the moves in steps; ``shift`` rounds to the nearest step instead of down."""
    targets, count = tour.targets, ends.shape[1] - 1
    for i in range(targets + 1):
        for step in range(count + 1):
            time = tour.ready + step * length
            ends[i, step] = NEVER
            end = reached(tour, i, targets + 1, time) if i < targets else np.inf
            if end <= until:
                ends[i, step] = math.floor((end - tour.ready) / unit)
            for j in range(targets):
                after[i, j, step] = count + 1
                if i == j or (i == targets and step > 0):
                    continue
                end = reached(tour, i, j, time)
                if end <= until + length:
                    after[i, j, step] = min(
                        count + 1, math.floor((end - tour.ready) / length + shift)
                    )


def steps_of(tour: TimedTour, until: float, count: int, *, nearest: bool = False) -> TimeSteps:
    """Moves in steps, of tours that end in time.

    Parameters
    ----------
    until : float
        [s].
    count : int
        Number of steps.
    nearest : bool
        Whether ends are rounded to the nearest step: good for multipliers, no bound.
    """
    span = until - tour.ready
    length, unit = span / count, span / UNITS
    after = np.empty((tour.targets + 1, tour.targets, count + 1), dtype=np.int32)
    ends = np.empty((tour.targets + 1, count + 1), dtype=np.int32)
    # What rounding does to a quotient never makes a step later.
    _fill_steps(tour, length, unit, until, 0.5 if nearest else -1e-9, after, ends)
    np.maximum(after, 0, out=after)
    return TimeSteps(length, unit, count, after, ends)


def whole_bands(targets: int, count: int) -> Bands:
    """Bands of all steps; the start is left at once, with all targets unserviced."""
    shape = targets + 1, targets + 1
    low, high = np.zeros(shape, dtype=np.int64), np.full(shape, count, dtype=np.int64)
    high[targets] = high[:, targets] = -1
    high[targets, targets] = 0
    return _numbered(low, high)


def _numbered(low: npt.NDArray[np.int64], high: npt.NDArray[np.int64]) -> Bands:
    sizes = np.maximum(high - low + 1, 0).ravel()
    begin = np.cumsum(sizes) - sizes
    return Bands(low, high, begin.reshape(low.shape), int(sizes.sum()))


@inlined
def lower(row, source, onward, charge):
    """Lower values of a state, by memory, to those at a leg's destination plus its charge."""
    for memory in range(onward.size):
        value = source[onward[memory]] + charge
        if value < row[memory]:
            row[memory] = value


@inlined
def level(row):
    """Set all values of impossible states to one value."""
    for memory in range(row.size - 1):
        if row[memory] > NEVER // 2:
            row[memory] = NEVER


@kernel
def _fill_row(relaxation, left, place):
    """Fill the values of a place for a number of unserviced targets."""
    steps, memories, bands, multipliers, values = relaxation
    low, high = bands.low[left, place], bands.high[left, place]
    size = values.shape[1] - 1
    for step in range(low, high + 1):
        row = values[bands.begin[left, place] + step - low]
        for memory in range(size + 1):
            row[memory] = NEVER
        if left == 0:
            for memory in range(size):
                row[memory] = steps.ends[place, step]
            continue
        for j in range(multipliers.size):
            if j == place:
                continue
            then = np.int64(steps.after[place, j, step])
            first, last = bands.low[left - 1, j], bands.high[left - 1, j]
            if then > last or then < first:
                continue
            source = values[bands.begin[left - 1, j] + then - first]
            onward, charge = memories.onward[place, j], np.int32(multipliers[j])
            lower(row, source, onward, charge)
        level(row)


@kernel
def _fill_some(relaxation, left, every, first):
    """Fill the values of some places."""
    for place in range(first, relaxation.bands.low.shape[1], every):
        _fill_row(relaxation, left, place)


def relaxed(
    steps: TimeSteps,
    memories: NearMemories,
    bands: Bands,
    multipliers: npt.NDArray[np.int64],
    jobs: int,
    room: npt.NDArray[np.int32] | None = None,
) -> Relaxation:
    """The relaxation at some multipliers; ``room`` is the storage of an earlier one, reused."""
    shape = bands.rows, memories.onward.shape[2] + 1
    if room is None or room.shape != shape:
        room = np.empty(shape, dtype=np.int32)
    made = Relaxation(steps, memories, bands, multipliers, room)
    targets = multipliers.size
    with ThreadPoolExecutor(max(jobs, 1)) as pool:
        parts = max(jobs, 1)
        for left in range(targets + 1):
            list(pool.map(partial(_fill_some, made, left, parts), range(parts)))
    return made


def bound_units(relaxation: Relaxation) -> int:
    """Lower bound on the end of a tour since the start [units]; NEVER or more if there is none."""
    targets = relaxation.multipliers.size
    row = int(relaxation.bands.begin[targets, targets])
    if relaxation.bands.high[targets, targets] < 0:
        return NEVER
    least = int(relaxation.values[row, 0])
    return NEVER if least >= NEVER else least - int(relaxation.multipliers.sum())


@kernel
def _forwards(steps, bands, multipliers, done, before, now):
    """Least charges after servicing a number of targets, by place and step, from one fewer.

    Parameters
    ----------
    done : int
        Number of targets done after it.
    before, now : (targets + 1, steps + 1) int64
        By place and step by which it is left; ``now`` is written.
    """
    targets, count = multipliers.size, steps.total
    for j in range(targets + 1):
        for step in range(count + 1):
            now[j, step] = NEVER
    for i in range(targets + 1):
        low, high = bands.low[targets - done + 1, i], bands.high[targets - done + 1, i]
        for step in range(low, high + 1):
            if before[i, step] >= NEVER:
                continue
            for j in range(targets):
                then = steps.after[i, j, step]
                if j != i and then <= count:
                    now[j, then] = min(now[j, then], before[i, step] + multipliers[j])
    for j in range(targets):
        for step in range(1, count + 1):
            now[j, step] = min(now[j, step], now[j, step - 1])


def narrowed(relaxation: Relaxation, most: int, finer: int) -> Bands:
    """Bands of the steps in which a relaxed tour can be that ends by a number of units.

    Parameters
    ----------
    relaxation : Relaxation
        A bound: with moves rounded down.
    most : int
        [units].
    finer : int
        Number of steps that become of each.
    """
    steps, _, bands, multipliers, values = relaxation
    targets, count = multipliers.size, steps.total
    low, high = np.zeros_like(bands.low), np.full_like(bands.high, -1)
    low[targets, targets] = high[targets, targets] = 0
    before = np.full((targets + 1, count + 1), NEVER, dtype=np.int64)
    before[targets, 0] = 0
    now, total = np.empty_like(before), int(multipliers.sum())
    for done in range(1, targets + 1):
        _forwards(steps, bands, multipliers, done, before, now)
        left = targets - done
        for place in range(targets):
            first, last = int(bands.low[left, place]), int(bands.high[left, place])
            begin = int(bands.begin[left, place])
            rest = values[begin : begin + max(last - first + 1, 0), 0].astype(np.int64)
            possible = np.flatnonzero(now[place, first : last + 1] + rest - total <= most)
            if possible.size:
                low[left, place] = (first + int(possible[0])) * finer
                high[left, place] = (first + int(possible[-1]) + 1) * finer - 1
        before, now = now, before
    low[targets, targets] = high[targets, targets] = 0
    top = count * finer
    return _numbered(low, np.minimum(high, top))
