"""Ruin and recreate across routes: some chasers are rerouted over the targets left by others."""

from __future__ import annotations

import numpy as np

from adr_opt.common.stop import Stop
from adr_opt.mission.mission import Mission
from adr_opt.mission.problem import Problem, Routes
from adr_opt.plan.station_limits import Use

from ..beams.beams import BeamSettings, beam_search, usual_settings, with_time_value
from ..beams.timely_beams import first_width
from ..beams.varied_beams import varied
from ..progress.gap import GapTracker
from .one_chaser import (
    FloatArray,
    guarded_routes,
    left,
    one_after_another,
    targets_of,
    trimmed,
    without_empty,
)
from .route_pool import Column, RoutePool, dealt

FIRST_WIDTH = 200
"""Width of the beams for first plans."""

MOST_FLOWN_ANEW = 3
"""Maximum number of routes abandoned at once."""

ADRIFT = 100
"""Number of moves without improvement before a return to the best plan."""

TOLERANCE = 0.3
"""Mean noise in the preference among routes to be completed, in mean prizes."""

WITHOUT_STATIONS = 0.3
"""Share of routes that avoid limited stations."""

LEAST_OFFER = 0.05
"""Least share of its worth that a target keeps if it is worth something to others."""


class RouteSearch:
    """Searches for plans of a campaign, and keeps all routes found.

    Parameters
    ----------
    problem : Problem
    seed : int
    stop : Stop
    certificate : GapTracker
    pool : RoutePool

    Attributes
    ----------
    multipliers : (bodies,) float64
        What one more of each target would be worth to all chasers together, as far as it is known.
        A chaser that is rerouted before others leaves them the targets that are worth much to all.
    """

    def __init__(
        self, problem: Problem, seed: int, stop: Stop, certificate: GapTracker, pool: RoutePool
    ) -> None:
        self._problem = problem
        self._rng = np.random.default_rng(seed)
        self._stop = stop
        self._certificate = certificate
        self._pool = pool
        self._kind_of = problem.kind_of
        self._routes: Routes = tuple(() for _ in problem.missions)
        self._worth = -np.inf
        self._idle = 0
        self.multipliers = np.zeros(len(problem.names))
        worthy = problem.planning_prizes[problem.planning_prizes > 0.0]
        self._mean_worth = float(worthy.mean()) if worthy.size else 1.0
        self.counters = {"beams": 0, "recreations": 0, "completions": 0, "packings": 0}

    def begin(self, start: Routes | None = None) -> None:
        """Make first plans: guarded greedy, by beams chaser by chaser, and the given one."""
        self._meet(guarded_routes(self._problem))
        self._meet(one_after_another(self._problem, self._usual))
        if start is not None:
            self._meet(start)
        self.begin_again()

    def begin_again(self) -> None:
        """Continue from the best plan, whatever its source."""
        best = self._certificate.routes
        if best is not None:
            self._meet(best)

    def _usual(self, mission: Mission) -> tuple[int, ...]:
        if self._stop.remaining_s() <= 0.0:
            return ()
        layer = with_time_value(mission)
        self.counters["beams"] += 1
        return self._beam(layer, usual_settings(layer, first_width(mission, FIRST_WIDTH)), 0)

    def _beam(self, mission: Mission, settings: BeamSettings, seed: int) -> tuple[int, ...]:
        found = beam_search(mission, settings, seed=seed, stop=self._stop)[0]
        return tuple(int(j) for j in found)

    def _meet(self, routes: Routes) -> None:
        """Set the current routes, and report them."""
        for chaser, route in enumerate(routes):
            if route:
                self._pool.add(self._kind_of[chaser], route)
        self._certificate.offer(*routes)
        self._routes = routes
        self._worth = self._problem.collected(targets_of(self._problem, routes))

    def move(self, width: int) -> None:
        """Abandon the routes of some chasers, and reroute them over the remaining targets."""
        problem, rng = self._problem, self._rng
        count = len(problem.missions)
        flown_anew = rng.permutation(count)[: int(rng.integers(1, min(count, MOST_FLOWN_ANEW) + 1))]
        routes = list(self._routes)
        for chaser in flown_anew:
            routes[chaser] = ()
        done = targets_of(problem, routes)
        uses = [self._use(chaser, route) for chaser, route in enumerate(routes)]
        for number, chaser in enumerate(flown_anew):
            worths = left(problem, done)
            considerate = float(rng.uniform())
            if number < flown_anew.size - 1:
                offered = worths - considerate * self.multipliers
                worths = np.maximum(offered, LEAST_OFFER * worths)
            found = self._fly(int(chaser), worths, uses, width)
            if found is None:
                return
            routes[chaser] = found
            uses[chaser] = self._use(int(chaser), found)
            done |= targets_of(problem, [routes[chaser]])
        self.counters["recreations"] += 1
        worth = problem.collected(done)
        if worth >= self._worth:
            self._idle = 0 if worth > self._worth else self._idle + 1
            self._routes, self._worth = tuple(routes), worth
            self._certificate.offer(*routes)
        else:
            self._idle += 1
        if self._idle >= ADRIFT:
            self.begin_again()
            self._idle = 0

    def _fly(
        self, chaser: int, worths: FloatArray, uses: list[Use], width: int
    ) -> tuple[int, ...] | None:
        """A route of a chaser by a beam with random settings; None if time is over.

        Parameters
        ----------
        chaser : int
        worths : (bodies,) float64
            Written.
        uses : list of tuple of float
            What others take of stations.
        width : int
        """
        problem, rng = self._problem, self._rng
        mission = problem.missions[chaser]
        if problem.limits:
            worths = without_empty(problem, worths, uses)
            if rng.random() < WITHOUT_STATIONS:
                worths[list(problem.limits.stations)] = -np.inf
        layer, settings, seed = varied(mission.offering(worths), width, rng)
        if self._stop.remaining_s() <= 0.0:
            return None
        route = self._beam(layer, settings, seed)
        self._pool.add(self._kind_of[chaser], route)
        return trimmed(problem, mission, route, uses)[0]

    def _use(self, chaser: int, route: tuple[int, ...]) -> Use:
        """Use of station supplies by a chaser."""
        problem, mission = self._problem, self._problem.missions[chaser]
        if not problem.limits:
            return ()
        moves = mission.closed(route)
        schedule = mission.time(moves)
        return problem.use(mission, moves[: schedule.made], schedule.delta_vs)

    def complete(self, width: int) -> None:
        """Combine disjoint known routes for all chasers but one, which is routed over the rest.

        Routes that are worth much, less multipliers, are preferred: there are no better ones left
        to find for their chasers, and the others lose little by them.
        """
        problem, rng = self._problem, self._rng
        columns = self._pool.columns()
        if not columns:
            return
        spare = [len(kind.chasers) for kind in problem.kinds]
        last = int(rng.integers(len(problem.missions)))
        spare[self._kind_of[last]] -= 1
        noise = rng.exponential(TOLERANCE * self._mean_worth, len(columns))
        losses = noise - [self._less_multipliers(column) for column in columns]
        done, taken, uses = set[int](), list[Column](), list[Use]()
        for at in np.argsort(losses, kind="stable").tolist():
            column = columns[at]
            fits = spare[column.kind] and done.isdisjoint(column.targets)
            if fits and problem.limits.allow([*uses, column.use]):
                spare[column.kind] -= 1
                uses.append(column.use)
                done |= column.targets
                taken.append(column)
                if not any(spare):
                    break
        found = self._fly(last, left(problem, done), uses, width)
        if found is None:
            return
        added = self._pool.add(self._kind_of[last], found)
        self.counters["completions"] += 1
        if added is not None:
            flown = [(column.kind, column.route) for column in (*taken, added)]
            self._certificate.offer(*dealt(problem, flown))

    def _less_multipliers(self, column: Column) -> float:
        return column.worth - column.paid(self.multipliers)

    def pack(self, time_limit_s: float) -> None:
        """The best plan of the known routes."""
        found = self._pool.best(self._pool.columns(), min(time_limit_s, self._stop.remaining_s()))
        self.counters["packings"] += 1
        if found is not None and self._certificate.offer(*found):
            self._meet(found)
