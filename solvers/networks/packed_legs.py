"""Legs of a mission in few bytes each, made origin by origin: a network for any size.

The network of all connections (:mod:`.network`) is kept whole before walks are given a smaller one.
Here each origin's connections are worked out, brought into whole numbers and forgotten, so that
what is kept at any time is what walks need: a leg is one integer. Everything is rounded so that
more is allowed, never less:

- Time is counted in *steps* of one length for all bodies. A leg that departs within a step may be
    taken by a walk that is there by the end of the step, and a walk ready within a step is ready at
    its start: ⌊·⌋ is monotone, so all departures in time are in time in steps. Steps are counted
  from 1, and launches, which take no time, depart a step before all that they lead to.
- ΔV is counted in *units*, rounded down: Σ ⌊ΔV/u⌋ ≤ ⌊Σ ΔV/u⌋ ≤ ⌊budget/u⌋.
- Legs of a pair are left out that cost no less than another one of the pair that departs no earlier
  and lands no later, all in whole numbers: every walk can take that one, by waiting for it.
"""

from __future__ import annotations

import math
import threading
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from typing import NamedTuple

import numpy as np

from adr_opt.common.stop import TimeIsOver
from adr_opt.kernels.core.compile import inlined, kernel
from adr_opt.kernels.core.events import earliest_taken
from adr_opt.kernels.core.lists import wider
from adr_opt.kernels.core.windows import service_end
from adr_opt.mission.mission import Mission

from .layers import SLACK
from .network import found_of, listed_of, reachable

DEPARTURE, DESTINATION, AHEAD = 48, 32, 16
FIELD = 0xFFFF
"""Largest value of a field; a leg has four of 16 bits: departure step, destination, steps, ΔV."""

MOST = 2**15 - 2
"""Maximum number of steps, bodies and units, which fit in 16 bits without affecting the sign."""

NEVER = 2**62
"""Number of steps above that of any mission."""


class Stream(NamedTuple):
    """Legs of all bodies as integers.

    Attributes
    ----------
    length : float
        Of a step of time [s].
    unit : float
        Of ΔV [m/s].
    steps : int
        The last one, in which nothing departs any more.
    root : int
        In which the mission begins.
    legs : (legs,) int64
        Packed, those of a body together, in order of departure. Bodies are in no order.
    first, last : (bodies,) int64
        Where the legs of each body are: from ``first`` to before ``last``.
    least : int
        No leg lands fewer steps after its departure; all of them where there is no leg.
    """

    length: float
    unit: float
    steps: int
    root: int
    legs: np.ndarray
    first: np.ndarray
    last: np.ndarray
    least: int


@inlined
def first_leg(stream, body, step):
    """First leg of a body that departs at or after a step; the end of its legs if none does."""
    low, high = stream.first[body], stream.last[body]
    while low < high:
        middle = (low + high) // 2
        if stream.legs[middle] >> DEPARTURE < step:
            low = middle + 1
        else:
            high = middle
    return low


class LegUnits(NamedTuple):
    """Units of legs: a time step [s] and a unit of ΔV [m/s]."""

    length: float
    unit: float


class NoRoom(Exception):
    """The legs exceed the available memory."""


@kernel
def _put(j, found, rules, units, ahead, earliest, room, count):
    """Append the undominated legs of one pair after ``count`` others.

    Parameters
    ----------
    units : LegUnits
    ahead : int
        What departures are later by than their step.
    earliest : (units + 1,) int64
        Scratch: when one lands at the earliest who departs later and pays no more.
    room : (legs,) int64

    Returns
    -------
    room : (legs,) int64
        The same, or a larger one.
    count : int
    """
    length, unit = units
    for cost in range(earliest.size):
        earliest[cost] = NEVER
    for c in range(found.departure.size - 1, -1, -1):
        done = service_end(rules.windows, j, found.arrival[c], rules.service[j])
        if found.delta_v[c] > rules.budget or done == math.inf:
            continue
        departure = max(0, math.floor(found.departure[c] / length)) + ahead
        landing = max(0, math.floor(earliest_taken(done) / length)) + 1
        cost = int(max(0.0, math.floor(found.delta_v[c] / unit - SLACK)))
        if earliest[cost] <= landing:
            continue
        for dearer in range(cost, earliest.size):
            if earliest[dearer] <= landing:
                break
            earliest[dearer] = landing
        if count == room.size:
            room = wider(room, count)
        room[count] = (
            (np.int64(departure) << DEPARTURE)
            | (np.int64(j) << DESTINATION)
            | (np.int64(landing - departure) << AHEAD)
            | np.int64(cost)
        )
        count += 1
    return room, count


@kernel
def _of_body(i, inputs, listed, rules, is_start, units, most, ahead):
    """Undominated legs of a body, and the least number of steps of any.

    Parameters
    ----------
    inputs : tuple
        As :attr:`adr_opt.mission.problem.Mission.transfer_inputs`.
    units : LegUnits
    most : int
        Units of a full tank.
    ahead : int
        As of :func:`_put`.
    """
    leaving, orbits, extra_delta_v, transfer_rule = inputs
    room, count = np.empty(4096, np.int64), 0
    earliest = np.empty(most + 1, np.int64)
    for j in range(rules.service.size):
        if not reachable(i, j, rules, is_start):
            continue
        found = found_of(
            i, j, leaving, orbits, extra_delta_v, transfer_rule, listed, rules.duration
        )
        room, count = _put(j, found, rules, units, ahead, earliest, room, count)
    least = NEVER
    for leg in range(count):
        least = min(least, (room[leg] >> AHEAD) & FIELD)
    return room[:count], least


class LegSource:
    """The legs of a mission, origin by origin.

    Parameters
    ----------
    mission : Mission
    """

    def __init__(self, mission: Mission) -> None:
        self._mission = mission
        self._inputs, self._rules = mission.transfer_inputs, mission.rules
        self.bodies = int(self._rules.service.size)
        self._is_start = np.zeros(self.bodies, dtype=np.bool_)
        self._is_start[self._rules.start] = True
        self._launches = mission.instance.launches

    def of(self, i: int, length: float, unit: float) -> tuple[np.ndarray, int]:
        """Legs of a body, and the least number of steps of any.

        Parameters
        ----------
        i : int
        length, unit : float
            Of a step of time [s], and of ΔV [m/s].
        """
        found: tuple[np.ndarray, int] = _of_body(
            i,
            self._inputs,
            listed_of(self._mission, i),
            self._rules,
            self._is_start,
            LegUnits(length, unit),
            units_of(self._rules.budget, unit),
            int(i not in self._launches),
        )
        return found

    def stream(
        self, length: float, unit: float, room: int, *, jobs: int, over: Callable[[], bool]
    ) -> Stream:
        """Legs of all bodies.

        Parameters
        ----------
        length, unit : float
            As :meth:`of` takes them.
        room : int
            Most legs. What is not needed of it takes no memory.
        jobs : int
            Threads. Which legs there are does not depend on it.
        over : callable
            Whether the time is over.

        Raises
        ------
        NoRoom
            There are more legs.
        TimeIsOver
            It was broken off.
        """
        rules = self._rules
        steps = math.floor(rules.duration / length) + 2
        if max(steps, self.bodies, units_of(rules.budget, unit)) > MOST:
            raise NoRoom
        legs = np.empty(room, dtype=np.int64)
        first, last = np.zeros((2, self.bodies), dtype=np.int64)
        lock, used, least = threading.Lock(), 0, NEVER

        def fill(i: int) -> None:
            nonlocal used, least
            if over():
                raise TimeIsOver
            if used > room:
                return  # in vain
            own, fewest = self.of(i, length, unit)
            own.sort()
            with lock:
                at, used = used, used + own.size
                least = min(least, int(fewest))
            if used <= room:
                legs[at : at + own.size] = own
                first[i], last[i] = at, at + own.size

        with ThreadPoolExecutor(jobs) as pool:
            list(pool.map(fill, range(self.bodies)))
        if used > room:
            raise NoRoom
        root = max(0, math.floor(earliest_taken(rules.ready) / length))
        root += rules.start not in self._launches
        return Stream(length, unit, steps, root, legs[:used], first, last, min(least, steps))


def units_of(budget: float, unit: float) -> int:
    """Number of units in a full tank."""
    return math.floor(budget / unit + SLACK)
