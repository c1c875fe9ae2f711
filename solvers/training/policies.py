"""Policies for MaskablePPO (sb3-contrib)."""

from __future__ import annotations

from typing import Any

import torch
from gymnasium import spaces
from sb3_contrib.common.maskable.distributions import (
    MaskableCategoricalDistribution,
    MaskableDistribution,
)
from sb3_contrib.common.maskable.policies import MaskableActorCriticPolicy
from stable_baselines3.common.torch_layers import FlattenExtractor
from torch import Tensor, nn

from adr_opt.kernels.episodes.lookahead import CHAIN_FIELDS, LEAD, PROMISE
from adr_opt.kernels.episodes.observation import IS_OPEN, IS_STATION, MISSION_FIELDS, MOVE_FIELDS
from adr_opt.learning.episodes.board import MISSION, MOVES


class SetNetwork(nn.Module):
    """Encoder, rounds of pooling, pointer head and value head.

    Parameters
    ----------
    fields : int
        Numbers that describe a move in the observation.
    width : int
        Numbers that describe a move inside the network.
    rounds : int
        Rounds of pooling, in which every move sees the whole.
    lead : float
        Weight in the scores, at first, of the best chain's lead in the observation ``lookahead``:
        training begins with a policy that follows the best chain, instead of a random one.
    """

    def __init__(self, fields: int, width: int = 64, rounds: int = 2, lead: float = 8.0) -> None:
        super().__init__()
        self.enter = nn.Linear(fields, width)
        self.mission = nn.Linear(len(MISSION_FIELDS), width)
        self.encode = nn.Linear(width, width)
        self.share = nn.ModuleList(nn.Linear(2 * width, width) for _ in range(rounds))
        self.mix = nn.ModuleList(nn.Linear(width, width) for _ in range(rounds))
        self.score = nn.Linear(width, 1)
        self.judge = nn.Sequential(
            nn.Linear(3 * width, width), nn.ReLU(), nn.Linear(width, width), nn.ReLU()
        )
        self.value = nn.Linear(width, 1)
        # The chains come last, whether prizes are seen or not.
        self.has_chains = fields >= len(MOVE_FIELDS) + len(CHAIN_FIELDS)
        self.chains = fields - len(CHAIN_FIELDS)
        self.lead = nn.Parameter(torch.tensor(lead))
        # The value begins as what the best chain promises, in tens of mean prizes, which is the
        # unit of the rewards: the rest is what a policy gains on it, small and soon learned.
        self.promise = nn.Parameter(torch.tensor(1.0))
        # Orthogonal weights, a first policy that is nearly uniform and a first value near 0
        # are what actor-critic training starts from.
        for module in self.modules():
            if isinstance(module, nn.Linear):
                nn.init.orthogonal_(module.weight, 2.0**0.5)
                nn.init.zeros_(module.bias)
        nn.init.orthogonal_(self.score.weight, 0.01)
        nn.init.orthogonal_(self.value.weight, 0.1)

    def forward(self, moves: Tensor, mission: Tensor) -> tuple[Tensor, Tensor]:
        """Scores and value of a batch of states.

        Parameters
        ----------
        moves : (batch, actions, fields)
        mission : (batch, len(MISSION_FIELDS))

        Returns
        -------
        scores : (batch, actions)
            Not masked: those of illegal moves mean nothing.
        value : (batch,)
            Prizes still to come, in units of the training's reward.
        """
        present = torch.maximum(moves[..., IS_OPEN], moves[..., IS_STATION]).unsqueeze(-1)
        count = present.sum(dim=1).clamp(min=1.0)
        whole = self.mission(mission)
        h = torch.relu(self.enter(moves) + whole.unsqueeze(1))
        h = torch.relu(self.encode(h)) * present
        for share, mix in zip(self.share, self.mix, strict=True):
            pooled = torch.cat([h.sum(dim=1) / count, h.amax(dim=1)], dim=-1)
            h = torch.relu(h + mix(h) + share(pooled).unsqueeze(1)) * present
        scores = self.score(h).squeeze(-1)
        if self.has_chains:
            scores = scores + self.lead * moves[..., self.chains + LEAD]
        pooled = torch.cat([h.sum(dim=1) / count, h.amax(dim=1), torch.relu(whole)], dim=-1)
        value = self.value(self.judge(pooled)).squeeze(-1)
        if self.has_chains:
            value = value + self.promise * moves[..., self.chains + PROMISE].amax(dim=1)
        return scores, value


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
