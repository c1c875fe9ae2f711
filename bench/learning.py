"""The environment and the learned policy: steps per second, visits, and curves of training.

python bench/learning.py environment --slots 32 --runs 5 --steps 40
python bench/learning.py worlds --slots 16 --counts 256
python bench/learning.py policy nominal reduced-time ppo ppo:decode=beam@1 auto@1 --count 20
python bench/learning.py curve bench/curves/set.csv
"""

from __future__ import annotations

import csv
import sys
import time
from collections.abc import Callable
from pathlib import Path
from statistics import fmean, median, stdev
from typing import cast

import numpy as np
import numpy.typing as npt
from fields import best_known, ready
from gymnasium.spaces import Discrete
from planners import solved
from scipy.stats import t
from tables import experiment, head, row, timed

import adr_opt
from adr_opt.kernels.episodes.episodes import Episodes, StackedFields
from adr_opt.kernels.episodes.observation import MOVE_FIELDS
from adr_opt.learning.environment import OBSERVATIONS, TROUBLED, TROUBLES, MissionEnv, MissionVecEnv
from adr_opt.learning.episodes import Board
from adr_opt.sources.generator import FAMILIES

COST = MOVE_FIELDS.index("hours + ΔV / (450 m/s) [10 h]")

SAFE = MOVE_FIELDS.index("the station stays reachable")


class Cheap:
    """Chooses the cheapest legal move from which the station can be reached, if there is one."""

    def __init__(self, count: int, targets: int) -> None:
        self.board = Board("transfer", count, targets)

    def __call__(self, pool: StackedFields, episodes: Episodes) -> npt.NDArray[np.int64]:
        """Actions of all episodes."""
        self.board.observe(pool, episodes, 0, self.board.legal.size)
        seen = self.board.arrays
        assert isinstance(seen, dict)
        cost = seen["moves"][:, :, COST] + 3.0 * (seen["moves"][:, :, SAFE] == 0.0)
        actions: npt.NDArray[np.int64] = np.where(self.board.mask, cost, np.inf).argmin(axis=1)
        return actions


def vector_rate(
    env: MissionVecEnv, cheap: Cheap, steps: int, clock: Callable[[], float] = time.perf_counter
) -> float:
    """Steps of single missions a second of one run, by a clock."""
    spent = 0.0
    for _ in range(steps):
        actions = cheap(env.pool.arrays, env.episodes)
        began = clock()
        env.step(actions)
        env.action_masks()
        spent += clock() - began
    return steps * env.num_envs / spent


def single_rate(env: MissionEnv, steps: int) -> float:
    """The same of one mission after the other in a Python loop; resets are not timed."""
    cheap = Cheap(1, int(cast(Discrete, env.action_space).n) - 1)
    spent = 0.0
    over = True
    for _ in range(steps):
        if over:
            env.reset()
        assert env._played is not None
        action = cheap(env._played.pool.arrays, env._episodes)[0]
        began = time.perf_counter()
        _, _, over, _, _ = env.step(action)
        env.action_masks()
        spent += time.perf_counter() - began
    return steps / spent


def environment(
    runs: int = 7,
    steps: int = 60,
    slots: int = 64,
    counts: tuple[int, ...] = (256, 1024),
    threads: tuple[int, ...] = (1, 2),
    observations: tuple[str, ...] = tuple(OBSERVATIONS),
) -> None:
    """Steps per second of the environments, with masks and observations.

    Nominal fields, played by a policy that prefers cheap moves with a way back, so that episodes
    are about as long as those of a trained policy. Choosing actions is not timed. Rates are medians
    over runs, with the best in brackets; ratios are to the one-by-one loop of the same call.
    """
    head("environment", "observation", "missions", "threads", "steps/s", "ratio")

    def line(what: tuple[object, ...], rate: Callable[[], float], base: float | None) -> float:
        rates = [rate() for _ in range(runs)]
        middle = median(rates)
        ratio = 1.0 if base is None else middle / base
        row(*what, f"{middle:,.0f} ({max(rates):,.0f})", f"{ratio:.1f} ×")
        return middle

    instance = adr_opt.generate("nominal", 0)
    for seen in observations:
        env = MissionEnv(instance, observation=seen)
        single_rate(env, 50)
        what = "`MissionEnv`, one by one", seen, 1, 1
        base = line(what, lambda env=env: single_rate(env, 400), None)
        for count in counts:
            many = MissionVecEnv(count, observation=seen, slots=slots, threads=max(threads))
            many.reset()
            cheap = Cheap(count, int(cast(Discrete, many.action_space).n) - 1)
            vector_rate(many, cheap, steps)
            for used in threads:
                many.threads = used
                what = "`MissionVecEnv`", seen, count, used
                line(what, lambda many=many, cheap=cheap: vector_rate(many, cheap, steps), base)
            many.close()


def worlds(
    runs: int = 7,
    steps: int = 60,
    slots: int = 64,
    counts: tuple[int, ...] = (256,),
    observations: tuple[str, ...] = ("transfer", "transfer-worlds"),
) -> None:
    """Steps a second in uncertain worlds, beside missions as planned.

    Missions as planned and in worlds of the models ``TROUBLED`` and ``TROUBLES`` take turns, run by
    run, on one thread; rates are by processor time, and ratios to the former.
    """
    models = {"as planned": None, "`TROUBLED`": TROUBLED, "`TROUBLES`": TROUBLES}
    head("uncertainty", "observation", "missions", "steps/s of processor time", "ratio")
    for seen, count in ((seen, count) for seen in observations for count in counts):
        envs = {
            name: MissionVecEnv(count, observation=seen, slots=slots, uncertainty=model)
            for name, model in models.items()
        }
        cheap = Cheap(count, envs["as planned"].fields.most_targets)
        for env in envs.values():
            env.reset()
            vector_rate(env, cheap, steps)
        rates: dict[str, list[float]] = {name: [] for name in envs}
        for _ in range(runs):
            for name, env in envs.items():
                rates[name].append(vector_rate(env, cheap, steps, time.process_time))
        base = median(rates["as planned"])
        for name, found in rates.items():
            middle = median(found)
            row(name, seen, count, f"{middle:,.0f} ({max(found):,.0f})", f"{middle / base:.2f} ×")
            envs[name].close()


def interval(values: list[float]) -> str:
    """Mean with its 95 % interval (Student)."""
    if len(values) < 2:
        return f"{fmean(values):.2f}"
    half = t.ppf(0.975, len(values) - 1) * stdev(values) / len(values) ** 0.5
    return f"{fmean(values):.2f} ± {half:.2f}"


def policy(*what: str, count: int = 20, first: int = 0, targets: int | None = None) -> None:
    """Quality of the learned policy: visits, time, and gaps to the known results of every field.

    Families, then methods. Fields are those of the library, by seed; none was trained on. Every
    plan is checked. Gaps are to the best-known plan and to the best bound of
    ``instances/best-known.csv``, or where a field has no row (``--targets``) to the best plan of
    this run.
    """
    families = [name for name in what if name in FAMILIES] or ["nominal"]
    methods = [name for name in what if name not in FAMILIES]
    methods = methods or ["ppo", "ppo:decode=sample@1", "ppo:decode=beam@1"]
    rows_of = best_known()

    def planned(family: str, seed: int) -> tuple[str, float, dict[str, tuple[float, float, int]]]:
        instance = adr_opt.generate(family, seed, targets=targets)
        problem, built, _ = timed(lambda: ready(instance))
        made = {spec: solved(problem, spec) for spec in methods}
        found = {
            spec: (result.objective, wall, len(adr_opt.check(instance, result.plan)))
            for spec, (result, wall) in made.items()
            if result.plan is not None
        }
        return instance.name, built, found

    for family in families:
        visits, walls = ({spec: list[float]() for spec in methods} for _ in range(2))
        broken, tables = dict.fromkeys(methods, 0), list[float]()
        best, bounds = list[float](), list[float | None]()
        planned(family, first)  # kernels are compiled, and the network is loaded
        for seed in range(first, first + count):
            name, built, made = planned(family, seed)
            tables.append(built)
            for spec, (objective, wall, violations) in made.items():
                visits[spec].append(objective)
                walls[spec].append(wall)
                broken[spec] += violations
            known = rows_of.get(name)
            of_run = max(values[-1] for values in visits.values())
            best.append(max(of_run, float(known["objective"])) if known else of_run)
            bounds.append(float(known["upper_bound"]) if known and known["upper_bound"] else None)
        print(f"\n{family}, {count} fields")
        head(
            *("method", "visits, mean ± 95 %", "min–max", "gap to best-known", "gap to bound"),
            *("time, median", "violations"),
        )
        for spec, found in visits.items():
            to_best, to_bound = (
                [(b - v) / b for b, v in zip(limits, found, strict=True) if b]
                for limits in (best, bounds)
            )
            row(
                f"`{spec}`",
                interval(found),
                f"{min(found):g}–{max(found):g}",
                f"{fmean(to_best):.1%}",
                f"{fmean(to_bound):.1%}" if len(to_bound) == len(found) else "unknown",
                f"{1e3 * median(walls[spec]):.0f} ms",
                broken[spec],
            )
        for name, limits in (("best known", best), ("best bound", bounds)):
            if all(limits):
                row(name, interval(limits), f"{min(limits):g}–{max(limits):g}", *[""] * 4)
        print(f"\nTimetable besides: {1e3 * median(tables):.0f} ms a field, median.")


def curve(file: Path, rows: int = 12) -> None:
    """The evaluations of a training, thinned out."""
    with file.open(newline="", encoding="utf-8") as lines:
        found = list(csv.DictReader(lines))
    every = max(1, -(-len(found) // rows))
    names = [name for name in found[0] if name not in ("steps", "seconds")]
    head("steps", "minutes", *names)
    for at, one in enumerate(found):
        if at % every == 0 or one is found[-1]:
            minutes = f"{float(one['seconds']) / 60:.0f}"
            row(f"{int(one['steps']):,}", minutes, *(f"{float(one[name]):.2f}" for name in names))


if __name__ == "__main__":
    sys.exit(experiment(__doc__, environment, worlds, policy, curve))
