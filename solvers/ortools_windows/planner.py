"""The planner: a greedy plan, then window after window."""

from __future__ import annotations

import math
import os
import time
from collections import Counter
from collections.abc import Iterable
from concurrent.futures import ThreadPoolExecutor

import numpy as np

from adr_opt.errors import InputError
from adr_opt.mission import Mission
from adr_opt.plan import Plan
from adr_opt.planner import Progress, get, silent
from adr_opt.result import Result, certify
from adr_opt.schedule import Schedule
from adr_opt.start import start_sequence
from adr_opt.stop import Stop

from . import fill
from .network import Limits
from .replan import Bodies, Choice, Replanned, replan

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


def ortools(
    mission: Mission,
    *,
    seed: int,
    stop: Stop,
    progress: Progress,
    start: Plan | Iterable[int] | None = None,
    jobs: int = 1,
    shortest_window: int = 6,
    longest_window: int = 10,
    edges: int = 400,
    effort: float = 0.4,
) -> Result:
    """Improve a greedy plan window by window with CP-SAT on the exact timetable.

    Never below the plan it starts from. ``stop`` is asked once per window; the same seed, number
    of windows and options give the same plan on any machine, as long as no time limit cuts a
    window short.

    Parameters
    ----------
    start : Plan or sequence of int, optional
        A legal plan to begin from; that of ``greedy-guarded`` by default.
    jobs : int
        Windows planned at a time, each in its thread; 0 for one per core. Another number of jobs
        is another search.
    shortest_window, longest_window : int
        Moves of a window.
    edges : int
        Most moves that CP-SAT may choose from in one window.
    effort : float
        Limit of one CP-SAT search in its deterministic time, about seconds.

    Raises
    ------
    InputError
        An option is out of range, or the start plan is not legal.
    """
    _check(jobs, shortest_window, longest_window, edges, effort)
    begun = time.perf_counter()
    rules = mission.rules
    limits = Limits(
        NODES,
        WIDTH,
        mission.instance.time_value_m_s_per_h / 3600.0,
        LAG * mission.total_prize / max(1, int(np.count_nonzero(rules.prize))),
    )
    if start is None:
        first = get("greedy-guarded")(mission, seed=seed, stop=stop, progress=silent).sequence
    else:
        first = start_sequence(mission, start)
    best = np.array(first or (), dtype=np.int64)
    best_timing = mission.time(best)
    present = fill.filled(rules, best, limits.time_value)
    timing = mission.time(present)
    if _better(timing, best_timing):
        best, best_timing = present, timing
    elif timing.objective < best_timing.objective:
        present, timing = best, best_timing
    progress(best_timing.objective, math.inf)

    counters: Counter[str] = Counter(
        windows=0, closed_by_prices=0, full_networks=0, solves=0, solves_completed=0, gains=0,
        improved=0,
    )  # fmt: skip
    rng = np.random.default_rng(seed)
    workers = jobs or os.cpu_count() or 1
    enough = False
    with ThreadPoolExecutor(workers) as pool:
        # Where not one move is legal, or nothing is worth a move, there is no window.
        while not enough and timing.objective > 0.0:
            batch: list[Choice] = []
            while len(batch) < workers and not enough:
                enough = stop(best_timing.objective, math.inf)
                if not enough:
                    batch.append(_draw(rng, present.size, shortest_window, longest_window))

            def work(choice: Choice, plan: Bodies = present, facts: Schedule = timing) -> Replanned:
                return replan(
                    mission, plan, facts, choice,
                    time_share=TIME_SHARE, limits=limits, edges=edges, effort=effort,
                    remaining_s=stop.remaining_s(),
                )  # fmt: skip

            for done in pool.map(work, batch):
                counters["windows"] += 1
                counters.update(done.counters)
                if done.sequence is None:
                    continue
                found = mission.time(done.sequence)
                # Of equal prize the window's own measure decides, and it found a gain.
                if found.objective >= timing.objective:
                    present, timing = done.sequence, found
                if _better(found, best_timing):
                    if found.objective > best_timing.objective:
                        counters["improved"] += 1
                        progress(found.objective, math.inf)
                    best, best_timing = done.sequence, found
    return certify(
        mission,
        "ortools",
        best,
        seed=seed,
        runtime_s=time.perf_counter() - begun,
        counters=counters,
    )


def _check(jobs: int, shortest_window: int, longest_window: int, edges: int, effort: float) -> None:
    for what, value, least in (
        ("jobs", jobs, 0),
        ("shortest_window", shortest_window, 1),
        ("longest_window", longest_window, shortest_window),
        ("edges", edges, 1),
    ):
        if value < least:
            raise InputError(f"option {what} = {value} of method 'ortools': must be ≥ {least}")
    if not (math.isfinite(effort) and effort > 0.0):
        raise InputError(f"option effort = {effort} of method 'ortools': must be positive")


def _better(one: Schedule, other: Schedule) -> bool:
    """Whether a plan beats another: more prize, then less ΔV (MODEL section 4)."""
    return (one.objective, -one.delta_v) > (other.objective, -other.delta_v)


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
