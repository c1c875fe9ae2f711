"""Train MaskablePPO of sb3-contrib on the environment, and turn an episode into a checked plan.

python examples/training/maskable_ppo.py
python examples/training/maskable_ppo.py --worlds 5

Needs the extra [rl]. Prints how long training takes, and how many targets the policy services on
fields that it has not seen, beside legal moves at random and the planner greedy-guarded. With
``--worlds`` it trains in uncertain worlds, and plays that number of them on each unseen field, as
do legal moves at random and a greedy policy that keeps the way back to the station.
"""

from __future__ import annotations

import argparse
import time
from collections.abc import Callable

import gymnasium
import numpy as np
from sb3_contrib import MaskablePPO
from stable_baselines3.common.env_util import make_vec_env

import adr_opt
from adr_opt.kernels.episodes.choices import COST, SAFE
from adr_opt.learning.environment import ID, UNCERTAIN_ID, MissionEnv
from adr_opt.mission.certified import certify
from adr_opt.mission.result import Result

Choose = Callable[[dict[str, np.ndarray], np.ndarray], int]


def flown(env: MissionEnv, choose: Choose, instance: adr_opt.Instance) -> Result:
    """Play one episode on an instance, and make a plan of it."""
    observation, info = env.reset(options={"instance": instance})
    began, over = time.perf_counter(), False
    while not over:
        action = choose(observation, info["action_mask"])
        observation, _, over, _, info = env.step(action)
    runtime_s = time.perf_counter() - began
    result = certify(env.mission, "my-policy", env.sequence, seed=0, runtime_s=runtime_s)
    assert result.plan is not None
    assert adr_opt.check(instance, result.plan) == ()
    return result


def greedy(observation: dict[str, np.ndarray], mask: np.ndarray) -> int:
    """The cheapest legal move from which the station can be reached, if there is one."""
    moves = observation["moves"]
    cost = moves[:, COST] + 10.0 * (moves[:, SAFE] == 0.0)
    return int(np.where(mask, cost, np.inf).argmin())


def collected_in(
    env: MissionEnv, choose: Choose, instances: list[adr_opt.Instance], worlds: int
) -> list[float]:
    """Prizes collected on each instance in worlds of the seeds from 0 on [mean prizes]."""
    found = []
    for instance in instances:
        for world in range(worlds):
            observation, info = env.reset(options={"instance": instance, "world": world})
            over = False
            while not over:
                action = choose(observation, info["action_mask"])
                observation, _, over, _, info = env.step(action)
            found.append(info["collected"])
    return found


def main() -> None:
    """Train, and compare."""
    parser = argparse.ArgumentParser(description="train MaskablePPO on the environment")
    parser.add_argument("--family", default="nominal")
    parser.add_argument("--steps", type=int, default=20_000)
    parser.add_argument("--pool", type=int, default=32, help="fields that are drawn ahead")
    parser.add_argument("--fields", type=int, default=20, help="unseen fields to compare on")
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--out", help="plan file of the first unseen field")
    parser.add_argument(
        "--worlds", type=int, default=0, help="train in uncertain worlds, and compare in this many"
    )
    asked = parser.parse_args()

    settings = {"fields": adr_opt.learning.environment.Fields(asked.family), "pool": asked.pool}
    began = time.perf_counter()
    name = UNCERTAIN_ID if asked.worlds else ID
    env = make_vec_env(name, n_envs=8, seed=asked.seed, env_kwargs=settings)
    env.reset()
    print(f"{asked.pool} fields worked out in {time.perf_counter() - began:.1f} s")

    model = MaskablePPO(
        "MultiInputPolicy",
        env,
        n_steps=256,
        batch_size=256,
        gamma=1.0,
        ent_coef=0.01,
        learning_rate=1e-3,
        seed=asked.seed,
        device="cpu",
    )
    began = time.perf_counter()
    model.learn(asked.steps)
    print(f"{model.num_timesteps:,} steps trained in {time.perf_counter() - began:.1f} s")

    rng = np.random.default_rng(asked.seed)

    def learned(observation: dict[str, np.ndarray], mask: np.ndarray) -> int:
        action, _ = model.predict(observation, action_masks=mask.astype(bool), deterministic=True)
        return int(action)

    def at_random(observation: dict[str, np.ndarray], mask: np.ndarray) -> int:
        return int(rng.choice(np.flatnonzero(mask)))

    # Fields of the pool have seeds from 1,000,000 on, so these are none of them.
    unseen = [adr_opt.generate(asked.family, seed) for seed in range(asked.fields)]
    alone = gymnasium.make(name, **settings).unwrapped
    assert isinstance(alone, MissionEnv)
    if asked.worlds:
        for who, choose in (
            ("MaskablePPO", learned),
            ("legal moves at random", at_random),
            ("greedy", greedy),
        ):
            prizes = collected_in(alone, choose, unseen, asked.worlds)
            print(f"{who}: {np.mean(prizes):.1f} targets, mean of {len(prizes)} worlds")
        return
    results = [flown(alone, learned, instance) for instance in unseen]
    for name, objectives in (
        ("MaskablePPO", [result.objective for result in results]),
        ("legal moves at random", [flown(alone, at_random, each).objective for each in unseen]),
        ("greedy-guarded", [adr_opt.solve(each, "greedy-guarded").objective for each in unseen]),
    ):
        print(f"{name}: {np.mean(objectives):.1f} targets, mean of {len(unseen)} fields")
    if asked.out is not None and results[0].plan is not None:
        results[0].plan.save(asked.out)


if __name__ == "__main__":
    main()
