"""Fitting the network to judged decisions, in PyTorch."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
import torch
from torch import nn

from adr_opt.learning.next_leg.features import LEG_FEATURES, MISSION_FEATURES
from adr_opt.learning.next_leg.scorer import ScorerLayers

from .walks import Decision

TEMPERATURE = 0.3
"""Difference of worths, in mean prizes, that counts e-fold in what is imitated."""

RATE, BATCH, DECAY = 2e-3, 256, 1e-4


class NextLegNetwork(nn.Module):
    """The network of :mod:`adr_opt.learning.next_leg.scorer`, for training."""

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
        """Scores, −inf where there is no leg, shape (decisions, slots)."""
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
            of(self.leg.weight), of(self.mission.weight), of(self.leg.bias),
            of(self.inner.weight), of(self.inner.bias), of(self.own.weight), of(self.mean.weight),
            of(self.most.weight), of(self.own.bias), of(self.out.weight[0]),
        )  # fmt: skip


class Fitted(NamedTuple):
    """How a network fits decisions that it was not fitted to.

    Attributes
    ----------
    agreement : float
        Share of decisions in which it chooses one of the best moves.
    regret : float
        Mean loss of its choices among judged moves [mean prizes].
    """

    agreement: float
    regret: float


def fit(network: NextLegNetwork, decisions: Sequence[Decision], epochs: int, seed: int) -> Fitted:
    """Fit a network to nine tenths of decisions; the last tenth judges it."""
    torch.manual_seed(seed)
    torch.set_num_threads(1)
    legs = torch.from_numpy(np.stack([each.legs for each in decisions]))
    mission = torch.from_numpy(np.stack([each.mission for each in decisions]))
    counts = torch.tensor([each.count for each in decisions])
    worth = torch.from_numpy(np.stack([each.worth for each in decisions]))
    there = torch.arange(legs.shape[1])[None, :] < counts[:, None]
    judged = torch.isfinite(worth)
    best = worth.masked_fill(~judged, -1e9).amax(1, keepdim=True)
    lost = (best - torch.nan_to_num(worth)).clamp(0.0, 5.0)
    wanted = torch.softmax((-lost / TEMPERATURE).masked_fill(~judged, -1e9), dim=1)
    cut = int(0.9 * len(decisions))
    optimiser = torch.optim.AdamW(network.parameters(), lr=RATE, weight_decay=DECAY)
    steps = epochs * (cut // BATCH + 1)
    schedule = torch.optim.lr_scheduler.OneCycleLR(optimiser, RATE, total_steps=steps)
    for _ in range(epochs):
        for rows in torch.randperm(cut).split(BATCH):
            scores = network(legs[rows], mission[rows], there[rows])
            logs = torch.log_softmax(scores, dim=1)
            loss = -(wanted[rows] * logs).sum(1).mean()
            optimiser.zero_grad()
            loss.backward()
            optimiser.step()
            schedule.step()
    with torch.no_grad():
        held = slice(cut, None)
        chosen = network(legs[held], mission[held], there[held])
        chosen = chosen.masked_fill(~judged[held], -1e9).argmax(1, keepdim=True)
        regret = lost[held].gather(1, chosen)
    return Fitted(float((regret < 1e-6).float().mean()), float(regret.mean()))
