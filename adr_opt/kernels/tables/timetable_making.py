"""Construction of timetables: the order of pairs, and the choice among their connections."""

import math
from typing import NamedTuple

import numpy as np

from ...common.constants import TURN_RAD
from ..core.compile import kernel
from ..core.events import earliest_taken
from ..core.windows import Windows, service_begin
from ..legs import co_elliptic, sequences
from ..legs.found import ConnectionArrays
from ..orbits.ephemeris import EPOCH_S, revolution_at
from .on_demand import Source
from .timetable import NO_SLOTS, Table, slot_of


class ServiceLimits(NamedTuple):
    """Mission limits on the time at each body, with the slack of the model included.

    Attributes
    ----------
    service : (bodies,) float64
        Time at the body: service, with the tow that follows, or refuelling at a station [s].
    windows : Windows
        When services may begin so that their capture and, before the end of the mission, all of
        their time at the body fit.
    ready : float
        Since when the chaser is there, without slack [s].
    duration : float
        End of the mission [s].
    """

    service: np.ndarray
    windows: Windows
    ready: float
    duration: float


class Pairs(NamedTuple):
    """Order in which pairs of bodies are computed: nearest first.

    Attributes
    ----------
    origins : (bodies,) int64
        All bodies, those first that are wanted first.
    near : (bodies, slots) int32
        Destinations of each body, the nearest first.
    """

    origins: np.ndarray
    near: np.ndarray


WAVE = 16
"""Number of destinations computed for every origin before any origin gets its next ones."""


@kernel
def pair_at(number, pairs):
    """Origin and destination rank of a pair by its number, in waves of :data:`WAVE`."""
    bodies, ranks = pairs.near.shape
    wave = number // (bodies * WAVE)
    rest = number - wave * bodies * WAVE
    width = min(WAVE, ranks - wave * WAVE)
    return pairs.origins[rest // width], wave * WAVE + rest % width


@kernel
def fill(first, last, pairs, inputs, limits, table):
    """Fill pairs from number ``first`` up to ``last``; ranges may be filled in parallel.

    Parameters
    ----------
    first, last : int
    pairs : Pairs
        Each once.
    inputs : tuple
        What transfers follow from: rows of
        :data:`adr_opt.kernels.orbits.ephemeris.ORBIT_COLUMNS`, of bodies as they are left and as
        they are arrived at, shape (bodies, columns); what matching the eccentricity vectors alone
        would cost, shape (bodies, bodies) [m/s]; TransferRule.
    limits : ServiceLimits
    table : Table
        Written in place, these pairs only.
    """
    leaving, bodies, extra_delta_v, rule = inputs
    most = table.entries.shape[1]
    for number in range(first, last):
        i, rank = pair_at(number, pairs)
        j = np.int64(pairs.near[i, rank])
        slot = slot_of(table, i, j)
        half_period = 0.5 * revolution_at(leaving[i], EPOCH_S)
        pair = co_elliptic.prepare(leaving[i], bodies[j], extra_delta_v[i, j], rule, EPOCH_S)
        start, half_turns = co_elliptic.first_departure(pair)
        table.first[i, slot] = start
        approach = rule.approach_revolutions * TURN_RAD / pair.rate_j
        m = 0
        while m < most:
            departure = start + m * half_period
            if departure > limits.duration:
                break
            if departure < earliest_taken(limits.ready):
                # Before any chaser is available; one that asks waits for later departures.
                table.entries[i, m, slot, 0] = math.inf
                table.entries[i, m, slot, 1] = math.inf
                m += 1
                continue
            lead = co_elliptic.target_lead(pair, departure, half_turns + m)
            best = sequences.best_sequence(
                pair, rule, departure, lead, limits.windows, j, departure + approach
            )
            table.entries[i, m, slot, 0] = best.delta_v
            table.entries[i, m, slot, 1] = departure + best.flight_time + approach
            m += 1
        table.total[i, slot] = m
        for event in range(m, most):
            table.entries[i, event, slot, 0] = math.inf
            table.entries[i, event, slot, 1] = math.inf
        # A ready chaser may wait for later departures: the best of each event and all after it.
        for event in range(m - 2, -1, -1):
            here, later = table.entries[i, event, slot], table.entries[i, event + 1, slot]
            longer = service_begin(limits.windows, j, later[1])
            longer -= service_begin(limits.windows, j, here[1])
            # Of two infinities the difference is no number, and not less.
            if here[0] == math.inf or later[0] + rule.time_value * longer < here[0]:
                here[0], here[1] = later[0], later[1]


@kernel
def choose(found, limits, j, time_value, taken):
    """The connections of a pair that are ever chosen, in order of departure; returns their number.

    A chaser ready between the previous departure and that of a connection takes it. None is ready
    before the mission's time of that.

    Parameters
    ----------
    found : adr_opt.kernels.legs.found.ConnectionArrays
    limits : ServiceLimits
    j : int
        Destination.
    time_value : float
        [m/s per s].
    taken : (connections,) int64
        Written from the end.
    """
    count = 0
    best = math.inf
    for c in range(found.departure.size - 1, -1, -1):
        begins = service_begin(limits.windows, j, found.arrival[c])
        if begins == math.inf or found.departure[c] > limits.duration:
            continue
        if found.departure[c] < earliest_taken(limits.ready):
            break
        cost = found.delta_v[c] + time_value * begins
        # Of those that leave together one is chosen; an earlier one has to be better.
        if cost < best:
            best = cost
            last = taken.size - count
            if count == 0 or found.departure[taken[last]] > found.departure[c]:
                count += 1
            taken[taken.size - count] = c
    return count


def pack(bodies: int, chosen: dict[tuple[int, int], ConnectionArrays], slot: np.ndarray) -> Table:
    """A table with irregular events.

    Parameters
    ----------
    bodies : int
    chosen : dict of (origin, destination) to ConnectionArrays
        For each pair the connections chosen, in order of departure.
    slot : (bodies, bodies) int16
        As in :class:`Table`.
    """
    most = max([1, *(found.departure.size for found in chosen.values())])
    table = allocate(bodies, most, slot, regular=False)
    table.first[:], table.entries[:] = 0.0, math.inf
    table.departure[:] = math.inf
    table.spacing[:] = 0.0
    for (i, j), found in chosen.items():
        count, at = found.departure.size, slot[i, j] if slot.size else j
        table.total[i, at] = count
        table.departure[i, :count, at] = found.departure
        table.entries[i, :count, at, 0] = found.delta_v
        table.entries[i, :count, at, 1] = found.arrival
        table.first[i, at] = table.departure[i, 0, at] if count else 0.0
    return table


def slots_of(pairs: Pairs) -> np.ndarray:
    """Slots of each body's destinations, as in :attr:`Table.slot`."""
    bodies, ranks = pairs.near.shape
    if ranks >= bodies - 1:
        return NO_SLOTS
    slot = np.full((bodies, bodies), -1, dtype=np.int16)
    np.put_along_axis(slot, pairs.near, np.arange(ranks, dtype=np.int16)[None, :], axis=1)
    slot.setflags(write=False)
    return slot


def allocate(bodies: int, most: int, slot: np.ndarray, *, regular: bool = True) -> Table:
    """An empty table for a number of bodies and a maximum number of events each."""
    slots = bodies if slot.size == 0 else int(slot.max()) + 1
    return Table(
        first=np.zeros((bodies, slots)),
        spacing=np.empty(bodies),
        total=np.zeros((bodies, slots), dtype=np.int32),
        entries=np.empty((bodies, most, slots, 2)),
        departure=np.empty((bodies, 0 if regular else most, slots)),
        slot=slot,
    )


def without_entries(bodies: int, source: Source) -> Table:
    """A table without entries, whose rows are computed on demand."""
    return Table(
        first=np.empty((0, 0)),
        spacing=np.empty(bodies),
        total=np.empty((0, 0), dtype=np.int32),
        entries=np.empty((0, 0, 0, 2)),
        departure=np.empty((0, 0, 0)),
        slot=np.empty((1, 1), dtype=np.int16),
        source=source,
    )


def part_of(table: Table, limits: ServiceLimits, bodies: np.ndarray) -> tuple[Table, ServiceLimits]:
    """A table and its limits for a selection of bodies, in their order.

    What is chosen of a pair depends on no other body. The same arrays where it is all of them.
    """
    if bodies.size == table.spacing.size and bool((bodies == np.arange(bodies.size)).all()):
        return table, limits
    slots = slice(None) if table.slot.size else bodies
    part = Table(
        first=table.first[bodies][:, slots],
        spacing=table.spacing[bodies],
        total=table.total[bodies][:, slots],
        entries=table.entries[bodies][:, :, slots],
        departure=table.departure[bodies][:, :, slots],
        slot=table.slot[np.ix_(bodies, bodies)] if table.slot.size else NO_SLOTS,
    )
    service, windows = limits.service[bodies], limits.windows.of(bodies)
    return part, ServiceLimits(service, windows, limits.ready, limits.duration)


@kernel
def space(bodies, table):
    """Set the spacing of regular events, and remove legs from a body to itself."""
    for i in range(bodies.shape[0]):
        table.spacing[i] = 0.5 * revolution_at(bodies[i], EPOCH_S)
        if table.slot.shape[0] == 0:
            for event in range(table.entries.shape[1]):
                table.entries[i, event, i, 0] = table.entries[i, event, i, 1] = math.inf
