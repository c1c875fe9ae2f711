"""The planner: a greedy plan, then one window after another."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Iterable
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from typing import Any

import numpy as np

from adr_opt.common.clock import now_s
from adr_opt.common.constants import HOUR_S
from adr_opt.common.options import MOST_JOBS, Options, option
from adr_opt.common.processors import usable_cores
from adr_opt.common.progress import Progress, tell_plan
from adr_opt.common.stop import Stop
from adr_opt.mission.certified import certify_routes
from adr_opt.mission.mission import Mission
from adr_opt.mission.problem import Problem, problem_of
from adr_opt.mission.result import Result
from adr_opt.plan.plan import Plan
from adr_opt.run.legal_moves import legal_beginning
from adr_opt.run.run_options import Start
from adr_opt.run.start_plan import start_destinations

from ...beams.beams import USUAL, with_time_value
from ...beams.greedy_order import guarded_sequence
from ...routes.one_chaser import one_after_another
from .fleet import Fleet
from .network import UnrollLimits
from .order import Bodies
from .replan import ReplannedWindows, WindowChoice, filled_up, replan

NODES = 20_000
"""Maximum number of nodes in a network, reached only by the longest windows."""

WIDTH = 10
"""Number of moves kept per node."""

LAG = 1.0
"""Largest loss of a path relative to the current plan, in mean prizes."""

TIME_SHARE = 0.5
"""Worth of the whole duration relative to the plan's prize; below 1, so that prize comes first."""

DELTA_V_SHARES = (0.02, 0.1, 0.3)
"""Worth of the whole ΔV, likewise: each window draws one, so that plans of equal prize differ."""

OF_TWO = 0.2
"""Share of draws with windows of two chasers, if there are several: they take ten times as long as
single windows."""


@dataclass(frozen=True)
class OrtoolsOptions(Options, method="ortools"):
    """Options of the planner ``ortools``."""

    jobs: int = option(
        1,
        "Windows planned in parallel, one thread each; 0 for one per core. The number affects the "
        "result.",
        least=0,
        most=MOST_JOBS,
    )
    shortest_window: int = option(6, "Minimum number of moves in a window.", least=1)
    longest_window: int = option(
        10, "Maximum number of moves in a window.", least="shortest_window"
    )
    edges: int = option(400, "Maximum number of candidate moves per window for CP-SAT.", least=1)
    effort: float = option(
        0.4, "Limit of one CP-SAT search in deterministic time, roughly seconds.", above=0.0
    )
    time_value_m_s_per_h: float = option(
        USUAL,
        "Value of time: windows choose from the connections of least ΔV + value · arrival; plans "
        "are timed over all. Below 0: as for `beam`.",
        unit="m/s per h",
    )


def ortools(
    problem: Problem | Mission,
    *,
    seed: int,
    stop: Stop,
    progress: Progress,
    start: Start | None = None,
    options: OrtoolsOptions = OrtoolsOptions(),
) -> Result:
    """Improve a greedy plan window by window with CP-SAT on the exact timetable.

    Never below the plan it starts from. ``stop`` is asked once per window; the same seed, number
    of windows and options give the same plan on any machine, as long as no time limit cuts a
    window short. Of several chasers windows of one or of two are planned anew at a time.

    Parameters
    ----------
    start : Plan or sequence of sequences of int, optional
        A legal plan to begin from, with a route for each chaser; that of ``greedy-guarded`` by
        default.

    Raises
    ------
    InputError
        The start plan is not legal.
    """
    begun = now_s()
    problem = problem_of(problem)
    layers = tuple(
        with_time_value(mission, options.time_value_m_s_per_h) for mission in problem.missions
    )
    best = Fleet.flying(problem, layers, _first_routes(problem, start))
    present = best
    limits = UnrollLimits(NODES, WIDTH, layers[0].time_value_m_s_per_h / HOUR_S, 0.0)
    if problem.planning_prizes.any():
        limits = limits._replace(lag=LAG * best.unit)
        for chaser in range(len(layers)):
            worth = present.worth((chaser,), TIME_SHARE, DELTA_V_SHARES[0])
            present = filled_up(present, (chaser,), worth, limits.time_value)
    if present.better_than(best):
        best = present
    tell_plan(progress, best.objective, *(order.moves for order in best.orders))

    counters: Counter[str] = Counter(
        windows=0,
        closed_by_prices=0,
        full_networks=0,
        solves=0,
        solves_completed=0,
        gains=0,
        no_gains=0,
        grounded=0,
        improved=0,
    )
    rng = np.random.default_rng(seed)
    workers = options.jobs or usable_cores()
    enough = False
    with ThreadPoolExecutor(workers) as pool:
        # Where not one move is legal, or nothing is worth a move, there is no window.
        while not enough and present.objective > 0.0:
            batch: list[WindowChoice] = []
            while len(batch) < workers and not enough:
                enough = stop(best.objective, math.inf)
                if not enough:
                    batch.append(_draw(rng, present, options))

            def work(choice: WindowChoice, fleet: Fleet = present) -> ReplannedWindows:
                return replan(
                    fleet,
                    choice,
                    time_share=TIME_SHARE,
                    limits=limits,
                    edges=options.edges,
                    effort=options.effort,
                    remaining_s=stop.remaining_s(),
                )

            for done in pool.map(work, batch):
                counters["windows"] += 1
                counters.update(done.counters)
                found = done.fleet
                if found is None:
                    continue
                # Of equal prize the window's own measure decides, and it found a gain.
                if found.objective >= present.objective:
                    present = found
                if found.better_than(best):
                    if found.objective > best.objective:
                        counters["improved"] += 1
                        tell_plan(
                            progress, found.objective, *(order.moves for order in found.orders)
                        )
                    best = found
    return certify_routes(
        problem,
        "ortools",
        [order.moves for order in best.orders],
        seed=seed,
        runtime_s=now_s() - begun,
        counters=counters,
    )


def _first_routes(problem: Problem, start: Start | None) -> list[Bodies]:
    """Routes of a start plan, or of the guarded greedy one.

    Raises
    ------
    InputError
        The start plan is not legal.
    """
    if start is not None:
        given: Any = start
        if len(problem.missions) == 1 and not isinstance(start, Plan):
            (given,) = given
        wanted = start_destinations(problem, given)
        routes: Iterable[Iterable[int]] = [
            legal_beginning(mission, names, repair=False)
            for mission, names in zip(problem.missions, wanted, strict=True)
        ]
    else:
        routes = one_after_another(problem, guarded_sequence)
    return [np.array(tuple(route), dtype=np.int64) for route in routes]


def _draw(rng: np.random.Generator, fleet: Fleet, options: OrtoolsOptions) -> WindowChoice:
    """Draw windows of one or of two chasers."""
    count = len(fleet.orders)
    chasers = [0]
    if count > 1:
        taken = 2 if rng.random() < OF_TWO else 1
        chasers = sorted(rng.choice(count, taken, replace=False).tolist())
    spans = {
        chaser: _span(
            rng, fleet.orders[chaser].moves.size, options.shortest_window, options.longest_window
        )
        for chaser in chasers
    }
    return WindowChoice(spans, float(rng.choice(DELTA_V_SHARES)), int(rng.integers(2**31)))


def _span(rng: np.random.Generator, size: int, shortest: int, longest: int) -> tuple[int, int]:
    """A random window of an order of ``size`` moves, with both ends covered equally."""
    length = int(rng.integers(shortest, longest + 1))
    begin = int(rng.integers(-length // 2, max(size, 1)))
    end = begin + length
    if size - end <= length // 3:
        end = size
    return max(begin, 0), end
