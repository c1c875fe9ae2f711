"""Local search: improves a plan by changing the order of its targets.

Two ways to change it take turns. *Annealing* swaps, replaces, relocates, reverses, inserts and
removes targets one move at a time; *ruin and recreate* keeps a beginning of the best plan and
builds a new end for it by a narrow noisy beam. Refuelling stops are not moved but solved for, see
:mod:`solvers.orders.timed_order`. Every candidate is timed exactly, from the first change on, and
given up as soon as it cannot be accepted.
"""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np

from adr_opt.common.clock import now_s
from adr_opt.common.options import Options, option
from adr_opt.common.progress import Progress, tell_plan
from adr_opt.common.stop import Stop
from adr_opt.mission.certified import certify
from adr_opt.mission.mission import Mission
from adr_opt.mission.result import Result

from ...beams.exchange_rates import worth_of
from ...beams.greedy_order import guarded_sequence
from ...beams.recreate import recreate
from ...orders.cooling import AnnealingSchedule
from ...orders.timed_order import make_labels
from ...progress.incumbent import Incumbent
from .annealing import NAMES, anneal

__all__ = ["local_search"]


WEIGHTS = {
    "swap": 0.12,
    "replace": 0.18,
    "relocate": 0.32,
    "reverse": 0.15,
    "insert": 0.07,
    "remove": 0.01,
    "substitute": 0.15,
}
"""Probabilities of the moves."""


class LocalSearch:
    """A plan under improvement.

    Parameters
    ----------
    mission : Mission
    sequence : sequence of int
        The plan to begin with: bodies in order.
    seed : int
    """

    def __init__(self, mission: Mission, sequence: Iterable[int], seed: int) -> None:
        self._mission = mission
        self._rng = np.random.default_rng(seed)
        self._labels, self._kept = make_labels(mission), make_labels(mission)
        weights = np.array([WEIGHTS[name] for name in NAMES])
        self._weights = np.cumsum(weights) / weights.sum()
        self._mean = worth_of(mission).prize
        self.best = Incumbent(mission)
        self.best.offer(sequence)

    def anneal(self, iterations: int, hot: float, cold: float) -> bool:
        """Anneal the best plan; returns whether it improved."""
        rules = self._mission.rules
        targets = range(rules.first_target, rules.service.size)
        visited = [j for j in self.best.sequence or () if not rules.is_station[j]]
        others = sorted(set(targets) - set(visited))
        order = np.array(visited + others, dtype=np.int64)
        worth = max(self.best.objective, self._mean) / rules.duration
        schedule = AnnealingSchedule(worth, hot * self._mean, cold * self._mean, iterations)
        best, _, _, _ = anneal(
            rules, order, len(visited), self._labels, self._kept, self._weights, schedule, self._rng
        )
        return self.best.offer(best)

    def recreate(self, width: int, stop: Stop) -> bool:
        """Rebuild the best plan after a random beginning; returns whether it improved."""
        sequence = self.best.sequence or ()
        return self.best.offer(recreate(self._mission, sequence, width, self._rng, stop))


@dataclass(frozen=True)
class LocalSearchOptions(Options, method="local-search"):
    """Options of the planner ``local-search``."""

    chunk: int = option(20_000, "Moves tried per annealing run.", least=1, most=10_000_000)
    hot: float = option(0.3, "Initial temperature of a run.", unit="mean prizes", above=0.0)
    cold: float = option(
        0.01, "Final temperature of a run.", unit="mean prizes", above=0.0, most="hot"
    )
    width: int = option(100, "Width of the beams used to recreate.", least=1, most=1_000_000)
    recreations: int = option(4, "Ruin-and-recreate steps per iteration.", least=0)


def local_search(
    mission: Mission,
    *,
    seed: int,
    stop: Stop,
    progress: Progress,
    start: Iterable[int] | None = None,
    options: LocalSearchOptions = LocalSearchOptions(),
) -> Result:
    """Improve a plan, by default the guarded greedy one.

    An iteration, after which ``stop`` is asked, is one annealing from the best plan and some
    ruin-and-recreate steps. Runs until ``stop`` says so, or all prizes are collected. Best as a
    finisher: a beam search finds better plans from nothing.

    Parameters
    ----------
    start : sequence of int, optional
        The plan to improve: bodies in order.
    """
    began = now_s()
    if start is None:
        start = guarded_sequence(mission)
    search = LocalSearch(mission, start, seed)
    tell_plan(progress, search.best.objective, search.best.sequence or ())
    iterations = improved = 0
    possible = mission.instance.mission.duration_s > 0.0 and mission.total_worth > 0.0
    while (
        possible
        and search.best.objective < mission.total_worth
        and not stop(search.best.objective, math.inf)
    ):
        before = search.best.objective
        improved += search.anneal(options.chunk, options.hot, options.cold)
        for _ in range(options.recreations):
            if stop.remaining_s() <= 0.0:
                break
            improved += search.recreate(options.width, stop)
        iterations += 1
        if search.best.objective > before:
            tell_plan(progress, search.best.objective, search.best.sequence or ())
    return certify(
        mission,
        "local-search",
        search.best.sequence or (),
        seed=seed,
        runtime_s=now_s() - began,
        counters={"iterations": iterations, "improved": improved},
    )
