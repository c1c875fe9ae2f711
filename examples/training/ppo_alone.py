"""Masked PPO in one file, without a library of learners: 26 visits of 50 in two minutes.

python examples/training/ppo_alone.py --steps 300000
"""

import argparse
import time

import gymnasium
import numpy as np
import torch
from torch.distributions import Categorical

import adr_opt.learning.environment  # noqa: F401  registers the environment
from adr_opt.learning.held_out import HeldFields
from adr_opt.learning.training.policy_network import SetNetwork

COUNT, LENGTH, BATCH, EPOCHS = 256, 64, 1024, 2
RATE, LAMBDA, CLIP, ENTROPY, SCALE = 1e-3, 0.97, 0.2, 0.008, 0.1


def main(steps: int, count: int = COUNT, pool: int = 48, seed: int = 1, held: int = 12) -> float:
    """Train; returns the mean of nominal visits on held fields."""
    torch.manual_seed(seed)
    env = gymnasium.make_vec("adr_opt/Mission-v0", count, pool=pool, pool_seed=seed)
    network, fields, began = SetNetwork(), HeldFields(count=held), time.perf_counter()
    optimiser = torch.optim.Adam(network.parameters(), RATE, eps=1e-5)

    def judged(moves, mission, mask):
        scores, values = network(torch.as_tensor(moves), torch.as_tensor(mission))
        return Categorical(logits=scores.masked_fill(~torch.as_tensor(mask), -1e8)), values

    def best(board):
        with torch.no_grad():
            chosen = judged(board.choices.moves, board.choices.mission, board.mask)[0]
        return chosen.logits.argmax(1).numpy()

    seen, info = env.reset(seed=seed)
    for done in range(0, steps, count * LENGTH):
        left = 1.0 - done / steps  # rate and entropy fall to zero
        optimiser.param_groups[0]["lr"], told = RATE * left, []
        for _ in range(LENGTH):
            state = seen["moves"], seen["mission"], info["action_mask"] > 0
            with torch.no_grad():
                policy, values = judged(*state)
                actions = policy.sample()
            seen, rewards, over, _, info = env.step(actions.numpy())
            told.append((*state, actions, policy.log_prob(actions), values, SCALE * rewards, over))
        *states, actions, logs, values, rewards, over = (
            torch.as_tensor(np.array(each)) for each in zip(*told, strict=True)
        )
        with torch.no_grad():
            after = judged(seen["moves"], seen["mission"], info["action_mask"] > 0)[1]
        gains, gain = torch.zeros_like(values), 0.0
        for at in reversed(range(LENGTH)):  # generalised advantages
            goes_on = 1.0 - over[at].float()
            gain = rewards[at] + goes_on * (after + LAMBDA * gain) - values[at]
            gains[at], after = gain, values[at]
        flat = [each.flatten(0, 1) for each in (*states, actions, logs, gains, gains + values)]
        for _ in range(EPOCHS):
            for rows in torch.randperm(count * LENGTH).split(BATCH):
                *state, act, old, gain, worth = (each[rows] for each in flat)
                policy, value = judged(*state)
                gain = (gain - gain.mean()) / (gain.std() + 1e-8)
                ratio = (policy.log_prob(act) - old).exp()
                loss = -torch.min(ratio * gain, ratio.clamp(1 - CLIP, 1 + CLIP) * gain).mean()
                loss += 0.5 * (value - worth).square().mean()
                loss -= ENTROPY * left * policy.entropy().mean()
                optimiser.zero_grad()
                loss.backward()
                torch.nn.utils.clip_grad_norm_(network.parameters(), 0.5)
                optimiser.step()
        visits = fields.means(best)["nominal"]
        print(f"{done + count * LENGTH} steps, {time.perf_counter() - began:.0f} s: {visits:.2f}")
    return visits


if __name__ == "__main__":
    asked = argparse.ArgumentParser(description=__doc__)
    asked.add_argument("--steps", type=int, default=300_000)
    main(asked.parse_args().steps)
