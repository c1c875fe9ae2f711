"""PPO over the network's choice among legs, in rehearsals as they are drawn.

Each mission is flown several times in one world by choices that are drawn, and what a flight
collects less the mean of the others is its advantage: a baseline without a second network. Weights
follow the clipped objective of Schulman et al., "Proximal policy optimization algorithms",
arXiv 1707.06347, eq. 7.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import numpy.typing as npt
import torch

from adr_opt.analysis.rehearse.flight import Halt, Situation
from adr_opt.analysis.rehearse.mission_facts import Hop
from adr_opt.learning.next_leg.scorer import LegScorer

from . import flights
from .drawn import drawn_instance, drawn_uncertainty
from .flights import SLOTS, InTraining, Kept, Scores, Seen
from .imitation import MOST_PLANNED
from .network import NextLegNetwork, stacked

FLIGHTS = 8
"""Flights of a mission in one world."""

SHARPNESS = 2.0
"""Factor on scores: the chances of choices are the softmax of their product."""

PLANNED, PLAN_WIDTH = 0.4, 16
"""Share of missions that begin with a plan, and the width of the beam that makes it."""

CLIPPED, EPOCHS, BATCH, RATE = 0.2, 3, 512, 3e-4

LARGEST = 3.0
"""Bound on advantages [mean prizes]."""


class Step(NamedTuple):
    """A drawn choice.

    Attributes
    ----------
    seen : Seen
    allowed : (SLOTS,) bool
        Legs that were not refused before it: those that may not begin, or leave no way back.
    chosen : int
    log_chance : float
        Of it among the allowed ones.
    """

    seen: Seen
    allowed: npt.NDArray[np.bool_]
    chosen: int
    log_chance: float


class Drawing(InTraining):
    """The policy with choices drawn by their chances."""

    def __init__(self, mission: Kept, scorer: LegScorer, rng: np.random.Generator) -> None:
        super().__init__(mission, scorer)
        self._rng = rng
        self._drawn: tuple[Seen, Scores, Scores] | None = None
        self.steps: list[Step] = []

    def chosen_by(self, now: Situation, seen: Seen, scores: Scores) -> Scores:
        """Scores with random parts by which the largest one is drawn by the softmax."""
        drawn = SHARPNESS * scores + self._rng.gumbel(size=scores.size).astype(np.float32)
        self._drawn = seen, scores, drawn
        return drawn

    def next_leg(self, now: Situation) -> Hop | Halt:
        """The leg drawn, which is kept."""
        self._drawn = None
        found = super().next_leg(now)
        if self._drawn is None or not isinstance(found, Hop):
            return found
        seen, scores, drawn = self._drawn
        at = np.flatnonzero(seen.bodies == found.destination)
        if at.size and seen.count > 1:
            chosen = int(at[0])
            allowed = np.zeros(SLOTS, dtype=np.bool_)
            allowed[: seen.count] = drawn <= drawn[chosen]
            logits = SHARPNESS * scores[allowed[: seen.count]].astype(np.float64)
            most = logits.max()
            chance = SHARPNESS * float(scores[chosen]) - most - np.log(np.exp(logits - most).sum())
            self.steps.append(Step(seen, allowed, chosen, float(chance)))
        return found


class Flown(NamedTuple):
    """Drawn choices with their advantages, and the mean of what flights collect [mean prizes]."""

    steps: list[Step]
    advantages: list[float]
    mean: float


def flown(missions: int, variant: str, rng: np.random.Generator, scorer: LegScorer) -> Flown:
    """Drawn missions, flown several times each."""
    steps, advantages, means = list[Step](), list[float](), []
    for _ in range(missions):
        instance, uncertainty = drawn_instance(rng, variant), drawn_uncertainty(rng)
        with_plan = len(instance.targets) <= MOST_PLANNED and rng.random() < PLANNED
        with_plan = with_plan and len(instance.chasers) == 1
        mission = flights.kept(instance, uncertainty, width=PLAN_WIDTH if with_plan else 0)
        prizes = [prize for prize in mission.facts.prizes.values() if prize > 0.0]
        world, made, collected = int(rng.integers(2**31)), [], []
        for _ in range(FLIGHTS):
            policy = Drawing(mission, scorer, rng)
            collected.append(flights.collected(mission, policy, world)[1] / np.mean(prizes))
            made.append(policy.steps)
        for own, taken in zip(collected, made, strict=True):
            others = (sum(collected) - own) / (FLIGHTS - 1)
            steps += taken
            advantages += [float(np.clip(own - others, -LARGEST, LARGEST))] * len(taken)
        means.append(np.mean(collected))
    return Flown(steps, advantages, float(np.mean(means)))


def improve(network: NextLegNetwork, optimiser: torch.optim.Optimizer, done: Flown) -> float:
    """Let the weights follow the clipped objective; the share of choices that were clipped."""
    torch.set_num_threads(1)
    inputs = stacked([step.seen for step in done.steps])
    allowed = torch.from_numpy(np.stack([step.allowed for step in done.steps]))
    chosen = torch.tensor([step.chosen for step in done.steps])[:, None]
    before = torch.tensor([step.log_chance for step in done.steps])
    advantage = torch.tensor(done.advantages)
    advantage = advantage / (advantage.std() + 1e-6)
    clipped = []
    for _ in range(EPOCHS):
        for rows in torch.randperm(len(done.steps)).split(BATCH):
            scores = network(*(each[rows] for each in inputs))
            logs = torch.log_softmax((SHARPNESS * scores).masked_fill(~allowed[rows], -1e9), 1)
            ratio = torch.exp(logs.gather(1, chosen[rows])[:, 0] - before[rows])
            bounded = ratio.clamp(1.0 - CLIPPED, 1.0 + CLIPPED)
            gain = torch.minimum(ratio * advantage[rows], bounded * advantage[rows])
            loss = -gain.mean()
            optimiser.zero_grad()
            loss.backward()
            torch.nn.utils.clip_grad_norm_(network.parameters(), 0.5)
            optimiser.step()
            clipped.append(float((ratio != bounded).float().mean()))
    return float(np.mean(clipped))
