"""The timetable of a choice: the connection that is chosen at each departure event of each pair.

Who is ready for an event may take any connection that departs then or later. A *choice* settles
which: the one of least ΔV + w · arrival, where w is the value of time (MODEL section 4). Between
two events nothing depends on the time but the wait, so a table over events is exact. How events are
spaced and where entries lie is known to this module alone: planners ask :func:`next_event` and
:func:`lookup`.

The events of two-body motion are half a period apart, and are counted. Where nodes drift they are
not; then a table holds when the connections depart that are ever chosen, and nothing else.

Hints are worked out for ready times a fixed step apart, see :func:`steps_begun`.

Who steps hundreds of missions keeps timetables side by side, with a leading axis of slots, and the
entries of one destination packed, as a :class:`Column`.
"""

import math
from typing import NamedTuple

import numpy as np

from . import orbits, sequences, transfer
from .compile import inlined, kernel
from .connections import Found
from .constants import SLACK_S

LEAST_STEPS = 500
"""Where events are not regular, the duration is divided into so many steps at least."""


class Limits(NamedTuple):
    """What the mission says of the time at each body; the slack of the model is in it.

    Attributes
    ----------
    service : (bodies,) float64
        Time at the body: service, or refuelling at a station [s].
    opens, closes : (bodies,) float64
        No service begins before, or ends after [s].
    ready : float
        Since when the chaser is there, without slack [s].
    duration : float
        End of the mission [s].
    """

    service: np.ndarray
    opens: np.ndarray
    closes: np.ndarray
    ready: float
    duration: float


class Table(NamedTuple):
    """Exact ΔV and arrival of the connection chosen at every departure event.

    Attributes
    ----------
    first : (bodies, bodies) float64
        Time of the first departure event of the pair (origin, destination) [s].
    spacing : (bodies,) float64
        Time between events of an origin: half its period, or its multiple; where events are not
        regular, the step of the times that hints are worked out for [s].
    total : (bodies, bodies) int32
        Number of events at or before the end of the mission; 0 on the diagonal.
    entries : (bodies, events, bodies, 2) float64
        ΔV [m/s] and arrival, the end of the approach [s], of (origin, event, destination);
        both +inf where no connection departs at the event or later. Destinations lie side by side
        because planners ask for all of them at one time, and their events then have equal or
        adjacent numbers.
    departure : (bodies, events, bodies) float64
        When an event is [s]; without events where they are regular.
    """

    first: np.ndarray
    spacing: np.ndarray
    total: np.ndarray
    entries: np.ndarray
    departure: np.ndarray


class Column(NamedTuple):
    """The entries of one destination, packed in half the memory.

    Attributes
    ----------
    first : (bodies,) float64
        Time of the first departure event of each origin [s].
    total : (bodies,) int32
        Number of events; 0 for the destination itself.
    entries : (bodies, events, 2) float32
        ΔV [m/s], and arrival after the departure event [s].
    departure : (bodies, events) float64
        As in :class:`Table` [s].
    """

    first: np.ndarray
    total: np.ndarray
    entries: np.ndarray
    departure: np.ndarray


@kernel
def fill(first, last, order, bodies, extra_delta_v, rule, limits, table):
    """Fill the pairs from number ``first`` to before ``last``; all may be filled in parallel.

    Pairs are numbered by shells: the first n² are those among the first n bodies of an order, so
    that a table that is broken off is whole for the bodies that come first.

    Parameters
    ----------
    first, last : int
    order : (bodies,) int64
        The bodies, each once.
    bodies : (bodies, columns) float64
        Rows of :data:`adr_opt.kernels.orbits.ORBIT_COLUMNS`.
    extra_delta_v : (bodies, bodies) float64
        What matching the eccentricity vectors alone would cost [m/s].
    rule : TransferRule
    limits : Limits
    table : Table
        Written in place, these pairs only.
    """
    most = table.entries.shape[1]
    for number in range(first, last):
        shell = int(math.sqrt(number))
        rest = number - shell * shell
        i = order[rest] if rest < shell else order[shell]
        j = order[shell] if rest < shell else order[rest - shell]
        half_period = 0.5 * orbits.revolution(bodies[i])
        m = 0
        if i == j:
            table.spacing[i] = half_period
            table.first[i, i] = 0.0
        else:
            pair = transfer.prepare(bodies[i], bodies[j], extra_delta_v[i, j], rule)
            start, half_turns = transfer.first_departure(pair)
            table.first[i, j] = start
            approach = rule.approach_revolutions * transfer.TWO_PI / pair.rate_j
            # The arrival that service has to wait for, and the last that leaves time for it.
            opens = limits.opens[j] - approach
            closes = limits.closes[j] - limits.service[j] - approach
            while m < most:
                departure = start + m * half_period
                if departure > limits.duration:
                    break
                lead = transfer.target_lead(pair, departure, half_turns + m)
                best = sequences.best_sequence(
                    pair, rule, departure, lead, opens - departure, closes - departure
                )
                table.entries[i, m, j, 0] = best.delta_v
                table.entries[i, m, j, 1] = departure + best.flight_time + approach
                m += 1
        table.total[i, j] = m
        for event in range(m, most):
            table.entries[i, event, j, 0] = math.inf
            table.entries[i, event, j, 1] = math.inf
        # Who is ready may wait for what leaves later: the best of each event and all after it.
        for event in range(m - 2, -1, -1):
            here, later = table.entries[i, event, j], table.entries[i, event + 1, j]
            longer = max(later[1], limits.opens[j]) - max(here[1], limits.opens[j])
            # Of two infinities the difference is no number, and not less.
            if here[0] == math.inf or later[0] + rule.time_value * longer < here[0]:
                here[0], here[1] = later[0], later[1]


@kernel
def choose(found, limits, j, time_value, taken):
    """The connections of a pair that are ever chosen, in order of departure; how many.

    Whoever is ready between the departure before and that of a connection takes it.

    Parameters
    ----------
    found : adr_opt.kernels.connections.Found
    limits : Limits
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
        begins = max(found.arrival[c], limits.opens[j])
        if begins + limits.service[j] > limits.closes[j] or found.departure[c] > limits.duration:
            continue
        cost = found.delta_v[c] + time_value * begins
        # Of those that leave together one is chosen; an earlier one has to be better.
        if cost < best:
            best = cost
            last = taken.size - count
            if count == 0 or found.departure[taken[last]] > found.departure[c]:
                count += 1
            taken[taken.size - count] = c
    return count


def pack(bodies: int, chosen: dict[tuple[int, int], Found], duration: float) -> Table:
    """A table whose events are not regular.

    Parameters
    ----------
    bodies : int
    chosen : dict of (origin, destination) to Found
        For each pair the connections chosen, in order of departure.
    duration : float
        Of the mission [s].
    """
    most = max([1, *(found.departure.size for found in chosen.values())])
    table = allocate(bodies, most, regular=False)
    table.first[:], table.total[:], table.entries[:] = 0.0, 0, math.inf
    table.departure[:] = math.inf
    table.spacing[:] = max(duration, 1.0) / max(most, LEAST_STEPS) * (1.0 + 1e-9)
    for (i, j), found in chosen.items():
        count = found.departure.size
        table.total[i, j] = count
        table.departure[i, :count, j] = found.departure
        table.entries[i, :count, j, 0] = found.delta_v
        table.entries[i, :count, j, 1] = found.arrival
        table.first[i, j] = table.departure[i, 0, j] if count else 0.0
    return table


def allocate(bodies: int, most: int, *, regular: bool = True) -> Table:
    """A table of so many bodies and at most so many events of each; nothing is in it yet."""
    return Table(
        first=np.empty((bodies, bodies)),
        spacing=np.empty(bodies),
        total=np.empty((bodies, bodies), dtype=np.int32),
        entries=np.empty((bodies, most, bodies, 2)),
        departure=np.empty((bodies, 0 if regular else most, bodies)),
    )


def size_of(bodies: int, most: int) -> int:
    """Bytes that such a table takes."""
    return bodies**2 * (16 * most + 12)


def most_events(table: Table) -> int:
    """For how many departure events of a pair there is room."""
    return int(table.entries.shape[-3])


def most_steps(table: Table) -> int:
    """For how many times hints are worked out: numbers of :func:`steps_begun` from 0 on."""
    most = most_events(table)
    return most if is_regular(table) else max(most, LEAST_STEPS) + 1


def is_regular(table: Table) -> bool:
    """Whether events are a fixed time apart."""
    return int(table.departure.shape[-2]) == 0


def count_entries(table: Table) -> int:
    """How many departure events all pairs have."""
    return int(table.total.sum())


def shortest_spacing(table: Table) -> float:
    """Least time between two departure events of a pair [s]."""
    if is_regular(table):
        return float(table.spacing.min())
    steps = np.diff(table.departure, axis=1)
    return float(np.min(steps, where=np.isfinite(steps), initial=math.inf))


def allocate_slots(slots: int, bodies: int, most: int, *, regular: bool) -> tuple[Table, Column]:
    """Tables and columns side by side, without a departure event yet."""
    listed = 0 if regular else most
    return Table(
        first=np.zeros((slots, bodies, bodies)),
        spacing=np.ones((slots, bodies)),
        total=np.zeros((slots, bodies, bodies), dtype=np.int32),
        entries=np.full((slots, bodies, most, bodies, 2), np.inf),
        departure=np.full((slots, bodies, listed, bodies), np.inf),
    ), Column(
        first=np.zeros((slots, bodies)),
        total=np.zeros((slots, bodies), dtype=np.int32),
        entries=np.zeros((slots, bodies, most, 2), dtype=np.float32),
        departure=np.full((slots, bodies, listed), np.inf),
    )


def put(tables: Table, slot: int, table: Table) -> None:
    """Copy a table into a slot that may have room for more bodies and events."""
    bodies, most = table.entries.shape[:2]
    tables.first[slot, :bodies, :bodies] = table.first
    tables.spacing[slot, :bodies] = table.spacing
    tables.total[slot, :bodies, :bodies] = table.total
    tables.entries[slot] = np.inf
    tables.entries[slot, :bodies, :most, :bodies] = table.entries
    tables.departure[slot] = np.inf
    tables.departure[slot, :bodies, : table.departure.shape[1], :bodies] = table.departure


def part(table: Table, kept: np.ndarray) -> Table:
    """The table of some bodies, in ascending order; it takes the memory of the whole one over."""

    def packed(array: np.ndarray) -> np.ndarray:
        # Every row moves towards the beginning, or stays, so that no row is overwritten unread.
        shape = (len(kept), array.shape[1], len(kept), *array.shape[3:])
        room = array.reshape(-1)[: math.prod(shape)].reshape(shape)
        for row, body in enumerate(kept):
            room[row] = array[body][:, kept]
        return room

    pairs = np.ix_(kept, kept)
    return Table(
        first=table.first[pairs],
        spacing=table.spacing[kept],
        total=table.total[pairs],
        entries=packed(table.entries),
        departure=packed(table.departure),
    )


@inlined
def in_slot(tables, slot):
    """One of the tables that stand side by side."""
    return Table(
        tables.first[slot], tables.spacing[slot], tables.total[slot], tables.entries[slot],
        tables.departure[slot],
    )  # fmt: skip


@inlined
def column_in_slot(columns, slot):
    """One of the columns."""
    return Column(
        columns.first[slot], columns.total[slot], columns.entries[slot], columns.departure[slot]
    )


@inlined
def events(table, i, j):
    """Number of departure events of the pair, numbered from 0 in time order."""
    return table.total[i, j]


@inlined
def departure_at(table, i, j, event):
    """Time of a departure event of the pair [s]."""
    if table.departure.shape[1] > 0:
        return table.departure[i, event, j]
    return table.first[i, j] + event * table.spacing[i]


@inlined
def entry_at(table, i, j, event):
    """ΔV [m/s] and arrival [s] of the transfer that leaves at an event; +inf for none."""
    return table.entries[i, event, j, 0], table.entries[i, event, j, 1]


@inlined
def earliest_taken(ready):
    """The earliest departure that a chaser takes who is ready at a time: a slack before it."""
    return ready - SLACK_S


@inlined
def next_event(table, i, j, ready):
    """The event that a chaser takes; :func:`events` of the pair if there is none left."""
    earliest = earliest_taken(ready)
    if table.departure.shape[1] > 0:
        low, high = 0, table.total[i, j]
        while low < high:
            middle = (low + high) // 2
            if table.departure[i, middle, j] < earliest:
                low = middle + 1
            else:
                high = middle
        return low
    spacing = table.spacing[i]
    first = table.first[i, j]
    m = max(0, math.ceil((earliest - first) / spacing))
    # The quotient may be rounded across an integer; the event's own time decides.
    if m > 0 and first + (m - 1) * spacing >= earliest:
        m -= 1
    elif first + m * spacing < earliest:
        m += 1
    return min(m, table.total[i, j])


@inlined
def lookup(table, i, j, time):
    """The transfer of a chaser that is ready at body i at a time and wants body j.

    Returns
    -------
    delta_v : float
        [m/s]; +inf where there is no transfer.
    arrival : float
        End of the approach, before service [s].
    """
    m = next_event(table, i, j, time)
    if m >= table.total[i, j]:
        return math.inf, math.inf
    return table.entries[i, m, j, 0], table.entries[i, m, j, 1]


@inlined
def steps_begun(table, i, time):
    """How many steps of a body have begun at a time.

    A step is its half period, from event to event of any pair; where events are not regular, the
    same part of the mission for all bodies.
    """
    return math.ceil(time / table.spacing[i])


@inlined
def after_steps(table, i, number):
    """When they have [s]."""
    return number * table.spacing[i]


@kernel
def fill_column(table, j, column):
    """Pack the entries of a destination into a column, which may have room for more."""
    for i in range(table.spacing.size):
        column.first[i], column.total[i] = 0.0, 0
        if i != j:
            column.first[i], column.total[i] = table.first[i, j], table.total[i, j]
            for m in range(table.total[i, j]):
                delta_v, arrival = entry_at(table, i, j, m)
                column.entries[i, m, 0] = delta_v
                departure = departure_at(table, i, j, m)
                column.entries[i, m, 1] = arrival - departure
                if column.departure.shape[1] > 0:
                    column.departure[i, m] = departure


@inlined
def lookup_in_column(column, table, i, ready):
    """ΔV [m/s] and time [s] from ready to the arrival at the destination; +inf for no transfer."""
    if column.departure.shape[1] > 0:
        low, high = 0, column.total[i]
        while low < high:
            middle = (low + high) // 2
            if column.departure[i, middle] < earliest_taken(ready):
                low = middle + 1
            else:
                high = middle
        if low >= column.total[i]:
            return math.inf, math.inf
        time = column.departure[i, low] - ready + column.entries[i, low, 1]
        return column.entries[i, low, 0], time
    spacing = table.spacing[i]
    m = max(0, math.ceil((earliest_taken(ready) - column.first[i]) / spacing))
    if m >= column.total[i]:
        return math.inf, math.inf
    time = column.first[i] + m * spacing - ready + column.entries[i, m, 1]
    return column.entries[i, m, 0], time


@kernel
def transfer_exists(table):
    """Whether a body can be reached at all, by index: from any body, at any event."""
    bodies = table.first.shape[0]
    found = np.zeros(bodies, dtype=np.bool_)
    for j in range(bodies):
        for i in range(bodies):
            for m in range(events(table, i, j)):
                if math.isfinite(entry_at(table, i, j, m)[0]):
                    found[j] = True
                    break
            if found[j]:
                break
    return found


@kernel
def sample(table, departures, delta_v, duration):
    """Sample the table on a list of ready times, into arrays (departure, origin, destination)."""
    bodies = table.first.shape[0]
    for d in range(departures.size):
        for i in range(bodies):
            for j in range(bodies):
                if i == j:
                    delta_v[d, i, j] = 0.0
                    duration[d, i, j] = 0.0
                else:
                    dv, arrival = lookup(table, i, j, departures[d])
                    delta_v[d, i, j] = dv
                    duration[d, i, j] = arrival - departures[d]
