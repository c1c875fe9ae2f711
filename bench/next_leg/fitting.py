"""Fitting the network to judged decisions, in PyTorch."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
import torch

from .imitation import Decision
from .network import NextLegNetwork, stacked

TEMPERATURE = 0.3
"""Difference of worths, in mean prizes, that counts e-fold in what is imitated."""

RATE, BATCH, DECAY = 2e-3, 256, 1e-4


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
    inputs = stacked([each.seen for each in decisions])
    worth = torch.from_numpy(np.stack([each.worth for each in decisions]))
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
            logs = torch.log_softmax(network(*(each[rows] for each in inputs)), dim=1)
            loss = -(wanted[rows] * logs).sum(1).mean()
            optimiser.zero_grad()
            loss.backward()
            optimiser.step()
            schedule.step()
    with torch.no_grad():
        chosen = network(*(each[cut:] for each in inputs))
        chosen = chosen.masked_fill(~judged[cut:], -1e9).argmax(1, keepdim=True)
        regret = lost[cut:].gather(1, chosen)
    return Fitted(float((regret < 1e-6).float().mean()), float(regret.mean()))
