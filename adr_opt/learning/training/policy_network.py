"""The network of the policy in PyTorch, and the same under MaskablePPO of sb3-contrib (``[rl]``).

A state is a set of tokens, its cheapest choices. Weights are shared by all of them, so that they
fit any number of targets; attention between tokens knows how their orbits lie to each other.
:mod:`...kernels.episodes.set_scores` is the same, compiled.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import torch
from gymnasium import spaces
from sb3_contrib.common.maskable.distributions import (
    MaskableCategoricalDistribution,
    MaskableDistribution,
)
from sb3_contrib.common.maskable.policies import MaskableActorCriticPolicy
from stable_baselines3.common.torch_layers import FlattenExtractor
from torch import Tensor, nn

from ...kernels.episodes.choices import (
    ANGLE_FROM_CHASER,
    CHOICE_FIELDS,
    COST,
    IS_OPEN,
    IS_STATION,
    LEGAL,
    PHASE,
)
from ...kernels.episodes.set_scores import (
    CONTEXT,
    EQUAL,
    HEADS,
    LAST,
    PLACE,
    PLACE_WIDTH,
    PLACES,
    TOKENS,
    UNSEEN,
)
from ..episodes.board import MISSION, MOVES

FAR_AWAY = 1e4
"""Subtracted from the attention to tokens that are not there."""


class SetNetwork(nn.Module):
    """Encoder of tokens, layers of attention, scores of tokens and value of the state.

    Parameters
    ----------
    width : int
        Numbers that describe a token inside the network.
    layers : int
        Number of layers of attention.
    """

    def __init__(self, width: int = 48, layers: int = 2) -> None:
        super().__init__()
        self.width, self.layers = width, layers
        self.token = nn.Linear(len(CHOICE_FIELDS), width)
        self.context = nn.Linear(CONTEXT, width)
        self.encode = nn.Linear(width, width)
        for layer in range(layers):
            self.add_module(f"norm_{layer}", nn.LayerNorm(width))
            self.add_module(f"attend_{layer}", nn.Linear(width, 3 * width))
            self.add_module(f"place_{layer}", nn.Linear(PLACE, 2 * HEADS * PLACE_WIDTH))
            nn.init.normal_(self._at("place", layer).weight, std=0.1)
            self.add_module(f"merge_{layer}", nn.Linear(width, width))
            self.add_module(f"then_{layer}", nn.LayerNorm(width))
            self.add_module(f"widen_{layer}", nn.Linear(width, 2 * width))
            self.add_module(f"narrow_{layer}", nn.Linear(2 * width, width))
            # Layers begin by adding little.
            nn.init.normal_(self._at("merge", layer).weight, std=0.02)
            nn.init.normal_(self._at("narrow", layer).weight, std=0.02)
        self.head = nn.Linear(2 * width, width)
        self.score = nn.Linear(width, 1)
        self.judge = nn.Sequential(
            nn.Linear(3 * width, width), nn.ReLU(), nn.Linear(width, width), nn.ReLU()
        )
        self.value = nn.Linear(width, 1)
        # A first policy that is nearly uniform and a first value near 0.
        nn.init.orthogonal_(self.score.weight, 0.01)
        nn.init.orthogonal_(self.value.weight, 0.1)

    def _at(self, name: str, layer: int) -> Any:
        return getattr(self, f"{name}_{layer}")

    def forward(self, moves: Tensor, mission: Tensor) -> tuple[Tensor, Tensor]:
        """Scores and value of a batch of states.

        Parameters
        ----------
        moves : (batch, actions, fields)
        mission : (batch, len(MISSION_FIELDS))

        Returns
        -------
        scores : (batch, actions)
            Not masked; :data:`.set_scores.UNSEEN` where a choice is none of the tokens.
        value : (batch,)
            Prizes still to come, in units of the training's reward.
        """
        legal, is_station = moves[..., LEGAL], moves[..., IS_STATION]
        key = (moves[..., COST] + EQUAL * moves[..., ANGLE_FROM_CHASER]) * (1.0 - is_station)
        there = torch.maximum(moves[..., IS_OPEN], is_station)
        key = key + LAST * (3.0 - legal - moves[..., IS_OPEN] - there)
        kept = key.topk(min(TOKENS, key.shape[1]), largest=False).indices
        x = moves.gather(1, kept.unsqueeze(-1).expand(-1, -1, moves.shape[-1]))
        open_targets = (moves[..., IS_OPEN] * (1.0 - is_station)).unsqueeze(-1)
        count = open_targets.sum(1).clamp(min=1.0)
        mean = (moves * open_targets).sum(1) / count
        spread = (((moves - mean.unsqueeze(1)) * open_targets).square().sum(1) / count).sqrt()
        whole = self.context(torch.cat([mission, mean, spread], dim=-1))
        present = torch.maximum(x[..., IS_OPEN], x[..., IS_STATION])
        h = self.encode(torch.relu(self.token(x) + whole.unsqueeze(1)))
        place = self._place(x)
        hidden = ((1.0 - present) * FAR_AWAY).view(len(x), 1, 1, -1)
        for layer in range(self.layers):
            split = self._at("attend", layer)(self._at("norm", layer)(h))
            q, k, v = split.view(*x.shape[:2], 3, HEADS, -1).permute(2, 0, 3, 1, 4)
            here = self._at("place", layer)(place)
            here, away = here.view(*x.shape[:2], 2, HEADS, -1).permute(2, 0, 3, 1, 4)
            q = torch.cat([q * (HEADS / self.width) ** 0.5, here], dim=-1)
            near = q @ torch.cat([k, away], dim=-1).transpose(-1, -2) - hidden
            seen = (near.softmax(-1) @ v).transpose(1, 2).reshape(h.shape)
            h = h + self._at("merge", layer)(seen)
            wide = torch.relu(self._at("widen", layer)(self._at("then", layer)(h)))
            h = h + self._at("narrow", layer)(wide)
        weight = present.unsqueeze(-1)
        pooled = (h * weight).sum(1) / weight.sum(1).clamp(min=1.0)
        beside = (pooled + whole).unsqueeze(1).expand_as(h)
        found = self.score(torch.relu(self.head(torch.cat([h, beside], dim=-1)))).squeeze(-1)
        scores = torch.full_like(key, UNSEEN).scatter(1, kept, found)
        most = (h - FAR_AWAY * (1.0 - weight)).amax(1)
        value = self.value(self.judge(torch.cat([pooled, most, torch.relu(whole)], dim=-1)))
        return scores, value.squeeze(-1)

    def _place(self, x: Tensor) -> Tensor:
        """Where orbits of tokens lie: products of two hold their distance, and their phase."""
        place, phase = x[..., list(PLACES)], x[..., PHASE : PHASE + 1] * math.pi
        square = place.square().sum(-1, keepdim=True)
        return torch.cat([place, square, phase.sin(), phase.cos()], dim=-1)

    def arrays(self) -> dict[str, np.ndarray]:
        """Weights by name, as :class:`..policy.Policy` takes them."""
        return {
            name: tensor.detach().cpu().numpy()
            for name, tensor in self.state_dict().items()
            if not name.startswith(("judge.", "value."))
        }


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
    width, layers
        See :class:`SetNetwork`.
    """

    def __init__(
        self,
        observation_space: spaces.Space[Any],
        action_space: spaces.Discrete,
        lr_schedule: Any,
        *args: Any,
        width: int = 48,
        layers: int = 2,
        **kwargs: Any,
    ) -> None:
        self._shape: dict[str, Any] = {"width": width, "layers": layers}
        kwargs["features_extractor_class"] = _AsItIs
        super().__init__(observation_space, action_space, lr_schedule, *args, **kwargs)

    def _build(self, lr_schedule: Any) -> None:
        # The base class's own heads are not built: the network has both.
        self.network = SetNetwork(**self._shape)
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
