"""Steps per second of the environments, with masks and observations.

    python bench/environment.py
    python bench/environment.py --resets --slots 32 --observations transfer lookahead
    python bench/environment.py --worlds --slots 16 --counts 256

Nominal fields, played by a policy that prefers cheap moves with a way back, so that episodes are
about as long as those of a trained policy. Choosing actions is not timed. Rates are medians over
runs, with the best in brackets; ratios are to the one-by-one loop of the same call. With
``--worlds`` missions as planned and missions in uncertain worlds (the model ``TROUBLED``, and the
models ``TROUBLES``) take turns, run by run, on one thread; rates are by processor time, and ratios
to the former.
"""

from __future__ import annotations

import argparse
import statistics
import time
from collections.abc import Callable, Sequence

import numpy as np
import numpy.typing as npt
from machine import heading

import adr_opt
from adr_opt.kernels.episodes.episodes import Episodes, StackedFields
from adr_opt.kernels.episodes.observation import MOVE_FIELDS
from adr_opt.learning.environment import OBSERVATIONS, TROUBLED, TROUBLES, MissionEnv, MissionVecEnv
from adr_opt.learning.episodes import Board

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
    cheap = Cheap(1, int(env.action_space.n) - 1)
    spent = 0.0
    over = True
    for _ in range(steps):
        if over:
            env.reset()
        assert env._pool is not None
        action = cheap(env._pool.arrays, env._episodes)[0]
        began = time.perf_counter()
        _, _, over, _, _ = env.step(action)
        env.action_masks()
        spent += time.perf_counter() - began
    return steps / spent


def reset_rate(env: MissionEnv, resets: int) -> float:
    """Resets a second on fields that were drawn ahead."""
    began = time.perf_counter()
    for _ in range(resets):
        env.reset()
    return resets / (time.perf_counter() - began)


def resets(runs: int, slots: int, observations: Sequence[str]) -> None:
    """Print what a pool takes, and resets a second on it."""
    print("| observation | fields | working them out | resets/s |")
    print("|---|---|---|---|")
    for observation in observations:
        env = MissionEnv(pool=slots, observation=observation)
        began = time.perf_counter()
        env.reset(seed=0)
        first_s = time.perf_counter() - began
        rates = [reset_rate(env, 1000) for _ in range(runs)]
        taken = f"{statistics.median(rates):,.0f} ({max(rates):,.0f})"
        print(f"| {observation} | {slots} | {first_s:.1f} s | {taken} |", flush=True)


def worlds(arguments: argparse.Namespace) -> None:
    """Print steps a second in uncertain worlds, beside missions as planned."""
    models = {"as planned": None, "`TROUBLED`": TROUBLED, "`TROUBLES`": TROUBLES}
    print("| uncertainty | observation | missions | steps/s of processor time | ratio |")
    print("|---|---|---|---|---|")
    for observation in arguments.observations:
        for count in arguments.counts:
            envs = {
                name: MissionVecEnv(
                    count, observation=observation, slots=arguments.slots, uncertainty=model
                )
                for name, model in models.items()
            }
            cheap = Cheap(count, envs["as planned"].fields.most_targets)
            for env in envs.values():
                env.reset()
                vector_rate(env, cheap, arguments.steps)
            rates: dict[str, list[float]] = {name: [] for name in envs}
            for _ in range(arguments.runs):
                for name, env in envs.items():
                    rate = vector_rate(env, cheap, arguments.steps, time.process_time)
                    rates[name].append(rate)
            base = statistics.median(rates["as planned"])
            for name, found in rates.items():
                middle = statistics.median(found)
                taken = f"{middle:,.0f} ({max(found):,.0f}) | {middle / base:.2f} ×"
                print(f"| {name} | {observation} | {count} | {taken} |", flush=True)
            for env in envs.values():
                env.close()


def lookup_rate(mission: adr_opt.Mission, steps: int) -> float:
    """Masks alone, computed in Python from ``Timetable.lookup`` of every move."""
    duration, budget = mission.instance.mission.duration_s, mission.instance.chaser.tank.delta_v_m_s
    service = mission.rules.service
    visited: set[int] = set()
    body, now, left, since = 0, 0.0, budget, 0
    spent = 0.0
    for _ in range(steps):
        began = time.perf_counter()
        legal = {}
        for j in range(len(mission.names)):
            if j == body or j in visited or (j == 0 and since == 0):
                continue
            delta_v, arrival = mission.timetable.lookup(body, j, now)
            if delta_v <= left and arrival + service[j] <= duration:
                legal[j] = (arrival + service[j], delta_v)
        spent += time.perf_counter() - began
        if not legal:
            visited, body, now, left, since = set(), 0, 0.0, budget, 0
            continue
        j = min(legal, key=lambda j: legal[j][0] / 3600.0 + legal[j][1] / 450.0)
        now, delta_v = legal[j]
        left = budget if j == 0 else left - delta_v
        since = 0 if j == 0 else since + 1
        visited |= {j} - {0}
        body = j
    return steps / spent


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--runs", type=int, default=7)
    parser.add_argument("--steps", type=int, default=60, help="steps of every mission in a run")
    parser.add_argument("--slots", type=int, default=64, help="fields in the pool")
    parser.add_argument("--counts", type=int, nargs="+", default=[256, 1024])
    parser.add_argument("--threads", type=int, nargs="+", default=[1, 2])
    parser.add_argument("--observations", nargs="+", default=list(OBSERVATIONS))
    parser.add_argument("--resets", action="store_true", help="resets of drawn fields alone")
    parser.add_argument("--worlds", action="store_true", help="uncertain worlds alone")
    arguments = parser.parse_args()
    print(heading())
    if arguments.worlds:
        worlds(arguments)
        return
    if arguments.resets:
        resets(arguments.runs, arguments.slots, arguments.observations)
        return
    print("| environment | observation | missions | threads | steps/s | ratio |")
    print("|---|---|---|---|---|---|")

    def row(what: str, rate: Callable[[], float], base: float | None) -> float:
        rates = [rate() for _ in range(arguments.runs)]
        middle = statistics.median(rates)
        ratio = 1.0 if base is None else middle / base
        print(f"| {what} | {middle:,.0f} ({max(rates):,.0f}) | {ratio:.1f} × |", flush=True)
        return middle

    instance = adr_opt.generate("nominal", 0)
    for observation in arguments.observations:
        env = MissionEnv(instance, observation=observation)
        single_rate(env, 50)
        base = row(
            f"`MissionEnv`, one by one | {observation} | 1 | 1",
            lambda env=env: single_rate(env, 400),  # type: ignore[misc]
            None,
        )
        for count in arguments.counts:
            many = MissionVecEnv(
                count,
                observation=observation,
                slots=arguments.slots,
                threads=max(arguments.threads),
            )
            many.reset()
            cheap = Cheap(count, int(many.action_space.n) - 1)  # type: ignore[attr-defined]
            vector_rate(many, cheap, arguments.steps)
            for threads in arguments.threads:
                many.threads = threads
                row(
                    f"`MissionVecEnv` | {observation} | {count} | {threads}",
                    lambda many=many, cheap=cheap: vector_rate(many, cheap, arguments.steps),  # type: ignore[misc]
                    base,
                )
            many.close()
    mission = adr_opt.Mission(instance)
    row(
        "`Timetable.lookup` of every move | mask alone | 1 | 1",
        lambda: lookup_rate(mission, 200),
        None,
    )


if __name__ == "__main__":
    main()
