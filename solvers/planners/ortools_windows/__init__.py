"""Planner `ortools`: windows of a plan, re-planned by CP-SAT on the exact timetable.

OR-Tools has no routing with costs that depend on the time of travel, and a route planned on costs
frozen at one epoch falls apart when it is timed. So nothing is frozen here. The guarded greedy
plan is the first incumbent; then, again and again, a window of it (one to two days) is thrown
away and planned anew:

1. :mod:`.order` has all schedules of the plan that are worth having. The window begins from the one
   that is best by the window's own measure of time and ΔV: that of least ΔV, which counts in the
   end, would wait for cheap transfers until no time is left.
2. :mod:`.unrolling` unrolls the window into the moves that can be made in it, each by the
   connection that a time value chooses, and flies the rest of the plan from every node in the same
   way, to know what it is worth to arrive there then.
3. :mod:`.prices` bounds what any path of the network is worth and keeps the few hundred edges
   that a better plan is most likely to use. Often this alone proves that there is none.
4. :mod:`.model` lets CP-SAT find the best path that visits no target twice and keeps to the ΔV.
5. The best schedule of the new order, over all connections, says whether it can be flown and gains
   what was promised. :func:`.order.filled` appends and inserts what still fits.

Of several chasers one or two are drawn, and a window of each (:mod:`.fleet`). Either may visit
what is in both, and :mod:`.joined` makes one network of the two, so that targets change hands: one
CP-SAT model, priced together, with a path for each chaser.

A window is judged by prize first, then by how early the plan ends and how little ΔV it takes:
most windows gain only slack, which a later window turns into a visit.

What was tried, on the nominal family
-------------------------------------
- *Routing windows*: ``pywrapcp`` with optional visits, a time and a ΔV dimension, a station that
  refuels, arcs at the costs of the middle of the window. Most of its windows broke the rest of the
  plan when they were timed exactly, and plans stayed a visit behind at several times the work.
- *All moves of a window* instead of the most promising ones: from some thousand edges on CP-SAT
  spends its time before it has a first solution. Fewer edges, more windows: 400 did better than
  800 or 1000.
- *Longer windows* have more to gain each, but there are fewer of them, and as many edges cover
  them more thinly; they did slightly worse. So did shorter ones.
- *No limit on how far a path may fall behind the present plan*: growing the networks takes longer
  for the same plans; a limit well below one visit loses plans.
- *Accepting a lower prize* for enough slack gained nothing over accepting equal prize with more
  slack, which most gains are.
- *Windows of two chasers*, with 400 edges each, in every draw or in every second one: 34.5 and 35.5
  visits after 8 s on the first four fields of the family campaign, 35.75 without: they take so long
  that few are planned. With 400 edges for both, in a fifth of the draws: 36.0 against 35.5 without,
  and no difference in 14 s on the next four fields.
- *Time values* of 75, 90, 110 and 130 m/s per h, 10 s on the first five fields: 28.8, 29.0, 29.0
  and 29.2 visits. 110 is what beams choose by, so that one timetable does for both.
- *CP-SAT's settings* (presolve, linearisation, probing, symmetry): no difference beyond noise.

It proves nothing about the mission as a whole, and on thousands of targets the windows see only
those nearby.
"""

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
from ...routes.one_chaser import guarded_routes
from .fleet import Fleet
from .order import Bodies
from .replan import ReplannedWindows, WindowChoice, filled_up, replan
from .window_network import UnrollLimits

__all__ = ["ortools"]


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
        "are timed over all. Below 0: 110, and less where planes drift.",
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
        routes = guarded_routes(problem)
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
