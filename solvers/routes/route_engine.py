"""The route engine: orders of all chasers, annealed round by round; see :mod:`.ruin_recreate`.

It needs no timetable: only what :mod:`.ways` tells of given connections and functions of time.
"""

from __future__ import annotations

from collections.abc import Iterable
from copy import copy

import numpy as np
import numpy.typing as npt

from adr_opt.common.constants import SLACK_M_S
from adr_opt.common.stop import Stop
from adr_opt.mission.problem import Problem, Routes

from ..progress.halting import halted_by
from .orders import EngineTerms
from .ruin_recreate import Cooling, anneal
from .ways import ways_of

IntArray = npt.NDArray[np.int64]

EACH, WORK = 50, 50_000
"""Iterations of the first round per target, and their upper limit, which is divided by the number
of targets."""

LONGER = 1.6
"""Growth of iterations from round to round."""

MOST_WORK = 1e9
"""Maximum number of iterations in a round."""

HOT, COLD = 1.0, 0.01
"""First and last temperature while targets are missing, in mean prizes."""

HOT_COST, COLD_COST = 1.0, 0.02
"""First and last temperature once no target is missing, in mean costs of a target."""

HEATS = 1.0, 0.3, 3.0
"""Factors of the temperatures, round by round."""

TIME_COUNTS = 1.0
"""Worth of a mean slack as long as the mission, as a share of the best plan's prize."""

SPARE = 0.2
"""Worth of a second of mean slack once no target is missing, in seconds of the end."""

MOST_NEAR = 400
"""Number of nearest targets listed per target."""


class RouteEngine:
    """Routes of a problem, improved round by round.

    Parameters
    ----------
    problem : Problem
        One that :func:`.ways.serves`.
    seed : int
    stop : Stop
        Its time alone counts here.

    Attributes
    ----------
    iterations : int
        Done so far.
    """

    def __init__(self, problem: Problem, seed: int, stop: Stop) -> None:
        self._problem, self._stop = problem, stop
        self._rng = np.random.default_rng(seed)
        self._ways = ways = ways_of(problem)
        instance, first = problem.instance, problem.instance.first_target
        self._prize = prizes = np.array(problem.planning_prizes)
        self._targets = first + np.flatnonzero(prizes[first:] > 0.0)
        missions = problem.missions
        self._terms = EngineTerms(
            prizes,
            np.array(
                [
                    each.chaser.usable.delta_v_m_s - each.chaser.spent_m_s - each.reserve_m_s
                    for each in missions
                ]
            )
            + SLACK_M_S,
            np.array([min(mission.limits) for mission in missions], dtype=np.int64),
            instance.objective.cost == "duration",
            float(instance.time_m_s_per_s),
        )
        apart = ways.least.reshape(ways.bodies, ways.bodies)
        apart = np.minimum(apart, apart.T)
        np.fill_diagonal(apart, 0.0)
        near = np.argsort(apart[:, self._targets], axis=1, kind="stable")
        self._near = np.ascontiguousarray(self._targets[near[:, :MOST_NEAR]])
        known = np.sort(apart[np.ix_(self._targets, self._targets)], axis=1)[:, 1:2]
        known = known[np.isfinite(known)]
        self._pace = max(float(known.mean()) if known.size else 1.0, 1e-3)
        self._mean = float(np.mean([prizes[j] for j in self._targets])) if near.size else 1.0
        self._absent = np.zeros(len(instance.names))
        self._rounds, self.iterations = 0, 0
        self.begin(tuple(() for _ in missions))

    def beside(self, seed: int) -> RouteEngine:
        """An independent search of the same problem from scratch, which may run concurrently."""
        other = copy(self)
        other._rng, other._absent = np.random.default_rng(seed), np.zeros_like(self._absent)
        other.begin(tuple(() for _ in self._problem.missions))
        return other

    def begin(self, routes: Iterable[Iterable[int]]) -> None:
        """Set the routes to continue from."""
        bodies, wanted = self._ways.bodies, set(self._targets.tolist())
        nodes: list[int] = []
        for chaser, route in enumerate(routes):
            visited = [int(j) for j in route if j in wanted]
            nodes += [bodies + 2 * chaser, *visited, bodies + 2 * chaser + 1]
        self._length = len(nodes)
        self._nodes = np.array([*nodes, *sorted(wanted - set(nodes))], dtype=np.int64)

    def advance(self) -> Routes:
        """The best routes of the next round, which is longer than the previous one."""
        targets = max(self._targets.size, 1)
        work = LONGER**self._rounds * min(EACH * targets, WORK / targets)
        heat = HEATS[self._rounds % len(HEATS)]
        self._rounds += 1
        return self.anneal(int(min(work, MOST_WORK)) + 1, heat)

    def anneal(self, iterations: int, heat: float = 1.0) -> Routes:
        """Anneal the order from hot to cold; returns the best routes met."""
        stops = self._nodes[: self._length]
        collected = float(self._prize[stops[stops < self._ways.bodies]].sum())
        duration = float(self._ways.closes.max() - self._ways.windows.opens.min())
        with halted_by(self._stop) as halt:
            best, _, _, self._length, done = anneal(
                self._ways,
                self._terms,
                self._nodes,
                self._length,
                self._near,
                self._absent,
                Cooling(
                    iterations,
                    heat * HOT * self._mean,
                    COLD * self._mean,
                    heat * HOT_COST,
                    COLD_COST,
                    TIME_COUNTS * max(collected, self._mean) / max(duration, 1.0),
                    SPARE,
                    self._pace,
                ),
                self._rng,
                halt,
            )
        self.iterations += int(done)
        return self._routes(best)

    def _routes(self, stops: IntArray) -> Routes:
        """The routes of an order, chaser by chaser."""
        routes = list[list[int]]()
        for node in stops.tolist():
            if node < self._ways.bodies:
                routes[-1].append(node)
            elif (node - self._ways.bodies) % 2 == 0:
                routes.append([])
        return tuple(map(tuple, routes))
