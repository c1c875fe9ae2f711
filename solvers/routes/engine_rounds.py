"""Rounds of the route engine, and the first plan before a timetable exists."""

from __future__ import annotations

from concurrent.futures import ThreadPoolExecutor

import numpy as np

from adr_opt.common.progress import Progress
from adr_opt.common.stop import Clock, Stop
from adr_opt.mission.problem import Problem, Routes

from ..progress.gap import GapTracker
from ..progress.halting import ShareOfTime
from .route_engine import RouteEngine
from .ways import serves

FRUITLESS, MOST_ROUNDS = 3, 6
"""Rounds without gain after which the engine pauses for other work: at first, and at most."""

BEFORE_TABLE = 0.4
"""Largest share of the remaining time for the first plan."""


class EngineRounds:
    """Rounds of two concurrent engines: one from the best plan, one from scratch.

    What an annealing ends at depends on where it begins. Does nothing for problems that the engine
    does not serve.

    Parameters
    ----------
    problem : Problem
    certificate : GapTracker
        Told of all plans.
    seed : int
    stop : Stop
    cores : int
        Threads; they change nothing but the time.

    Attributes
    ----------
    serves : bool
    counters : dict
        Work counters.
    """

    def __init__(
        self, problem: Problem, certificate: GapTracker, seed: int, stop: Stop, cores: int
    ) -> None:
        self._certificate, self._stop, self._cores = certificate, stop, min(cores, 2)
        self._nothing: Routes = tuple(() for _ in problem.missions)
        rng = np.random.default_rng(seed)
        seeds = [int(rng.integers(2**31)) for _ in range(2)]
        self._engines: tuple[RouteEngine, ...] = ()
        self.serves = serves(problem)
        if self.serves:
            first = RouteEngine(problem, seeds[0], stop)
            self._engines = (first, first.beside(seeds[1]))
        self.counters = {"rounds": 0, "iterations": 0}

    def at_first(self) -> None:
        """The rounds before any other work: a fixed number, time permitting."""
        self.until(FRUITLESS, MOST_ROUNDS)

    def until(self, fruitless: int = 0, most: int = 0) -> None:
        """Continue until time runs out, or for some rounds without gain; 0 for no such limit."""
        certificate, stop, idle, made = self._certificate, self._stop, 0, 0
        with ThreadPoolExecutor(self._cores) as threads:
            while self._engines and not stop(certificate.incumbent, certificate.bound):
                if stop.remaining_s() <= 0.0 or (most and made == most):
                    return
                for engine, routes in zip(
                    self._engines, (certificate.routes or self._nothing, self._nothing), strict=True
                ):
                    engine.begin(routes)
                found = list(threads.map(RouteEngine.advance, self._engines))
                better = [certificate.offer(*routes) for routes in found]
                idle, made = 0 if any(better) else idle + 1, made + 1
                self.counters["rounds"] += 1
                self.counters["iterations"] = sum(each.iterations for each in self._engines)
                if fruitless and idle == fruitless:
                    return


def first_routes(problem: Problem, *, seed: int, stop: Stop, progress: Progress) -> Routes | None:
    """Routes of a problem before it has a timetable, by a fixed number of rounds.

    None where the engine does not serve it, and without a plan.
    """
    if not serves(problem):
        return None
    certificate, within = GapTracker(problem, progress), ShareOfTime(stop, BEFORE_TABLE)
    EngineRounds(problem, certificate, seed, Clock(within), 1).at_first()
    return certificate.routes
