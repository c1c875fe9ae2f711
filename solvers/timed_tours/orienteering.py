"""Routes of most worth and least cost, by sets of targets: where not all can be done, or ΔV counts.

Of all ways to have done a set of targets and to be at a body those are kept that are not dominated:
that are there no later, have no less left of the tank and have cost no more.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from adr_opt.common.constants import SLACK_S
from adr_opt.kernels.core.compile import inlined, kernel
from adr_opt.kernels.core.events import earliest_taken
from adr_opt.kernels.core.windows import Windows, last_begin, service_end
from adr_opt.kernels.legs.given import leg_of
from adr_opt.mission.mission import Mission

from .hashing import slot_of

FloatArray = npt.NDArray[np.float64]
Whole = npt.NDArray[np.int64]

MOST_TARGETS = 57
"""Maximum number of targets: their set and a body fill an integer."""

CHUNK = 20_000
"""Number of labels extended between looks at the clock."""

ROUNDING = 1e-9
"""Relative difference of worths that rounding may cause."""


class LegRows(NamedTuple):
    """Legs of all pairs of bodies, by origin · bodies + destination.

    Attributes
    ----------
    first : (pairs + 1,) int64
        First breakpoint, or connection, of each pair.
    departure, arrival, cost : (rows,) float64
        [s], [s], [m/s].
    is_function : (pairs,) bool
        Whether rows are breakpoints of a function.
    """

    first: Whole
    departure: FloatArray
    arrival: FloatArray
    cost: FloatArray
    is_function: npt.NDArray[np.bool_]


class RouteTerms(NamedTuple):
    """Rules of the mission, as of :class:`adr_opt.kernels.rules.rules.Rules`.

    Attributes
    ----------
    first_target, stations, start, most_targets : int
    windows : Windows
    service, worth : (bodies,) float64
    may_end : (bodies,) bool
    budget, ready, duration : float
    price : float
        Of time [m/s per s].
    by_time : bool
        Whether the cost is the end.
    """

    first_target: int
    stations: int
    start: int
    most_targets: int
    windows: Windows
    service: FloatArray
    worth: FloatArray
    may_end: npt.NDArray[np.bool_]
    budget: float
    ready: float
    duration: float
    price: float
    by_time: bool


class RouteQuestion(NamedTuple):
    """What is asked.

    Attributes
    ----------
    terms : RouteTerms
    latest : (bodies, bodies) float64
        Latest times at a body from which another one can be reached [s].
    best : (3,) float64
        Worth, cost and label of the best route; updated.
    """

    terms: RouteTerms
    latest: FloatArray
    best: FloatArray


class Extension(NamedTuple):
    """A leg and the service after it: label before, destination, and what they lead to.

    Attributes
    ----------
    label, body : int
    time, left, cost : float
        As of a label.
    """

    label: int
    body: int
    time: float
    left: float
    cost: float


class Routes(NamedTuple):
    """Labels: beginnings of routes.

    Attributes
    ----------
    done : (room,) int64
        Bit j says that target j is done.
    body, parent, following : (room,) int32
        ``following`` is the next label with the same set and body, −1 for none.
    is_open : (room,) bool
        Whether it goes on.
    time, left, cost, worth : (room,) float64
        Since when the chaser is free [s], ΔV left [m/s], ΔV of all legs [m/s], and worth.
    """

    done: Whole
    body: npt.NDArray[np.int32]
    parent: npt.NDArray[np.int32]
    following: npt.NDArray[np.int32]
    is_open: npt.NDArray[np.bool_]
    time: FloatArray
    left: FloatArray
    cost: FloatArray
    worth: FloatArray


@inlined
def _is_dominated(routes, label, time, left, cost):
    """Whether a label of a chain is there no later, has no less left and has cost no more."""
    while label >= 0:
        if routes.time[label] <= time and routes.left[label] >= left and routes.cost[label] <= cost:
            return True
        label = routes.following[label]
    return False


@inlined
def _cost(terms, time, cost):
    """What a route costs that ends here."""
    return time if terms.by_time else cost + terms.price * (time - terms.ready)


@inlined
def _may_be_better(question, extension, done, worth):
    """Whether a route can still become better than the best one."""
    terms, latest, best = question
    most, body, time = worth, extension.body, extension.time
    for j in range(terms.first_target, terms.service.size):
        if not done >> (j - terms.first_target) & 1 and time <= latest[body, j]:
            most += terms.worth[j]
    slack = ROUNDING * (1.0 + abs(best[0]))
    if most < best[0] - slack:
        return False
    return most > best[0] + slack or _cost(terms, time, extension.cost) < best[1]


@kernel
def _put(question, routes, table, count, extension):
    """Enter a label unless it is dominated or no use; returns the number of labels."""
    terms, (label, j, end, left, cost) = question.terms, extension
    done, worth = routes.done[label], routes.worth[label]
    if j >= terms.first_target:
        done |= np.int64(1) << (j - terms.first_target)
        worth += terms.worth[j]
    if not _may_be_better(question, extension, done, worth):
        return count
    slot = slot_of(table, routes.done, routes.body, done, j)
    if _is_dominated(routes, np.int64(table[slot]), end, left, cost):
        return count
    routes.done[count], routes.body[count], routes.parent[count] = done, j, label
    routes.time[count], routes.left[count], routes.cost[count] = end, left, cost
    routes.worth[count], routes.following[count] = worth, table[slot]
    routes.is_open[count] = True
    table[slot] = count
    _count_in(terms, question.best, routes, count)
    return count + 1


@inlined
def _count_in(terms, best, routes, label):
    """Make a label the best route, if it is."""
    if not terms.may_end[routes.body[label]]:
        return
    worth, slack = routes.worth[label], ROUNDING * (1.0 + abs(best[0]))
    cost = _cost(terms, routes.time[label], routes.cost[label])
    if worth > best[0] + slack or (worth > best[0] - slack and cost < best[1]):
        best[0], best[1], best[2] = worth, cost, label


@kernel
def grow(legs, question, routes, table, cursor):
    """Extend labels by all their legs, as long as there is room.

    Parameters
    ----------
    legs : LegRows
    question : RouteQuestion
    routes : Routes
    table : (2^n,) int32
        First labels by set and body, −1 for none.
    cursor : (3,) int64
        First label that is not extended, the one after the last, and the number of labels; the
        first and the last are updated.
    """
    # Labels of a layer are all routes of so many legs that no other dominates. One is extended by
    # all legs or by none: ``cursor`` stands at one whose legs are all still to come, so the search
    # goes on where it stopped once there is more room.
    terms = question.terms
    bodies, count, label = terms.service.size, cursor[2], cursor[0]
    while label < cursor[1]:
        if not routes.is_open[label]:
            label += 1
            continue
        i, time = np.int64(routes.body[label]), routes.time[label]
        left, done = routes.left[label], routes.done[label]
        if count + legs.first[(i + 1) * bodies] - legs.first[i * bodies] > routes.done.size:
            break
        serviced = 0
        for j in range(bodies - terms.first_target):
            serviced += done >> j & 1
        for j in range(bodies):
            pair = i * bodies + j
            begin, end = legs.first[pair], legs.first[pair + 1]
            refuels = j < terms.stations
            if i == j or begin == end:
                continue
            if refuels:
                if i < terms.first_target:
                    continue
            elif (
                j < terms.first_target
                or done >> (j - terms.first_target) & 1
                or serviced == terms.most_targets
            ):
                continue
            is_function, earliest = legs.is_function[pair], earliest_taken(time)
            # Of a function the leg that leaves now is enough: who leaves later arrives no earlier.
            for row in range(begin, begin + 1 if is_function else end):
                cost, leaves, lands = legs.cost[row], legs.departure[row], legs.arrival[row]
                if is_function:
                    leaves, lands = leg_of(legs.departure, legs.arrival, begin, end, time)
                over = service_end(terms.windows, j, lands, terms.service[j])
                if leaves < earliest or cost > left or not over <= terms.duration:
                    continue
                rest = terms.budget if refuels else left - cost
                paid = routes.cost[label] + cost
                count = _put(question, routes, table, count, Extension(label, j, over, rest, paid))
        label += 1
    cursor[0], cursor[2] = label, count


@kernel
def reenter(table, routes, count):
    """Enter all labels into a larger table, which is empty, in order."""
    for label in range(count):
        slot = slot_of(table, routes.done, routes.body, routes.done[label], routes.body[label])
        routes.following[label] = table[slot]
        table[slot] = label


class BestRoute(NamedTuple):
    """The best route found, its worth, and whether no label was left out."""

    sequence: tuple[int, ...] | None
    worth: float
    whole: bool
    labels: int


class Orienteering:
    """Search of the route of most worth and least cost, layer by layer.

    Parameters
    ----------
    mission : Mission
        Of no more than :data:`MOST_TARGETS` targets.
    over : callable
        Whether the time is over.
    """

    def __init__(self, mission: Mission, over: Callable[[], bool]) -> None:
        rules, instance = mission.rules, mission.instance
        self._over, self._bodies = over, rules.service.size
        self._terms = RouteTerms(
            rules.first_target,
            rules.stations,
            rules.start,
            rules.limits.targets,
            rules.windows,
            rules.service,
            rules.prize,
            rules.may_end,
            rules.budget,
            rules.ready,
            rules.duration,
            instance.time_m_s_per_s,
            instance.objective.cost == "duration",
        )
        self._legs = _legs_of(mission)
        self._latest = _latest_of(self._legs, self._terms)

    def search(
        self,
        room: int,
        width: int | None = None,
        known: tuple[float, float] = (-math.inf, math.inf),
    ) -> BestRoute:
        """Search all routes, or those of the most promising labels of each layer.

        Parameters
        ----------
        room : int
            Maximum number of labels.
        width : int, optional
            Number of labels of as many legs that go on: those that are worth most, earliest first.
        known : tuple of float
            Worth and cost of a known plan: a route is found only if it is better.
        """
        terms = self._terms
        most = int(np.diff(self._legs.first).sum())
        routes, table = _wider(None, 0, max(1 << 12, 2 * most))
        best, whole = np.array([*known, -1.0]), True
        question = RouteQuestion(terms, self._latest, best)
        routes.done[0], routes.body[0], routes.parent[0] = 0, terms.start, -1
        routes.following[0], routes.is_open[0] = -1, True
        routes.time[0], routes.left[0] = terms.ready, terms.budget
        routes.cost[0], routes.worth[0] = 0.0, 0.0
        reenter(table, routes, 1)
        if terms.may_end[terms.start] and known[0] < 0.0:
            best[:] = 0.0
        first, count = 0, 1
        while first < count:
            last = count
            if width is not None and last - first > width:
                whole = False
                order = np.lexsort((routes.time[first:last], -routes.worth[first:last]))
                routes.is_open[first + order[width:]] = False
            cursor = np.array([first, last, count])
            while cursor[0] < last:
                if self._over():
                    return BestRoute(_sequence(routes, best), float(best[0]), False, count)
                cursor[1] = min(int(cursor[0]) + CHUNK, last)
                grow(self._legs, question, routes, table, cursor)
                count = int(cursor[2])
                if cursor[0] < cursor[1]:
                    if routes.done.size >= room:
                        return BestRoute(_sequence(routes, best), float(best[0]), False, count)
                    routes, table = _wider(routes, count, 2 * routes.done.size)
            first = last
        return BestRoute(_sequence(routes, best), float(best[0]), whole, count)


def _wider(routes: Routes | None, count: int, room: int) -> tuple[Routes, npt.NDArray[np.int32]]:
    """Labels with more room, and their table."""
    made = Routes(
        np.empty(room, np.int64),
        np.empty(room, np.int32),
        np.empty(room, np.int32),
        np.empty(room, np.int32),
        np.empty(room, np.bool_),
        np.empty(room),
        np.empty(room),
        np.empty(room),
        np.empty(room),
    )
    table = np.full(4 << (room - 1).bit_length(), -1, dtype=np.int32)
    if routes is not None:
        for name in Routes._fields:
            getattr(made, name)[:count] = getattr(routes, name)[:count]
        reenter(table, made, count)
    return made, table


def _sequence(routes: Routes, best: FloatArray) -> tuple[int, ...] | None:
    """The bodies of the best route; None without one."""
    label, moves = int(best[2]), list[int]()
    if label < 0:
        return None
    while routes.parent[label] >= 0:
        moves.append(int(routes.body[label]))
        label = int(routes.parent[label])
    return tuple(reversed(moves))


def _legs_of(mission: Mission) -> LegRows:
    """The legs of all pairs; those of a start cost what was spent before it as well."""
    bodies, connecting = len(mission.names), mission.connecting
    first, is_function = [0], []
    columns: list[tuple[FloatArray, FloatArray, FloatArray]] = [(np.empty(0),) * 3]
    for i in range(bodies):
        for j in range(bodies):
            function = connecting.function_of(i, j)
            is_function.append(function is not None)
            if function is not None:
                cost = np.full(function.departure.size, function.cost + connecting.spent_m_s(i))
                columns.append((function.departure, function.arrival, cost))
            else:
                found = mission.schedules.connections(i, j)
                columns.append((found.departure, found.arrival, found.delta_v))
            first.append(first[-1] + columns[-1][0].size)
    departure, arrival, cost = (np.concatenate(each) for each in zip(*columns, strict=True))
    return LegRows(
        np.array(first, dtype=np.int64), departure, arrival, cost, np.array(is_function, np.bool_)
    )


@kernel
def _latest_of(legs, terms):
    """Latest times at a body from which another one can be reached by any way, or later [s].

    By legs that leave any time before: a little more than there is.
    """
    bodies = terms.service.size
    latest = np.full((bodies, bodies), -np.inf)
    for i in range(bodies):
        for j in range(bodies):
            pair = i * bodies + j
            until = last_begin(terms.windows, j) + SLACK_S
            begin, end = legs.first[pair], legs.first[pair + 1]
            for row in range(begin, end):
                # Of a function what lands too late may leave in time until just before.
                if legs.arrival[row] <= until:
                    latest[i, j] = legs.departure[row] + SLACK_S
                    if legs.is_function[pair] and row + 1 < end:
                        latest[i, j] = legs.departure[row + 1] + SLACK_S
    for by in range(bodies):
        for i in range(bodies):
            for j in range(bodies):
                # Whoever goes on from there does so later than from here.
                latest[i, j] = max(latest[i, j], min(latest[i, by], latest[by, j]))
    return latest
