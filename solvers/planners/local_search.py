"""Local search: improves a plan by the kind of ruin and recreate suited to the mission.

Where arrivals are all that matters, that is the route engine (:mod:`..routes.route_engine`). Where
planes drift or costs are given, strings of targets are taken out of the order and put back in
(:mod:`..orders.string_removal`). Everywhere else, and in turn with strings, a beginning of the best
plan is kept and a new end is built for it by a narrow noisy beam (:mod:`..beams.varied_beams`).
"""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from adr_opt.common.clock import now_s
from adr_opt.common.options import Options, option
from adr_opt.common.progress import Progress, tell_plan
from adr_opt.common.stop import Clock, Stop
from adr_opt.mission.certified import certify
from adr_opt.mission.mission import Mission
from adr_opt.mission.problem import problem_of
from adr_opt.mission.result import Result

from ..beams.greedy_order import guarded_sequence
from ..beams.varied_beams import recreate
from ..orders.string_removal import Strings, strings_of
from ..progress.incumbent import Incumbent
from ..routes.route_engine import RouteEngine
from ..routes.ways import serves

ANNEALINGS = 4
"""Annealings of strings per iteration."""

FRUITLESS = 12
"""Number of fruitless annealings after which another order is annealed."""


@dataclass(frozen=True)
class LocalSearchOptions(Options, method="local-search"):
    """Options of the planner ``local-search``."""

    width: int = option(
        100, "Width of the beams that complete a ruined plan.", least=1, most=1_000_000
    )
    recreations: int = option(10, "Ruin-and-recreate steps per iteration.", least=1)


class LocalSearch:
    """A plan under improvement.

    Parameters
    ----------
    mission : Mission
    sequence : sequence of int
        The plan to begin with: bodies in order.
    seed : int
    stop : Stop
        Its time alone counts here.
    options : LocalSearchOptions

    Attributes
    ----------
    best : Incumbent
    """

    def __init__(
        self,
        mission: Mission,
        sequence: Iterable[int],
        seed: int,
        stop: Stop,
        options: LocalSearchOptions,
    ) -> None:
        self._mission, self._stop, self._options = mission, stop, options
        self._rng = np.random.default_rng(seed)
        self.best = Incumbent(mission)
        self.best.offer(sequence)
        self._fruitless = 0

    @cached_property
    def _engine(self) -> RouteEngine | None:
        problem = problem_of(self._mission)
        return RouteEngine(problem, self._draw(), self._stop) if serves(problem) else None

    @cached_property
    def _strings(self) -> Strings | None:
        if not self._mission.instance.transfer.may_drift:
            return None
        return strings_of(self._mission, self._draw(), self._stop, self.best.sequence or ())

    def _draw(self) -> int:
        return int(self._rng.integers(2**31))

    def iterate(self) -> None:
        """One iteration."""
        best, strings = self.best, None
        if self._engine is not None:
            self._engine.begin(best.routes or ((),))
            best.offer(*self._engine.advance())
            return
        if self._strings is not None:
            strings = self._strings
            for annealed in strings.annealings(ANNEALINGS):
                self._fruitless = 0 if best.offer(annealed) else self._fruitless + 1
                if self._stop.remaining_s() <= 0.0:
                    return
        for _ in range(self._options.recreations):
            if self._stop.remaining_s() <= 0.0:
                return
            sequence, width = best.sequence or (), self._options.width
            found = recreate(self._mission, sequence, width, self._rng, self._stop)
            is_better = best.offer(found)
            if strings is not None and (is_better or self._fruitless >= FRUITLESS):
                strings.begin(found)
                self._fruitless = 0


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

    Runs until ``stop``, which is asked after every iteration, says so, or all prizes are collected.

    Parameters
    ----------
    start : sequence of int, optional
        The plan to improve: bodies in order.
    """
    began = now_s()
    if start is None:
        start = guarded_sequence(mission)
    possible = mission.instance.mission.duration_s > 0.0 and mission.total_worth > 0.0
    search = LocalSearch(mission, start, seed, Clock(stop), options)
    best, iterations, improved = search.best, 0, 0
    tell_plan(progress, best.objective, best.sequence or ())
    while possible and best.objective < mission.total_worth and not stop(best.objective, math.inf):
        before = best.objective
        search.iterate()
        iterations += 1
        if best.objective > before:
            improved += 1
            tell_plan(progress, best.objective, best.sequence or ())
    return certify(
        mission,
        "local-search",
        best.sequence or (),
        seed=seed,
        runtime_s=now_s() - began,
        counters={"iterations": iterations, "improved": improved},
    )
