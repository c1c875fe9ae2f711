"""The planner ``local-search``."""

from __future__ import annotations

import math
import time
from collections.abc import Iterable

import numpy as np

from adr_opt.errors import InputError
from adr_opt.kernels.constants import STATION
from adr_opt.mission import Mission
from adr_opt.planner import Progress, at_most, get, silent
from adr_opt.result import Result, certify
from adr_opt.stop import MaxIterations, Stop

from ..orders import make_labels
from ..recreate import mean_prize, recreate
from .annealing import anneal
from .moves import NAMES

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
        targets = len(mission.instance.targets)
        self._labels = make_labels(targets, mission.rules.budget)
        self._kept = make_labels(targets, mission.rules.budget)
        weights = np.array([WEIGHTS[name] for name in NAMES])
        self._weights = np.cumsum(weights) / weights.sum()
        self.prize = 0.0
        self.sequence: tuple[int, ...] = ()
        self._delta_v = math.inf
        self.offer(sequence)
        self._mean = mean_prize(mission)

    def offer(self, sequence: Iterable[int]) -> bool:
        """Take a plan if it is better: more prize, or as much for less ΔV."""
        moves = tuple(int(j) for j in sequence)
        timing = self._mission.time(moves)
        if timing.made < len(moves):
            return False
        better = timing.objective > self.prize or (
            timing.objective == self.prize and timing.delta_v < self._delta_v
        )
        if better:
            self.prize, self._delta_v, self.sequence = timing.objective, timing.delta_v, moves
        return better

    def anneal(self, iterations: int, hot: float, cold: float) -> bool:
        """Anneal the best plan; whether it got better."""
        visited = [j for j in self.sequence if j != STATION]
        others = sorted(set(range(1, len(self._mission.names))) - set(visited))
        order = np.array(visited + others, dtype=np.int64)
        rules = self._mission.rules
        worth = max(self.prize, self._mean) / rules.duration
        best, _, _, _ = anneal(
            rules, order, len(visited), self._labels, self._kept, worth, self._weights,
            hot * self._mean, cold * self._mean, iterations, self._rng,
        )  # fmt: skip
        return self.offer(best)

    def recreate(self, width: int, stop: Stop) -> bool:
        """Keep a random beginning of the best plan and build a new end; whether it got better."""
        return self.offer(recreate(self._mission, self.sequence, width, self._rng, stop))


@at_most(chunk=10_000_000, width=1_000_000)
def local_search(
    mission: Mission,
    *,
    seed: int,
    stop: Stop,
    progress: Progress,
    start: Iterable[int] | None = None,
    chunk: int = 20_000,
    hot: float = 0.3,
    cold: float = 0.01,
    width: int = 100,
    recreations: int = 4,
) -> Result:
    """Improve a plan, by default the guarded greedy one.

    An iteration, after which ``stop`` is asked, is one annealing from the best plan and some
    ruin-and-recreate steps. Runs until ``stop`` says so, or all prizes are collected. Best as a
    finisher: a beam search finds better plans from nothing.

    Parameters
    ----------
    start : sequence of int, optional
        The plan to improve: bodies in order.
    chunk : int
        Moves tried in one annealing.
    hot, cold : float
        Its temperatures at the beginning and the end [mean prizes].
    width : int
        Width of the beams that recreate.
    recreations : int
        Ruin-and-recreate steps in one iteration.

    Raises
    ------
    InputError
        An option is out of range.
    """
    for name, value in (("chunk", chunk), ("width", width)):
        if value < 1:
            raise InputError(f"option {name} = {value} of method 'local-search': must be ≥ 1")
    if recreations < 0:
        raise InputError(
            f"option recreations = {recreations} of method 'local-search': must be ≥ 0"
        )
    if not 0.0 < cold <= hot < math.inf:
        raise InputError(
            f"options hot = {hot!r} and cold = {cold!r} of method 'local-search': "
            "must be 0 < cold ≤ hot"
        )
    began = time.perf_counter()
    if start is None:
        greedy = get("greedy-guarded")
        start = greedy(mission, seed=seed, stop=MaxIterations(1), progress=silent).sequence or ()
    search = LocalSearch(mission, start, seed)
    progress(search.prize, math.inf)
    iterations = improved = 0
    possible = mission.instance.mission.duration_s > 0.0 and mission.total_prize > 0.0
    while possible and search.prize < mission.total_prize and not stop(search.prize, math.inf):
        before = search.prize
        improved += search.anneal(chunk, hot, cold)
        for _ in range(recreations):
            if stop.remaining_s() <= 0.0:
                break
            improved += search.recreate(width, stop)
        iterations += 1
        if search.prize > before:
            progress(search.prize, math.inf)
    return certify(
        mission,
        "local-search",
        search.sequence,
        seed=seed,
        runtime_s=time.perf_counter() - began,
        counters={"iterations": iterations, "improved": improved},
    )
