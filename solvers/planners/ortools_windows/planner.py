"""The planner: a greedy plan, then window after window."""

from __future__ import annotations

import math
import os
import time
from collections import Counter
from collections.abc import Iterable
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass

import numpy as np

from adr_opt.kernels.constants import HOUR_S
from adr_opt.mission import Mission
from adr_opt.options import MOST_JOBS, Options, option
from adr_opt.plan import Plan
from adr_opt.planner import Progress
from adr_opt.result import Result, certify
from adr_opt.start import start_sequence
from adr_opt.stop import Stop

from ...search.beams import USUAL, hurried
from ...search.greedy_order import guarded_sequence
from .network import Limits
from .order import Order, filled, flown
from .replan import Choice, Replanned, replan, worth_of

NODES = 20_000
"""Most nodes of a network; only the longest windows reach it."""

WIDTH = 10
"""Moves kept per node."""

LAG = 1.0
"""How far a path may fall behind the present plan, in mean prizes."""

TIME_SHARE = 0.5
"""Worth of the whole duration relative to the prize of the plan; below 1, so prize comes first."""

DELTA_V_SHARES = (0.02, 0.1, 0.3)
"""The same of the whole ΔV: each window draws one, so that plans of equal prize differ."""


@dataclass(frozen=True)
class OrtoolsOptions(Options, method="ortools"):
    """Options of the planner ``ortools``."""

    jobs: int = option(
        1,
        "Windows planned at a time, each in its thread; 0 for one per core. Another number of jobs "
        "is another search.",
        least=0,
        most=MOST_JOBS,
    )
    shortest_window: int = option(6, "Least moves of a window.", least=1)
    longest_window: int = option(10, "Most moves of a window.", least="shortest_window")
    edges: int = option(400, "Most moves that CP-SAT may choose from in one window.", least=1)
    effort: float = option(
        0.4, "Limit of one CP-SAT search in its deterministic time, about seconds.", above=0.0
    )
    time_value_m_s_per_h: float = option(
        USUAL,
        "Windows choose from the connections of least ΔV + this · arrival; plans are timed over "
        "all. Below 0: as for `beam`.",
        unit="m/s per h",
    )


def ortools(
    mission: Mission,
    *,
    seed: int,
    stop: Stop,
    progress: Progress,
    start: Plan | Iterable[int] | None = None,
    options: OrtoolsOptions = OrtoolsOptions(),
) -> Result:
    """Improve a greedy plan window by window with CP-SAT on the exact timetable.

    Never below the plan it starts from. ``stop`` is asked once per window; the same seed, number
    of windows and options give the same plan on any machine, as long as no time limit cuts a
    window short.

    Parameters
    ----------
    start : Plan or sequence of int, optional
        A legal plan to begin from; that of ``greedy-guarded`` by default.

    Raises
    ------
    InputError
        The start plan is not legal.
    """
    begun = time.perf_counter()
    layer = hurried(mission, options.time_value_m_s_per_h)
    rules = layer.rules
    limits = Limits(
        NODES,
        WIDTH,
        options.time_value_m_s_per_h / HOUR_S,
        LAG * float(rules.prize.sum()) / max(1, int(np.count_nonzero(rules.prize))),
    )
    if start is None:
        first = guarded_sequence(mission)
    else:
        first = np.array(start_sequence(mission, start), dtype=np.int64)
    best = flown(layer, first) or Order(layer, np.empty(0, np.int64))
    present = best
    if rules.prize.any():
        worth = worth_of(rules, present.timing, TIME_SHARE, DELTA_V_SHARES[0])
        present = filled(layer, present, worth, limits.time_value)
    if present.better_than(best):
        best = present
    progress(best.timing.objective, math.inf)

    counters: Counter[str] = Counter(
        windows=0, closed_by_prices=0, full_networks=0, solves=0, solves_completed=0, gains=0,
        no_gains=0, grounded=0, improved=0,
    )  # fmt: skip
    rng = np.random.default_rng(seed)
    workers = options.jobs or os.cpu_count() or 1
    enough = False
    with ThreadPoolExecutor(workers) as pool:
        # Where not one move is legal, or nothing is worth a move, there is no window.
        while not enough and present.timing.objective > 0.0:
            batch: list[Choice] = []
            while len(batch) < workers and not enough:
                enough = stop(best.timing.objective, math.inf)
                if not enough:
                    size = present.moves.size
                    batch.append(_draw(rng, size, options.shortest_window, options.longest_window))

            def work(choice: Choice, order: Order = present) -> Replanned:
                return replan(
                    layer, order, choice,
                    time_share=TIME_SHARE, limits=limits, edges=options.edges,
                    effort=options.effort, remaining_s=stop.remaining_s(),
                )  # fmt: skip

            for done in pool.map(work, batch):
                counters["windows"] += 1
                counters.update(done.counters)
                found = done.order
                if found is None:
                    continue
                # Of equal prize the window's own measure decides, and it found a gain.
                if found.timing.objective >= present.timing.objective:
                    present = found
                if found.better_than(best):
                    if found.timing.objective > best.timing.objective:
                        counters["improved"] += 1
                        progress(found.timing.objective, math.inf)
                    best = found
    return certify(
        mission,
        "ortools",
        best.moves,
        seed=seed,
        runtime_s=time.perf_counter() - begun,
        counters=counters,
    )


def _draw(rng: np.random.Generator, size: int, shortest: int, longest: int) -> Choice:
    """Draw a window of a plan of ``size`` moves; both ends of the plan get their share."""
    length = int(rng.integers(shortest, longest + 1))
    begin = int(rng.integers(-length // 2, size))
    end = begin + length
    if size - end <= length // 3:
        end = size
    return Choice(
        max(begin, 0),
        end,
        float(rng.choice(DELTA_V_SHARES)),
        int(rng.integers(2**31)),
    )
