"""Two trials of learning: a baseline without a critic, and what perfect multipliers would bring.

python bench/learning_trials.py baselines --seeds 2
python bench/learning_trials.py multipliers --fields 8
"""

from __future__ import annotations

import sys
import time
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import replace
from functools import partial
from pathlib import Path
from statistics import median
from tempfile import TemporaryDirectory
from typing import Any
from unittest.mock import patch

import numpy as np
import torch
from learning import FRESH_SEED
from tables import experiment, head, row
from torch.distributions import Categorical

import adr_opt
from adr_opt.kernels.episodes import episodes as kernels
from adr_opt.learning.decoding import pick
from adr_opt.learning.environment.drawn import DrawnFields
from adr_opt.learning.episodes import Board, FieldPool, new_episodes, start
from adr_opt.learning.evaluation import chosen
from adr_opt.learning.held_out import HeldFields
from adr_opt.learning.policy import Policy
from adr_opt.learning.training.configs import POLICY, PUBLISHED_CONFIG, Config
from adr_opt.learning.training.policy_network import SetNetwork
from adr_opt.learning.training.trainer import train
from adr_opt.mission.mission import Mission
from solvers.proof import proof
from solvers.walks.multipliers import Descent

CLIP, MOST_SLOPE, HIDDEN = 0.2, 0.5, -1e8


def _limits(config: Config) -> tuple[float, float]:
    budgets, durations = config.kinds["nominal"].draw_many_limits(np.random.default_rng(0), 1)
    return float(budgets[0]), float(durations[0])


def rollouts(
    network: SetNetwork, pool: FieldPool, slots: np.ndarray, limits: tuple[float, float]
) -> tuple[list[torch.Tensor], np.ndarray]:
    """Play a mission to its end on each of some slots, with moves drawn by their probability.

    Returns
    -------
    states : list of Tensor
        Of all states: moves, mission, mask, action, log-probability, and number of the mission.
    collected : (missions,) float64
    """
    bodies = pool.arrays.is_station.size
    episodes, told = new_episodes(slots.size, bodies), list[tuple[torch.Tensor, ...]]()
    for at, slot in enumerate(slots.tolist()):
        start(pool, episodes, at, slot, *limits)
    running, collected = np.arange(slots.size), np.zeros(slots.size)
    while running.size:
        board = Board("choices", running.size, bodies - 1)
        board.observe(pool.arrays, episodes, 0, running.size)
        collected[running], alive = episodes.collected, np.flatnonzero(board.legal)
        running, episodes = running[alive], pick(episodes, alive)
        if not running.size:
            break
        state = [
            torch.as_tensor(each[alive])
            for each in (board.choices.moves, board.choices.mission, board.mask)
        ]
        with torch.no_grad():
            policy = _policy(network, *state)
            actions = policy.sample()
        told.append((*state, actions, policy.log_prob(actions), torch.as_tensor(running)))
        rewards = np.zeros(running.size, dtype=np.float32)
        kernels.act(pool.arrays, episodes, 0, running.size, actions.numpy(), rewards)
    return [torch.cat(each) for each in zip(*told, strict=True)], collected


def _policy(network: SetNetwork, moves: Any, mission: Any, mask: Any) -> Categorical:
    return Categorical(logits=network(moves, mission)[0].masked_fill(~mask, HIDDEN))


def without_critic(config: Config, group: int, held: HeldFields, seed: int) -> float:
    """Nominal visits after a training in which missions of one field are each other's baseline.

    The advantage of all moves of a mission is what it collects, less the mean of the ``group``
    missions on its field (POMO, Kwon et al. 2020), in clipped steps of PPO. Fields, missions at
    once, steps, rate and entropy are those of training with a critic; batches do not grow.
    """
    torch.manual_seed(seed)
    torch.set_num_threads(1)
    rng, network = np.random.default_rng(seed), SetNetwork(**config.network)
    # As many fields as a training replaces.
    fields = config.slots + config.steps // config.refresh_every
    pool = DrawnFields(config.kinds["nominal"], fields, seed).pool
    optimiser, done = torch.optim.Adam(network.parameters(), config.rate, eps=1e-5), 0
    while done < config.steps:
        strength = config.strength(done)
        optimiser.param_groups[0]["lr"] = config.rate * strength
        drawn = rng.choice(fields, config.missions // group, replace=False)
        states, collected = rollouts(network, pool, drawn.repeat(group), _limits(config))
        by_field = collected.reshape(-1, group)
        gains = torch.as_tensor((by_field - by_field.mean(1, keepdims=True)).ravel())
        *seen, actions, logs, which = states
        done += len(actions)
        for _ in range(config.epochs):
            for rows in torch.randperm(len(actions)).split(config.batch):
                policy = _policy(network, *(each[rows] for each in seen))
                gain = gains[which[rows]].float()
                gain = (gain - gain.mean()) / (gain.std() + 1e-8)
                ratio = (policy.log_prob(actions[rows]) - logs[rows]).exp()
                loss = -torch.min(ratio * gain, ratio.clamp(1 - CLIP, 1 + CLIP) * gain).mean()
                loss -= config.entropy * strength * policy.entropy().mean()
                optimiser.zero_grad()
                loss.backward()
                torch.nn.utils.clip_grad_norm_(network.parameters(), MOST_SLOPE)
                optimiser.step()
    learned = Policy(network.arrays(), {"name": "without a critic", "dynamics": "two-body"})
    return float(held.visits(partial(chosen, learned), families=("nominal",))["nominal"].mean())


def with_critic(config: Config, held: HeldFields, seed: int) -> float:
    """Nominal visits after the training of the package."""
    told: dict[str, float] = {}

    def report(_: int, means: Mapping[str, float]) -> None:
        told.update(means)

    with TemporaryDirectory() as folder:
        train(config, Path(folder), seed=seed, evaluate_every=10**9, report=report, held_out=held)
    return told["nominal"]


def baselines(
    steps: int = 131_072, seeds: int = 2, groups: tuple[int, ...] = (16,), fields: int = 50
) -> None:
    """A critic beside the mean over missions of one field, at equal steps on nominal fields."""
    config = replace(POLICY, kinds=PUBLISHED_CONFIG.kinds, models=(), steps=steps, slots=48)
    held = HeldFields(FRESH_SEED, fields)
    arms: dict[str, Callable[[int], float]] = {
        f"mean of {group} missions": partial(without_critic, config, group, held)
        for group in groups
    }
    arms["critic"] = partial(with_critic, config, held)
    head("baseline", "seed", "steps", "nominal visits on fresh fields", "seconds of processor")
    for seed in range(1, 1 + seeds):
        for name, learn in arms.items():
            began = time.process_time()
            visits = learn(seed)
            row(name, seed, steps, f"{visits:.2f}", f"{time.process_time() - began:.0f}")


@contextmanager
def _descents(perfect: np.ndarray | None, *, goes_on: bool) -> Iterator[list[Descent]]:
    """Descents of proofs meanwhile, from given multipliers, and perhaps without going on."""
    made = list[Descent]()

    class Given(Descent):
        """Begins with the multipliers that another one ended with."""

        def __init__(self, bound: Any) -> None:
            super().__init__(bound)
            made.append(self)
            if perfect is not None:
                self.multipliers = bound.allowed(perfect.copy())

        def step(self) -> float:
            """One evaluation of the bound."""
            found = super().step()
            self.done = self.done or not goes_on
            return found

    with patch.object(proof, "Descent", Given):
        yield made


MULTIPLIER_SEED = 8_600_000
"""First seed of the fields of :func:`multipliers`."""


def multipliers(*what: str, fields: int = 8, limit: float = 60.0, width: int = 1000) -> None:
    """Proofs from the multipliers that proofs end with: the most that predictions could bring.

    Families; nominal without any. Bounds are ``lagrangian`` from the plan of a beam on one core.
    The first proof of a field begins as usual, others with its last multipliers, and go on to
    better ones or not. Times are of the processor, without the timetable.
    """
    arms = {"as usual": True, "perfect at first": True, "perfect, no others": False}
    names = [f"{name}: bound, evaluations, s" for name in arms]
    head("family", "field", *names, *(f"{name}: times as fast" for name in list(arms)[1:]))
    for family in what or ("nominal",):
        ratios = {name: list[float]() for name in list(arms)[1:]}
        for number in range(-1, fields):  # the first one loads kernels
            mission = Mission(adr_opt.generate(family, MULTIPLIER_SEED + number), threads=1)
            plan = adr_opt.solve(mission, "beam", width=width, time_limit=600.0).plan
            perfect: np.ndarray | None = None
            told, usual_s = list[str](), 0.0
            for name, goes_on in arms.items():
                with _descents(perfect, goes_on=goes_on) as made:
                    began = time.process_time()
                    found = adr_opt.bound(
                        mission, "lagrangian", start=plan, time_limit=limit, jobs=1
                    )
                    spent = time.process_time() - began
                if name in ratios:
                    ratios[name].append(usual_s / spent)
                else:
                    perfect, usual_s = made[-1].multipliers if made else None, spent
                evaluations = found.counters["evaluations"]
                told.append(f"{found.upper_bound:g}, {evaluations:.0f}, {spent:.2f}")
            if number < 0:
                ratios = {name: list[float]() for name in ratios}
                continue
            row(family, mission.instance.name, *told, *(f"{of[-1]:.2f}" for of in ratios.values()))
        medians = (f"{median(of):.2f}" for of in ratios.values())
        row(family, "median", *("" for _ in arms), *medians)


if __name__ == "__main__":
    sys.exit(experiment(__doc__, baselines, multipliers))
