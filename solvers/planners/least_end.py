"""Planning the earliest end of all targets, over given connections.

Few targets are put in order over all their sets, which is a proof. Of more, two orders are annealed
beside each other (:mod:`solvers.orders.earliest_search`) in rounds, each longer than the one
before: the best one, and one from nothing, as what an annealing ends at depends on where it begins.
"""

from __future__ import annotations

import math
from collections.abc import Iterable
from concurrent.futures import ThreadPoolExecutor
from functools import partial

import numpy as np
import numpy.typing as npt

from adr_opt.common.progress import Progress
from adr_opt.common.stop import Stop
from adr_opt.mission.problem import Problem
from adr_opt.mission.result import Result

from ..orders.all_orders import MOST_TARGETS, earliest_of_all
from ..orders.earliest_search import Cooling, search
from ..orders.quickest_legs import quickest_legs_of, shortest
from ..progress.gap import GapTracker
from ..progress.halting import halted_by
from ..proof.proof import ProofOptions

CHAINS = 2
"""Orders that are annealed beside each other: the best one, and one from nothing."""

ITERATIONS = 200_000
"""Of the first round, by chain, divided by the number of targets."""

LONGER = 1.6
"""Factor from round to round."""

HOT, COLD = 1.0, 0.02
"""First and last temperature of a round, in mean times between targets."""

HEATS = 1.0, 0.3, 3.0
"""First temperatures of the best order, round by round."""

SPARE = 0.2
"""What a second of mean slack is worth, in seconds of the end."""

Order = npt.NDArray[np.int64]


class _Chain:
    """One order under annealing.

    Parameters
    ----------
    problem : Problem
    legs, near
        As :func:`.earliest_search.search` takes them.
    seed : int
    """

    def __init__(self, problem: Problem, legs: object, near: Order, seed: int) -> None:
        rules = problem.missions[0].rules
        self._rules, self._legs, self._near = rules, legs, near
        self._rng = np.random.default_rng(seed)
        self._missed = np.zeros(rules.service.size)
        self._order = np.arange(rules.first_target, rules.service.size)
        self._length = 0
        self.best: Order = np.empty(0, dtype=np.int64)
        self.end = self.about = math.inf
        self.hot = HOT

    def begin(self, order: Iterable[int]) -> None:
        """Go on from an order of some targets."""
        targets = range(self._rules.first_target, self._rules.service.size)
        visited = [int(j) for j in order if j in targets]
        self._order = np.array([*visited, *sorted(set(targets) - set(visited))], dtype=np.int64)
        self._length = len(visited)

    def anneal(self, iterations: int, stop: Stop) -> None:
        """Anneal the order from hot to cold."""
        latest = float(self._rules.duration)
        end = min(self.end, self.about, latest)
        pace = max(end - self._rules.ready, 1.0) / max(self._order.size, 1)
        annealing = Cooling(self.hot * pace, COLD * pace, iterations, latest, SPARE)
        with halted_by(stop) as halt:
            best, end, self._length = search(
                self._legs,
                self._rules.start,
                self._rules.ready,
                self._order,
                self._length,
                self._near,
                self._missed,
                annealing,
                self._rng,
                halt,
            )
        self._keep(best, float(end))

    def take_over(self, other: _Chain) -> None:
        """Go on from the better order of both chains."""
        self._keep(other.best, other.end)
        self.begin(self.best)

    def _keep(self, order: Order, end: float) -> None:
        if order.size > self.best.size or (order.size == self.best.size and end < self.end):
            self.best, self.end = order, end


def plan(
    method: str,
    problem: Problem,
    *,
    seed: int,
    stop: Stop,
    progress: Progress,
    start: Iterable[Iterable[int]] | None,
    options: ProofOptions,
) -> Result:
    """The order of all targets that ends earliest.

    Parameters
    ----------
    method : str
        What the result is said to be of.
    problem : Problem
        One that :attr:`~.Problem.asks_for_least_end`.
    seed, stop, progress, start, options
        As planners take them.
    """
    certificate = GapTracker(problem, progress)
    if start is not None:
        certificate.offer(*start)
    mission = problem.missions[0]
    rules, legs = mission.rules, quickest_legs_of(mission)
    targets = rules.service.size - rules.first_target
    counters = {"rounds": 0.0, "iterations": 0.0}
    if targets <= MOST_TARGETS:
        order, end = earliest_of_all(
            legs, rules.start, rules.ready, rules.first_target, rules.duration
        )
        if order.size:
            certificate.offer(order)
        else:
            certificate.lower(-math.inf)
        cost_bound = float(end) if order.size else None
        return certificate.result(method, seed=seed, counters=counters, cost_bound=cost_bound)
    apart = shortest(legs)
    apart = np.minimum(apart, apart.T)
    np.fill_diagonal(apart, 0.0)
    near = np.argsort(apart[:, rules.first_target :], axis=1, kind="stable") + rules.first_target
    rng = np.random.default_rng(seed)
    best = _Chain(problem, legs, near, int(rng.integers(2**31)))
    best.begin(certificate.sequence or ())
    iterations = max(ITERATIONS // targets, 1)

    def is_over() -> bool:
        return stop.remaining_s() <= 0.0 or stop(certificate.incumbent, certificate.bound)

    with ThreadPoolExecutor(min(options.cores, CHAINS)) as threads:
        while not is_over():
            fresh = _Chain(problem, legs, near, int(rng.integers(2**31)))
            fresh.about, best.hot = best.end, HEATS[int(counters["rounds"]) % len(HEATS)]
            chains = best, fresh
            list(threads.map(partial(_Chain.anneal, iterations=iterations, stop=stop), chains))
            best.take_over(fresh)
            if best.best.size == targets:
                certificate.offer(best.best)
            counters["rounds"] += 1.0
            counters["iterations"] += float(CHAINS * iterations)
            iterations = int(LONGER * iterations)
    return certificate.result(method, seed=seed, counters=counters, upper_bound=certificate.stated)
