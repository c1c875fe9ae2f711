"""The environment in TorchRL, with moves that are not legal masked: missions of random moves.

pip install torchrl
python examples/training/torchrl_missions.py --missions 5
"""

import argparse

import gymnasium
import torch
from tensordict import TensorDict
from torchrl.data import Binary
from torchrl.envs import ActionMask, GymWrapper, TransformedEnv
from torchrl.envs.gym_like import default_info_dict_reader

import adr_opt.learning.environment  # noqa: F401  registers the environment


def mission_env(**arguments: object) -> TransformedEnv:
    """One mission at a time as an environment of TorchRL; arguments are those of the mission."""
    env = gymnasium.make("adr_opt/Mission-v0", **arguments)
    moves = int(env.action_space.n)
    wrapped = GymWrapper(env, categorical_action_encoding=True)
    mask = {"action_mask": Binary(n=moves, shape=(moves,), dtype=torch.bool)}
    wrapped.set_info_dict_reader(default_info_dict_reader(["action_mask"], spec=mask))
    # Draws of ``rand_action`` and specs of actors then hold legal moves alone.
    return TransformedEnv(wrapped, ActionMask())


def main(missions: int) -> list[TensorDict]:
    """Play missions to their end; returns what TorchRL's losses take."""
    env = mission_env(pool=2, pool_seed=0)
    played = [env.rollout(1000) for _ in range(missions)]
    for told in played:
        print(f"{len(told)} moves, {told['next', 'reward'].sum():.0f} visits")
    return played


if __name__ == "__main__":
    asked = argparse.ArgumentParser(description=__doc__)
    asked.add_argument("--missions", type=int, default=5)
    main(asked.parse_args().missions)
