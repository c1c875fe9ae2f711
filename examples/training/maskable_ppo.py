"""Train MaskablePPO of sb3-contrib on the environment, and turn an episode into a checked plan.

python examples/training/maskable_ppo.py

Needs the extra [rl]. Prints how long training takes, and how many targets the policy services on
fields that it has not seen, beside legal moves at random and the planner greedy-guarded.
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
from adr_opt.learning.environment import ID, MissionEnv
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


def main() -> None:
    """Train, and compare."""
    parser = argparse.ArgumentParser(description="train MaskablePPO on the environment")
    parser.add_argument("--family", default="nominal")
    parser.add_argument("--steps", type=int, default=20_000)
    parser.add_argument("--pool", type=int, default=32, help="fields that are drawn ahead")
    parser.add_argument("--fields", type=int, default=20, help="unseen fields to compare on")
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--out", help="plan file of the first unseen field")
    asked = parser.parse_args()

    settings = {"fields": adr_opt.learning.environment.Fields(asked.family), "pool": asked.pool}
    began = time.perf_counter()
    env = make_vec_env(ID, n_envs=8, seed=asked.seed, env_kwargs=settings)
    env.reset()
    print(f"{asked.pool} fields worked out in {time.perf_counter() - began:.1f} s")

    model = MaskablePPO(
        "MultiInputPolicy", env, n_steps=256, batch_size=256, gamma=1.0, ent_coef=0.01,
        learning_rate=1e-3, seed=asked.seed, device="cpu",
    )  # fmt: skip
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
    alone = gymnasium.make(ID, **settings).unwrapped
    assert isinstance(alone, MissionEnv)
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
