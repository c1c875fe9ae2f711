"""Exchange of targets between routes: removed, and reinserted where they cost least.

Ruin and recreate across the routes of a campaign with annealing on the cost that the instance
names, at no less than the best plan's worth. Targets that it leaves out may take the place of
others, or come in as well where there is room, which is most of what cheaper routes are good for.
Each route is timed exactly, and what it costs is remembered.
"""

from __future__ import annotations

import math
from operator import itemgetter
from typing import NamedTuple

import numpy as np

from adr_opt.common.stop import Stop
from adr_opt.common.tolerance import COST_RELATIVE
from adr_opt.mission.problem import Problem, Routes
from adr_opt.plan.station_limits import Use

from ..progress.gap import GapTracker
from .one_chaser import targets_of
from .route_pool import RoutePool

HOT, COLD = 0.01, 0.0003
"""First and last temperature, as shares of the best plan's cost."""

MOST_OUT = 4
"""Maximum number of targets removed at once, except whole routes."""

SPARES = 2
"""Maximum number of unvisited targets that may be inserted at once."""

BLINKS = 0.1
"""Share of positions that are skipped."""

BY_LOT, STRING = 0.45, 0.9
"""Cumulative shares of removals of random targets and of strings; the rest are whole routes."""

WITH_SPARES = 0.5
"""Share of moves in which unvisited targets may be inserted."""

ONE_MORE = 0.5
"""Share of moves that insert all insertable targets, even beyond the best plan's number."""

WITH_STATIONS = 0.2
"""Share of moves that insert targets with a station stop before or after them."""

CHOSEN = 0.3
"""Share of insertions of the cheapest target rather than a random one."""

SUM_BESIDE = 1e-3
"""Weight of other routes if only the most expensive one counts."""

MOST_REMEMBERED = 500_000
"""Maximum number of cached routes."""


class _Timed(NamedTuple):
    """A route with its legal end, its cost and its use of stations; +inf if it cannot be flown."""

    moves: tuple[int, ...]
    cost: float
    use: Use


class _Place(NamedTuple):
    """An insertion: increase of total cost, and the resulting route."""

    grows: float
    chaser: int
    body: int
    route: tuple[int, ...]


class Exchanges:
    """Searches for plans of more worth, or of equal worth at less cost.

    Parameters
    ----------
    problem : Problem
    seed : int
    certificate : GapTracker
        Has the plan to begin from; told of better ones.
    pool : RoutePool
        Routes of better plans are added to it.
    """

    def __init__(
        self, problem: Problem, seed: int, certificate: GapTracker, pool: RoutePool
    ) -> None:
        self._problem, self._certificate, self._pool = problem, certificate, pool
        self._rng = np.random.default_rng(seed)
        self._first = problem.instance.first_target
        self._kind_of = problem.kind_of
        self._stations = len(problem.instance.stations)
        self._timed: dict[tuple[int, tuple[int, ...]], _Timed] = {}
        self._worthy = [j for j, worth in enumerate(problem.planning_prizes) if worth > 0.0]
        self.counters = {"exchanges": 0}

    def anneal(self, iterations: int, stop: Stop) -> bool:
        """One cooling from the best plan; returns whether a better one was found.

        Parameters
        ----------
        iterations : int
        stop : Stop
            Its time alone counts here.
        """
        if self._certificate.routes is None:
            return False
        wanted = self._certificate.incumbent
        now = tuple(self._open(route) for route in self._certificate.routes)
        best = present = self._total(now)
        scale, found_any = abs(self._certificate.cost), False
        for made in range(iterations):
            if stop.remaining_s() <= 0.0:
                break
            heat = scale * HOT * (COLD / HOT) ** (made / iterations)
            self.counters["exchanges"] += 1
            trial = self._exchanged(now, wanted)
            if trial is None:
                continue
            found = self._total(trial)
            worth = self._problem.collected(targets_of(self._problem, trial))
            if worth > wanted + self._problem.prize_resolution and found < math.inf:
                wanted, now, present, best = worth, trial, found, found
                found_any = self._offer(trial) or found_any
            elif found < present - heat * math.log(1.0 - self._rng.random()):
                now, present = trial, found
                if found < best - COST_RELATIVE * abs(best):
                    best = found
                    found_any = self._offer(trial) or found_any
        return found_any

    def _offer(self, routes: Routes) -> bool:
        """Report a better plan."""
        timed = [self._time(chaser, route) for chaser, route in enumerate(routes)]
        for chaser, route in enumerate(timed):
            if route.moves:
                self._pool.add(self._kind_of[chaser], route.moves)
        return self._certificate.offer(*(route.moves for route in timed))

    def _total(self, routes: Routes) -> float:
        """Total cost of routes; +inf if stations' supplies are exceeded."""
        timed = [self._time(chaser, route) for chaser, route in enumerate(routes)]
        costs = [route.cost for route in timed]
        if math.inf in costs or not self._problem.limits.allow([route.use for route in timed]):
            return math.inf
        objective = self._problem.instance.objective
        if objective.cost == "duration":
            return objective.together(costs) + SUM_BESIDE * math.fsum(costs)
        return objective.together(costs)

    def _open(self, route: tuple[int, ...]) -> tuple[int, ...]:
        """A route without unearned stops and those at its end, which are added again later."""
        moves: list[int] = []
        earned = False
        for body in route:
            if body >= self._first or earned:
                moves.append(body)
            earned = body >= self._first
        while moves and moves[-1] < self._first:
            moves.pop()
        return tuple(moves)

    def _time(self, chaser: int, route: tuple[int, ...]) -> _Timed:
        """A timed route of a chaser, cached."""
        key = self._kind_of[chaser], route
        known = self._timed.get(key)
        if known is not None:
            return known
        mission = self._problem.missions[chaser]
        moves = mission.closed(route)
        schedule = mission.time(moves)
        timed = _Timed(moves, math.inf, self._problem.limits.nothing)
        if schedule.made == len(moves) and mission.may_stop(moves):
            use = self._problem.use(mission, moves, schedule.delta_vs)
            timed = _Timed(moves, schedule.cost, use)
        if len(self._timed) >= MOST_REMEMBERED:
            self._timed.clear()
        self._timed[key] = timed
        return timed

    def _exchanged(self, now: Routes, wanted: float) -> Routes | None:
        """Routes after an exchange of targets; None if they are worth less."""
        rng, worths = self._rng, self._problem.planning_prizes
        out = self._drawn(now)
        routes = [self._open(tuple(j for j in route if j not in out)) for route in now]
        bag = sorted(out)
        if rng.random() < WITH_SPARES:
            visited = targets_of(self._problem, now)
            spares = [j for j in self._worthy if j not in visited]
            bag += [spares[at] for at in rng.permutation(len(spares))[:SPARES]]
        bag = [bag[at] for at in rng.permutation(len(bag))]
        with_stations, more = rng.random() < WITH_STATIONS, rng.random() < ONE_MORE
        have = self._problem.collected(targets_of(self._problem, routes))
        costs = [self._time(chaser, route).cost for chaser, route in enumerate(routes)]
        wanted -= self._problem.prize_resolution
        while bag and (more or have < wanted):
            drawn = bag if rng.random() < CHOSEN else bag[:1]
            place = self._place(routes, costs, drawn, with_stations)
            if place is None:
                bag = [] if drawn is bag else bag[1:]
                continue
            routes[place.chaser] = place.route
            costs[place.chaser] = self._time(place.chaser, place.route).cost
            bag.remove(place.body)
            have += worths[place.body]
        return tuple(routes) if have >= wanted else None

    def _drawn(self, now: Routes) -> set[int]:
        """Random targets to be removed from their routes."""
        rng = self._rng
        visited = sorted(targets_of(self._problem, now))
        if not visited:
            return set()
        kind, most = rng.random(), int(rng.integers(1, MOST_OUT + 1))
        if kind < BY_LOT:
            return {visited[at] for at in rng.permutation(len(visited))[:most]}
        flown = [route for route in now if route]
        route = flown[int(rng.integers(len(flown)))]
        begin = int(rng.integers(len(route))) if kind < STRING else 0
        end = begin + most if kind < STRING else len(route)
        return {j for j in route[begin:end] if j >= self._first}

    def _place(
        self, routes: list[tuple[int, ...]], costs: list[float], bag: list[int], with_stations: bool
    ) -> _Place | None:
        """Cheapest insertion of any of some targets, apart from skipped positions."""
        best: _Place | None = None
        ways = []
        for body in bag:
            empty = set[int]()
            for chaser, route in enumerate(routes):
                if not route:
                    # Of chasers of a kind that have nothing to do, one is as good as another.
                    if self._kind_of[chaser] in empty:
                        continue
                    empty.add(self._kind_of[chaser])
                stops: list[tuple[int, ...]] = [(body,)]
                if with_stations:
                    for station in range(self._stations):
                        stops += [(station, body), (body, station)]
                for at in range(len(route) + 1):
                    if self._rng.random() < BLINKS:
                        continue
                    for stop in stops:
                        changed = self._open((*route[:at], *stop, *route[at:]))
                        least = self._least(chaser, changed) - costs[chaser]
                        ways.append(_Place(least, chaser, body, changed))
        ways.sort(key=itemgetter(0))  # by how much costs grow at least
        for way in ways:
            if best is not None and way.grows >= best.grows:
                break
            cost = self._time(way.chaser, way.route).cost
            grows = cost - costs[way.chaser]
            if cost < math.inf and (best is None or grows < best.grows):
                best = way._replace(grows=grows)
        return best

    def _least(self, chaser: int, route: tuple[int, ...]) -> float:
        """Lower bound on the cost of a route."""
        known = self._timed.get((self._kind_of[chaser], route))
        if known is not None:
            return known.cost
        return self._problem.missions[chaser].schedules.least_cost(route)
