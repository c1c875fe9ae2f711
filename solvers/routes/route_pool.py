"""Pool of known routes, and the best plan that combines them."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass

import numpy as np

from adr_opt.mission.problem import Problem, Routes
from adr_opt.plan.station_limits import Use

from .one_chaser import FloatArray
from .set_packing import cheapest_of, packing

LEAST_COST = 1e-3
"""Weight of all costs together in steps of prize, as a tie-breaker between equal choices."""


Stops = tuple[tuple[int, int], ...]

Key = tuple[int, frozenset[int], Stops]
"""Chaser type, targets, and refuellings at limited stations."""


@dataclass(frozen=True)
class Column:
    """A route that a chaser of a type can fly.

    Attributes
    ----------
    kind : int
    targets : frozenset of int
    worth, cost : float
        The worth by the ends of its services, where prizes fall.
    route : tuple of int
    use : tuple of float
        What it takes of stations, see :class:`adr_opt.plan.station_limits.StationLimits`.
    stops : tuple of (int, int)
        Stations that have a limit at which it refuels, by their numbers, and how often.
    """

    kind: int
    targets: frozenset[int]
    worth: float
    cost: float
    route: tuple[int, ...]
    use: Use = ()
    stops: Stops = ()

    @property
    def key(self) -> Key:
        """Identity of the column."""
        return self.kind, self.targets, self.stops

    def beats(self, worth: float, cost: float) -> bool:
        """Whether the column is worth more than one of the same key, or as much at less cost."""
        return (-self.worth, self.cost) < (-worth, cost)

    @property
    def taken(self) -> dict[int, float]:
        """Use of limited resources: targets, which are limited to one visit, and refuellings."""
        return {**dict.fromkeys(sorted(self.targets), 1.0), **dict(self.stops)}

    def paid(self, prices: FloatArray) -> float:
        """Price of the resources that the column uses, at prices of shape (bodies,)."""
        return math.fsum(prices[body] * times for body, times in self.taken.items())


def dealt(problem: Problem, flown: Iterable[tuple[int, tuple[int, ...]]]) -> Routes:
    """Routes assigned to chasers of their types; the other chasers get none."""
    routes: list[tuple[int, ...]] = [()] * len(problem.missions)
    free = [list(kind.chasers) for kind in problem.kinds]
    for kind, route in flown:
        routes[free[kind].pop(0)] = route
    return tuple(routes)


class RoutePool:
    """The best known route for each set of targets and chaser type: by worth, then by cost.

    And for each number of refuellings where stations have limits.

    Parameters
    ----------
    problem : Problem
    """

    def __init__(self, problem: Problem) -> None:
        self._problem = problem
        self._first = problem.instance.first_target
        self._columns: dict[Key, Column] = {}

    def columns(self) -> list[Column]:
        """All columns, in the order in which their sets were found."""
        return list(self._columns.values())

    def add_all(self, other: RoutePool) -> None:
        """Add the routes of another pool that are new, worth more, or cheaper."""
        for column in other.columns():
            known = self._columns.get(column.key)
            if known is None or column.beats(known.worth, known.cost):
                self._columns[column.key] = column

    def add(self, kind: int, route: Iterable[int]) -> Column | None:
        """Add a route that a chaser of a type can fly to a legal end; None if it cannot."""
        mission = self._problem.kinds[kind].mission
        moves = mission.closed(route)
        targets = frozenset(j for j in moves if j >= self._first)
        stops = tuple(
            (station, moves.count(station))
            for station in self._problem.limits.stations
            if station in moves
        )
        known = self._columns.get((kind, targets, stops))
        if known is not None and known.route == moves:
            return known
        schedule = mission.time(moves)
        if schedule.made < len(moves) or not mission.may_stop(moves):
            return None
        worth = self._problem.collected(targets)
        if self._problem.falls is not None:
            worth = self._problem.in_steps(schedule.objective)
        if known is not None and not (-worth, schedule.cost) < (-known.worth, known.cost):
            return known
        use = self._problem.use(mission, moves, schedule.delta_vs)
        if not self._problem.limits.allow([use]):
            return None
        column = Column(kind, targets, worth, schedule.cost, moves, use, stops)
        self._columns[column.key] = column
        return column

    def best(self, columns: Sequence[Column], time_limit_s: float) -> Routes | None:
        """The best plan made of some columns, by set packing with HiGHS.

        Parameters
        ----------
        columns : sequence of Column
        time_limit_s : float
            Then the best so far, if there is one.
        """
        if not columns or time_limit_s <= 0.0:
            return None
        problem = self._problem
        step = problem.prize_step or 1e-3 * max(column.worth for column in columns) or 1.0
        chasers = len(problem.missions)
        dearest = math.fsum(sorted(column.cost for column in columns)[-chasers:])
        price = LEAST_COST * step / max(dearest, 1e-9)
        gain = np.array([column.worth - price * column.cost for column in columns])
        constraint = packing(
            problem,
            [(column.kind, column.targets) for column in columns],
            [column.use for column in columns],
            all_flown=True,
        )
        found = cheapest_of(-gain, [constraint], time_limit_s)
        if found.taken is None:
            return None
        taken = [columns[at] for at in found.taken]
        return dealt(problem, [(column.kind, column.route) for column in taken])
