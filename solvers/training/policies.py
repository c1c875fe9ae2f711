"""Policies for MaskablePPO (sb3-contrib)."""

from __future__ import annotations

from typing import Any

from gymnasium import spaces
from sb3_contrib.common.maskable.distributions import (
    MaskableCategoricalDistribution,
    MaskableDistribution,
)
from sb3_contrib.common.maskable.policies import MaskableActorCriticPolicy
from stable_baselines3.common.torch_layers import FlattenExtractor
from torch import Tensor

from adr_opt.learning.episodes.board import MISSION, MOVES

from .network import SetNetwork


class _AsItIs(FlattenExtractor):
    """Passes the observation on to the network unchanged."""

    def __init__(self, observation_space: spaces.Space[Any]) -> None:
        super().__init__(observation_space)

    def forward(self, observations: Tensor) -> Tensor:
        """Return the observation."""
        return observations


class SetPolicy(MaskableActorCriticPolicy):
    """MaskablePPO policy around :class:`SetNetwork`, for any number of targets.

    Parameters
    ----------
    width, rounds, lead
        See :class:`SetNetwork`.
    """

    def __init__(
        self,
        observation_space: spaces.Space[Any],
        action_space: spaces.Discrete,
        lr_schedule: Any,
        *args: Any,
        width: int = 64,
        rounds: int = 2,
        lead: float = 8.0,
        **kwargs: Any,
    ) -> None:
        self._shape: dict[str, Any] = {"width": width, "rounds": rounds, "lead": lead}
        kwargs["features_extractor_class"] = _AsItIs
        super().__init__(observation_space, action_space, lr_schedule, *args, **kwargs)

    def _build(self, lr_schedule: Any) -> None:
        fields = self.observation_space[MOVES].shape[-1]  # type: ignore[index]
        self.network = SetNetwork(fields, **self._shape)
        # The base class's own heads are not built: the network has both.
        self.optimizer = self.optimizer_class(
            self.parameters(),
            lr=lr_schedule(1),  # type: ignore[call-arg]
            **self.optimizer_kwargs,
        )

    def _judge(
        self, observation: dict[str, Tensor], masks: Any
    ) -> tuple[MaskableDistribution, Tensor]:
        scores, value = self.network(observation[MOVES], observation[MISSION])
        # Not ``self.action_dist``: it insists on the number of actions of the training.
        distribution = MaskableCategoricalDistribution(scores.shape[1]).proba_distribution(scores)
        if masks is not None:
            distribution.apply_masking(masks)
        return distribution, value

    def forward(  # type: ignore[override]
        self, obs: dict[str, Tensor], deterministic: bool = False, action_masks: Any = None
    ) -> tuple[Tensor, Tensor, Tensor]:
        """Actions, values and log-probabilities of a batch of observations."""
        distribution, value = self._judge(obs, action_masks)
        actions = distribution.get_actions(deterministic=deterministic)
        return actions, value, distribution.log_prob(actions)

    def evaluate_actions(  # type: ignore[override]
        self, obs: dict[str, Tensor], actions: Tensor, action_masks: Tensor | None = None
    ) -> tuple[Tensor, Tensor, Tensor | None]:
        """Values, log-probabilities and entropies of actions taken before."""
        distribution, value = self._judge(obs, action_masks)
        return value, distribution.log_prob(actions), distribution.entropy()

    def get_distribution(  # type: ignore[override]
        self, obs: dict[str, Tensor], action_masks: Any = None
    ) -> MaskableDistribution:
        """The distribution over actions."""
        return self._judge(obs, action_masks)[0]

    def predict_values(self, obs: dict[str, Tensor]) -> Tensor:  # type: ignore[override]
        """The values of a batch of observations."""
        value: Tensor = self.network(obs[MOVES], obs[MISSION])[1]
        return value

    def _get_constructor_parameters(self) -> dict[str, Any]:
        return super()._get_constructor_parameters() | self._shape
