"""A tour of all targets as kernels see it, and its moves.

Targets are numbered from 0, then come the start, the end, and the stations where a chaser may fill
its tank on the way: it does so where that is quicker than the direct leg, and for no other reason.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from adr_opt.kernels.core.compile import inlined, kernel
from adr_opt.kernels.core.windows import Windows, last_begin, service_end
from adr_opt.kernels.legs.given import leg_of
from adr_opt.mission.mission import Mission
from adr_opt.problem.chasers import AtStation

FloatArray = npt.NDArray[np.float64]

MOST_TARGETS = 100
"""Maximum number of targets of a tour."""

HALVINGS = 60
"""Number of halvings of a time span."""


class TimedTour(NamedTuple):
    """A tour of all targets of a mission whose tank never binds.

    Attributes
    ----------
    targets : int
        The start is the place of this number, the end the one after it.
    first : (places² + 1,) int64
        First breakpoint of the function of a pair, by origin · places + destination.
    departure, arrival : (breakpoints,) float64
        [s].
    service : (places,) float64
        [s].
    windows : Windows
        With the slack of limits.
    ready : float
        Since when the chaser is at the start [s].
    anywhere : bool
        Whether the tour ends at its last target.
    """

    targets: int
    first: npt.NDArray[np.int64]
    departure: FloatArray
    arrival: FloatArray
    service: FloatArray
    windows: Windows
    ready: float
    anywhere: bool


@inlined
def _direct(tour, i, j, time):
    """End of the service at a place after the direct leg; +inf if that is too late."""
    places = tour.service.size
    pair = i * places + j
    _, lands = leg_of(tour.departure, tour.arrival, tour.first[pair], tour.first[pair + 1], time)
    return service_end(tour.windows, j, lands, tour.service[j])


@inlined
def last_end(tour, j):
    """Latest end of the service at a place; −inf for none [s]."""
    return last_begin(tour.windows, j) + tour.service[j]


@inlined
def reached(tour, i, j, time):
    """End of the service at a place, from another one at a time; +inf if that is too late.

    Straight, or to a target by a station if that is quicker; to the end of a tour that ends
    anywhere at once.
    """
    targets = tour.targets
    if tour.anywhere and j == targets + 1:
        return time
    best = _direct(tour, i, j, time)
    # A tank is filled after a target and before one, so not on the way to the end.
    if i < targets and j < targets:
        for via in range(targets + 2, tour.service.size):
            refuelled = _direct(tour, i, via, time)
            if refuelled < best:
                best = min(best, _direct(tour, via, j, refuelled))
    return best


@kernel
def via(tour, i, j, time):
    """The station that :func:`reached` goes by; −1 for none."""
    best, found = _direct(tour, i, j, time), -1
    if i < tour.targets and j < tour.targets:
        for station in range(tour.targets + 2, tour.service.size):
            refuelled = _direct(tour, i, station, time)
            if refuelled < best:
                end = _direct(tour, station, j, refuelled)
                if end < best:
                    best, found = end, station
    return found


@kernel
def _latest(tour, i, j, until):
    """Latest time at i from which j is reached by a given time, to a tolerance; −inf for none."""
    low, high = tour.ready, last_end(tour, i)
    if high < low or reached(tour, i, j, low) > until:
        return -math.inf
    if reached(tour, i, j, high) <= until:
        return high
    for _ in range(HALVINGS):
        middle = 0.5 * (low + high)
        if reached(tour, i, j, middle) <= until:
            low = middle
        else:
            high = middle
    return high


@kernel
def deadlines(tour, until):
    """Latest times at a place from which another one can still be reached, by any way.

    Parameters
    ----------
    until : float
        End of the tour at the latest [s].

    Returns
    -------
    (targets + 1, targets + 1) float64
        By origin (the start comes last) and destination (the end comes last) [s]; no earlier than
        they are.
    """
    size, end = tour.targets, tour.targets + 1
    found = np.empty((size + 1, size + 1))
    for i in range(size + 1):
        for j in range(size + 1):
            to = end if j == size else j
            found[i, j] = _latest(tour, i, to, min(until, last_end(tour, to)))
            if i == j and i < size:
                found[i, j] = last_end(tour, i)
    better = True
    while better:
        better = False
        for i in range(size + 1):
            for by in range(size):
                for j in range(size + 1):
                    if by in (i, j):
                        continue
                    last = found[by, j]
                    now = max(found[i, j], tour.ready)
                    if (
                        last > -math.inf
                        and now < last_end(tour, i)
                        and (reached(tour, i, by, now + 1e-9 * (1.0 + abs(now))) <= last)
                    ):
                        later = _latest(tour, i, by, last)
                        if later > found[i, j]:
                            found[i, j], better = later, True
    return found


def tour_of(mission: Mission) -> TimedTour | None:
    """The tour of all targets of a mission; None if the mission is not such a tour.

    All is well with functions of time alone where the cost is the duration, and the tank holds
    what the dearest legs take; of lists of connections the earliest arrivals make a function.
    """
    instance, rules = mission.instance, mission.rules
    targets = len(instance.targets)
    if instance.objective.cost != "duration" or rules.limits.targets < targets:
        return None
    if not 1 <= targets <= MOST_TARGETS:
        return None
    chaser = mission.chaser
    ends = [
        number
        for number, station in enumerate(instance.stations)
        if isinstance(chaser.end, AtStation) and station.name == chaser.end.station
    ]
    begin = rules.first_target
    bodies = [*range(begin, begin + targets), rules.start, *(ends or [rules.start])]
    stations = range(len(instance.stations))
    between = [s for s in stations if _leads(mission, s, to=True) and _leads(mission, s, to=False)]
    bodies += between
    first, leaves, lands, dearest = [0], [np.empty(0)], [np.empty(0)], 0.0
    for i in bodies:
        for j in bodies:
            departure, arrival, cost = _function(mission, i, j)
            first.append(first[-1] + departure.size)
            leaves.append(departure)
            lands.append(arrival)
            dearest = max(dearest, cost)
    if dearest * 2.0 * (targets + 1) > rules.budget:
        return None
    service, windows = rules.service[bodies], rules.windows.of(np.array(bodies))
    # Also of a station that refuels nobody.
    for place in (targets, targets + 1)[: 1 if ends else 2]:
        windows = windows.later(place, rules.duration - service[place])
    return TimedTour(
        targets,
        np.array(first, dtype=np.int64),
        np.concatenate(leaves),
        np.concatenate(lands),
        service,
        windows,
        rules.ready,
        not ends,
    )


def _leads(mission: Mission, station: int, *, to: bool) -> bool:
    """Whether any leg leads to a station from a target, or back."""
    rules = mission.rules
    for j in range(rules.first_target, rules.service.size):
        pair = (j, station) if to else (station, j)
        if _function(mission, *pair)[0].size:
            return True
    return False


def _function(mission: Mission, i: int, j: int) -> tuple[FloatArray, FloatArray, float]:
    """Earliest arrivals of a pair as breakpoints, and its largest cost of a leg."""
    none = np.empty(0), np.empty(0), 0.0
    if i == j:
        return none
    connecting = mission.connecting
    function = connecting.function_of(i, j)
    if function is not None:
        return function.departure, function.arrival, function.cost + connecting.spent_m_s(i)
    found = mission.schedules.connections(i, j)
    if not found.departure.size:
        return none
    # Until a departure one arrives with the earliest of those from then on: a jump after each.
    earliest = np.minimum.accumulate(found.arrival[::-1])[::-1]
    departure, first = np.unique(found.departure, return_index=True)
    arrival = earliest[first]
    leaves = np.repeat(departure, 2)[:-1]
    return leaves, np.repeat(arrival, 2)[1:], float(found.delta_v.max())


def sequence_of(mission: Mission, tour: TimedTour, order: npt.NDArray[np.int64]) -> tuple[int, ...]:
    """The bodies of a tour in an order of targets, with stations on the way and at the end."""
    rules, chaser = mission.rules, mission.chaser
    stations = [
        s
        for s in range(len(mission.instance.stations))
        if _leads(mission, s, to=True) and _leads(mission, s, to=False)
    ]
    moves, time, here = list[int](), tour.ready, tour.targets
    end = tour.targets + 1
    for j in (*order.tolist(), *([] if tour.anywhere else [end])):
        by = int(via(tour, here, j, time))
        if by >= 0:
            moves.append(stations[by - tour.targets - 2])
        time, here = float(reached(tour, here, j, time)), j
        if j < end:
            moves.append(rules.first_target + j)
    if isinstance(chaser.end, AtStation):
        moves.append(mission.names.index(chaser.end.station))
    return tuple(moves)
