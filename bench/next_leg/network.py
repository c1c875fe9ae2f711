"""The network of :mod:`adr_opt.learning.next_leg.scorer` in PyTorch, for training."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import torch
from torch import nn

from adr_opt.learning.next_leg.features import LEG_FEATURES, MISSION_FEATURES
from adr_opt.learning.next_leg.scorer import ScorerLayers

from .flights import Seen


class NextLegNetwork(nn.Module):
    """Scores of legs.

    Parameters
    ----------
    width : int
        Hidden units.
    """

    def __init__(self, width: int) -> None:
        super().__init__()
        self.leg = nn.Linear(LEG_FEATURES, width)
        self.mission = nn.Linear(MISSION_FEATURES, width, bias=False)
        self.inner = nn.Linear(width, width)
        self.own = nn.Linear(width, width)
        self.mean = nn.Linear(width, width, bias=False)
        self.most = nn.Linear(width, width, bias=False)
        self.out = nn.Linear(width, 1, bias=False)

    def forward(
        self, legs: torch.Tensor, mission: torch.Tensor, there: torch.Tensor
    ) -> torch.Tensor:
        """Scores, −1e9 where there is no leg, shape (decisions, slots)."""
        hidden = torch.relu(self.leg(legs) + self.mission(mission)[:, None, :])
        codes = torch.relu(self.inner(hidden))
        mask = there[:, :, None]
        mean = (codes * mask).sum(1) / mask.sum(1)
        most = codes.masked_fill(~mask, -1e9).amax(1)
        pooled = self.mean(mean) + self.most(most)
        head = torch.relu(self.own(codes) + pooled[:, None, :])
        return self.out(head)[:, :, 0].masked_fill(~there, -1e9)

    def layers(self) -> ScorerLayers:
        """The weights."""

        def of(tensor: torch.Tensor) -> np.ndarray:
            return tensor.detach().numpy().astype(np.float32)

        return ScorerLayers(
            of(self.leg.weight),
            of(self.mission.weight),
            of(self.leg.bias),
            of(self.inner.weight),
            of(self.inner.bias),
            of(self.own.weight),
            of(self.mean.weight),
            of(self.most.weight),
            of(self.own.bias),
            of(self.out.weight[0]),
        )

    @classmethod
    def of(cls, layers: ScorerLayers) -> NextLegNetwork:
        """The network that has some weights."""
        made = cls(layers.bias.size)
        slots = (
            made.leg.weight,
            made.mission.weight,
            made.leg.bias,
            made.inner.weight,
            made.inner.bias,
            made.own.weight,
            made.mean.weight,
            made.most.weight,
            made.own.bias,
            made.out.weight,
        )
        with torch.no_grad():
            for slot, array in zip(slots, layers, strict=True):
                slot.copy_(torch.from_numpy(np.array(array)).reshape(slot.shape))
        return made


def stacked(seen: Sequence[Seen]) -> tuple[torch.Tensor, torch.Tensor, torch.Tensor]:
    """Decisions as the network takes them: legs, missions, and where there is a leg."""
    legs = torch.from_numpy(np.stack([each.legs for each in seen]))
    mission = torch.from_numpy(np.stack([each.mission for each in seen]))
    counts = torch.tensor([each.count for each in seen])
    return legs, mission, torch.arange(legs.shape[1])[None, :] < counts[:, None]
