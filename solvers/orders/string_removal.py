"""Slack induction by string removals (Christiaens and Vanden Berghe 2020), for one chaser.

An iteration takes some strings of targets out of the order, from where a target that is drawn would
have its neighbours, and puts all targets that are missing back in, one after the other, each where
most time is left afterwards; positions are passed over at random now and then. Simulated annealing
decides whether to go on with the result. The value of an order is what it collects, and what the
time is worth by which the chaser might be later, in the mean over its targets: the time of its end
says little, as a plan of months waits for planes here and there. Whether a target fits in is asked
of :mod:`.fronts`, which answers for hundreds of connections of a pair and all ways to refuel.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator
from copy import copy
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from adr_opt.common.constants import HOUR_S
from adr_opt.common.stop import Stop, TimeIsOver
from adr_opt.kernels.core.compile import inlined, kernel
from adr_opt.kernels.core.lists import rising
from adr_opt.kernels.core.memory import borrowed, write
from adr_opt.mission.mission import Mission

from ..beams.beams import TIME_VALUE_M_S_PER_H
from ..beams.exchange_rates import worth_of
from ..progress.halting import halted_by
from ..routes.strings import mark_strings, take_out
from . import bit_orders, fronts
from .connection_table import is_varied, table_of
from .reach import Reach, reach_of


class AnnealingSchedule(NamedTuple):
    """Objective weights of an order, and temperatures.

    Attributes
    ----------
    worth : float
        Worth of a second [prizes per s].
    hot, cold : float
        Temperatures at the beginning and at the end [prizes].
    iterations : int
    """

    worth: float
    hot: float
    cold: float
    iterations: int


@inlined
def temperature(schedule, iteration):
    """Temperature of an iteration, falling geometrically [prizes]."""
    hot, cold = schedule.hot, schedule.cold
    return hot * (cold / hot) ** (iteration / schedule.iterations)


HOT, COLD = 1.0, 0.03
"""First and last temperature of the annealing, in mean prizes."""

TIME_COUNTS = 0.3
"""Weight of time in the objective of an order, as a share of its value. At full weight, remote
targets would cost more time than their prize is worth, and unused time would count as gain."""

NEIGHBOURS = 3
"""Number of nearest targets whose mean distance defines the remoteness of a target."""

ANNEALED = 300
"""Iterations of an annealing."""

MANY = 10
"""Ratio of iterations where all connections of a pair take about the same ΔV to those elsewhere."""

AS_LONG, GROWTH, MOST_GROWTH = 4, 4, 3
"""In the former case, number of annealings of equal length, its growth, and number of growths."""

BY_ABSENCE, BY_REMOTENESS, BY_PRIZE = 0.3, 0.5, 0.8
"""Cumulative shares of the orders in which missing targets are reinserted: those missing most often
first, the remotest, those of most prize; the rest are random."""

PATIENCE = 0.99
"""Factor per iteration on the memory of missing targets."""


class Surroundings(NamedTuple):
    """Distances between targets.

    Attributes
    ----------
    near : (bodies, targets) int64
        The targets by how near they are to each body, itself first.
    far : (bodies,) float64
        How far each target is from others.
    reach : Reach
        What a leg between them costs at least.
    absent : (bodies,) float64
        Share of the iterations in which each target was missing, smoothed; updated.
    """

    near: np.ndarray
    far: np.ndarray
    reach: Reach
    absent: np.ndarray


@kernel
def ruin(order, length, near, rng):
    """Remove strings of targets from an order.

    Returns
    -------
    length, first, last : int
        Targets left; positions before ``first`` are as they were, and so are those from ``last``
        on, counted anew.
    """
    targets = order.size
    place = np.empty(near.shape[0], np.int64)
    for p in range(near.shape[0]):
        place[p] = -1
    for p in range(length):
        place[order[p]] = p
    out = np.zeros(length, np.bool_)
    seed = order[rng.integers(0, length)]
    if length < targets and rng.random() < 0.5:
        seed = order[rng.integers(length, targets)]
    mark_strings(near, place, seed, length, rng, out)
    return take_out(order, out, length)


@kernel
def _recreate(rules, connections, around, course, length, workspace, rng):
    """Reinsert missing targets as far as they fit; returns the number of visits, or −1."""
    rules, connections, around = borrowed(rules), borrowed(connections), borrowed(around)
    course, workspace = borrowed(course), borrowed(workspace)
    order, far, absent, reach = course.order, around.far, around.absent, around.reach
    before, room = workspace.before, workspace.room
    missing = order.size - length
    keys = np.empty(missing)
    way = rng.random()
    for m in range(missing):
        j = order[length + m]
        keys[m] = rng.random()
        if way < BY_ABSENCE:
            keys[m] -= absent[j]
        elif way < BY_REMOTENESS:
            keys[m] = -far[j] * (0.8 + 0.4 * keys[m])
        elif way < BY_PRIZE:
            keys[m] = -rules.prize[j] * (0.5 + keys[m])
    ranks = rising(keys, missing)
    turns = np.empty(missing, np.int64)
    for m in range(missing):
        turns[m] = order[length + ranks[m]]
    bit_orders.find_room(rules, course, length, workspace)
    for j in turns:
        if length == rules.limits.targets:
            break
        if not bit_orders.has_room(reach, before, room, order, length, j):
            continue
        position = bit_orders.best_position(
            rules, connections, reach, course, length, j, workspace, rng
        )
        if position < 0:
            continue
        source = length
        while order[source] != j:
            source += 1
        bit_orders.insert(order, source, position)
        length += 1
        if not (
            bit_orders.time_back(
                rules, connections, course, length, position, position - 1, workspace
            )
            and bit_orders.time_forth(
                rules, connections, course, length, position, position + 1, workspace
            )
        ):
            # Of points of about one ΔV the one that would have done was left out.
            return -1
        bit_orders.find_room(rules, course, length, workspace)
    return length


@kernel
def anneal(rules, connections, around, order, length, schedule, rng, halt):
    """Improve an order.

    Parameters
    ----------
    rules : Rules
    connections : ConnectionTable
    around : Surroundings
    order : (targets,) int64
        All targets: those visited in order, as far as they can be timed, then the others. Left as
        the last order accepted.
    length : int
        How many are visited.
    schedule : AnnealingSchedule
    rng : numpy.random.Generator
    halt : (1,) bool
        Once another thread sets it, the annealing ends.

    Returns
    -------
    best : (moves,) int64
        Bodies in the order of the best plan: most prize, then the earliest end.
    length : int
        Of the last order accepted.
    """
    rules, connections, around = borrowed(rules), borrowed(connections), borrowed(around)
    absent, worth = around.absent, schedule.worth
    bodies = rules.service.size
    workspace = fronts.new_workspace(connections)
    here, there = bit_orders.new_course(order, bodies), bit_orders.new_course(order, bodies)
    for course in (here, there):
        start, came = rules.start, course.came
        came.size[start], came.time[start, 0], came.tank[start, 0] = 1, rules.ready, rules.budget
    while not (
        bit_orders.time_back(rules, connections, here, length, length - 1, -1, workspace)
        and bit_orders.time_forth(rules, connections, here, length, 0, length, workspace)
    ):
        # A schedule over all connections may get farther than this table does.
        length -= 1
    bit_orders.copy_course(here, there, bodies)
    prize = bit_orders.prize_of(rules, here, length)
    value = prize + worth * bit_orders.spare(here, length)
    best, best_value = bit_orders.with_refuelling(rules, here, length), value
    best_prize = prize
    for iteration in range(schedule.iterations):
        if halt[0]:
            break
        allowed = temperature(schedule, iteration)
        size, first, last = length, 0, 0
        if length > 0:
            size, first, last = ruin(there.order, length, around.near, rng)
        possible = bit_orders.time_back(
            rules, connections, there, size, min(last, size) - 1, first - 1, workspace
        ) and bit_orders.time_forth(rules, connections, there, size, 0, max(last, 1), workspace)
        new_value = -np.inf
        if possible:
            size = _recreate(rules, connections, around, there, size, workspace, rng)
            possible = size >= 0
        if possible:
            prize = bit_orders.prize_of(rules, there, size)
            new_value = prize + worth * bit_orders.spare(there, size)
        if possible and new_value >= value + allowed * math.log(1.0 - rng.random()):
            length, value = size, new_value
            bit_orders.copy_course(there, here, bodies)
            if prize > best_prize or (prize == best_prize and value > best_value):
                best, best_prize = bit_orders.with_refuelling(rules, here, length), prize
                best_value = value
        else:
            bit_orders.copy_course(here, there, bodies)
        for p in range(order.size):
            j = here.order[p]
            absent[j] = PATIENCE * absent[j] + (1.0 - PATIENCE if p >= length else 0.0)
    write(order, here.order)
    return best, length


@kernel
def _nearness(rules, connections, time_value):
    """Least cost of each pair's connections in either direction, time at its value [m/s]."""
    bodies = rules.service.size
    apart = np.full((bodies, bodies), np.inf)
    for i in range(bodies):
        for j in range(bodies):
            begin = connections.first[i, j]
            for c in range(begin, begin + connections.total[i, j]):
                cost = connections.delta_v[c] + time_value * (
                    connections.end[c] - connections.departure[c]
                )
                apart[i, j] = min(apart[i, j], cost)
                apart[j, i] = min(apart[j, i], cost)
        apart[i, i] = 0.0
    return apart


class Strings:
    """Annealing of orders of one mission, resumable.

    Parameters
    ----------
    mission : Mission
        One whose connections are kept: nodes drift.
    seed : int
    stop : Stop

    Raises
    ------
    TimeIsOver
        There is no time, or no memory, for its tables.
    """

    def __init__(self, mission: Mission, seed: int, stop: Stop) -> None:
        self._mission, self._stop = mission, stop
        self._rng = np.random.default_rng(seed)
        self._lines = table_of(mission, stop)
        rules = mission.rules
        value = TIME_VALUE_M_S_PER_H * mission.instance.hurry / HOUR_S
        first = rules.first_target
        apart = _nearness(rules, self._lines, value)[:, first:]
        near = np.sort(apart, axis=1)[:, 1 : 1 + NEIGHBOURS]
        far = near.mean(axis=1) if near.size else np.zeros(len(near))  # one target has no others
        far[~np.isfinite(far)] = 0.0
        self._around = Surroundings(
            np.argsort(apart, axis=1, kind="stable") + first,
            far,
            reach_of(self._lines, rules.stations, rules.duration, stop),
            np.zeros(rules.service.size),
        )
        self._order = np.arange(first, rules.service.size, dtype=np.int64)
        self._length = self._annealed = 0
        self._is_varied = is_varied(self._lines)

    def beside(self, seed: int) -> Strings:
        """An independent annealing of the same mission, which may run concurrently."""
        other = copy(self)
        other._rng = np.random.default_rng(seed)
        other._around = self._around._replace(absent=self._around.absent.copy())
        other._order = self._order.copy()
        return other

    def begin(self, sequence: Iterable[int]) -> None:
        """Set the current plan: bodies in order."""
        rules = self._mission.rules
        visited = [int(j) for j in sequence if j >= rules.first_target]
        others = sorted(set(range(rules.first_target, rules.service.size)) - set(visited))
        self._order = np.array(visited + others, dtype=np.int64)
        self._length = len(visited)

    def annealings(self, count: int) -> Iterator[npt.NDArray[np.int64]]:
        """Best plans of several annealings, one after the other.

        Where every pair's connections take about the same ΔV an iteration is a tenth of the work.
        There as many iterations again make up for it, in annealings longer and longer, as the
        shortest find least where targets lie in clusters.

        Parameters
        ----------
        count : int
            Number of annealings elsewhere.
        """
        left = count * ANNEALED * (1 if self._is_varied else MANY)
        while left > 0:
            length = ANNEALED
            if not self._is_varied:
                length *= GROWTH ** min(self._annealed // AS_LONG, MOST_GROWTH)
            left -= length
            self._annealed += 1
            yield self.anneal(length)

    def anneal(self, iterations: int) -> npt.NDArray[np.int64]:
        """Anneal the order; returns the best plan found, refuelling stops included."""
        mission = self._mission
        rules, prize = mission.rules, worth_of(mission).prize
        worth = max(mission.collected(self._order[: self._length]), prize) / rules.duration
        worth *= TIME_COUNTS
        schedule = AnnealingSchedule(worth, HOT * prize, COLD * prize, iterations)
        with halted_by(self._stop) as halt:
            best, self._length = anneal(
                rules,
                self._lines,
                self._around,
                self._order,
                self._length,
                schedule,
                self._rng,
                halt,
            )
        found: npt.NDArray[np.int64] = best
        return found


def strings_of(mission: Mission, seed: int, stop: Stop, sequence: Iterable[int]) -> Strings | None:
    """The annealing of a plan: bodies in order. None without time, or memory, for its tables."""
    try:
        strings = Strings(mission, seed, stop)
    except TimeIsOver:
        return None
    strings.begin(sequence)
    return strings
