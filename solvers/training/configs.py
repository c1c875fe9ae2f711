"""Named training configurations."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

from adr_opt.common.errors import InputError
from adr_opt.learning.environment.fields import PUBLISHED, VARIED, Fields


@dataclass(frozen=True)
class Config:
    """A training configuration, without seed and number of steps.

    Attributes
    ----------
    name, summary : str
    policy : {"set", "mlp"}
        Network: :class:`.network.SetNetwork` or Stable-Baselines3's multilayer
        perceptron.
    observation : str
        One of :data:`adr_opt.learning.episodes.OBSERVATIONS`.
    fields : Fields
        What is trained on.
    steps : int
        Environment steps of the whole training.
    missions, slots, refresh_every
        Of the :class:`adr_opt.learning.environment.MissionVecEnv`.
    rollout : int
        Steps of each mission between two updates.
    batch, epochs, learning_rate, gamma, gae_lambda, clip, entropy, value_weight, gradient_norm
        Of PPO. The learning rate falls linearly to ``final_learning_rate``.
    reward_scale : float
        Factor of the rewards while training.
    network : dict
        Options of the network.
    """

    name: str
    summary: str
    policy: str
    observation: str
    fields: Fields
    steps: int
    missions: int = 256
    slots: int = 64
    refresh_every: int = 4096
    rollout: int = 64
    batch: int = 512
    epochs: int = 3
    learning_rate: float = 5e-4
    final_learning_rate: float = 0.0
    gamma: float = 1.0
    gae_lambda: float = 0.95
    clip: float = 0.2
    entropy: float = 0.005
    value_weight: float = 0.5
    gradient_norm: float = 0.5
    reward_scale: float = 0.1
    network: dict[str, Any] = field(default_factory=dict)


PUBLISHED_CONFIG = Config(
    name="published",
    summary="the published appendix: MLP 2 x 256 tanh, 10 million steps on 50-target fields",
    policy="mlp",
    observation="published",
    fields=PUBLISHED,
    steps=10_000_000,
    missions=128,
    # Not in the appendix: Stable-Baselines3's own defaults, but for the length of a rollout, which
    # is shared out over many missions.
    rollout=128,
    batch=2048,
    epochs=10,
    learning_rate=5e-6,
    final_learning_rate=5e-6,
    gamma=0.99,
    gae_lambda=0.95,
    clip=0.2,
    entropy=0.0,
    reward_scale=1.0,
    network={"net_arch": [256, 256]},
)

SET_CONFIG = Config(
    name="set",
    summary="a network over sets of moves, for any number of targets, budget and duration",
    policy="set",
    observation="lookahead",
    fields=VARIED,
    steps=2_500_000,
    rollout=128,
    batch=2048,
    learning_rate=3e-4,
    entropy=0.0,
    # So that the best chain is nearly always followed: what is learned is then about the missions
    # that are decoded, not about those in which the policy trips over its own noise.
    network={"width": 64, "rounds": 2, "lead": 25.0},
)

SET_TRANSFER_CONFIG = Config(
    name="set-transfer",
    summary="the set network without chains: quicker to ask, and behind in the end",
    policy="set",
    observation="transfer",
    fields=VARIED,
    steps=6_000_000,
    network={"width": 64, "rounds": 2},
)

CONFIGS = {config.name: config for config in (SET_CONFIG, SET_TRANSFER_CONFIG, PUBLISHED_CONFIG)}
"""The configurations by name."""


def config(name: str) -> Config:
    """The configuration with a name.

    Raises
    ------
    InputError
        There is none; the sentence lists them.
    """
    if name not in CONFIGS:
        raise InputError(f"config {name!r} is unknown; use one of: {', '.join(CONFIGS)}")
    return CONFIGS[name]
