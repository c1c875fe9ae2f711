"""Evaluation on held-out fields during a training run."""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt
import torch
from stable_baselines3.common.utils import obs_as_tensor

from adr_opt.kernels.episodes import episodes as kernels
from adr_opt.learning.environment.fields import Limits
from adr_opt.learning.episodes import Board, FieldPool, new_episodes, start
from adr_opt.mission.mission import Mission
from adr_opt.sources.generator import family, generate

HELD_SEED, HELD_FIELDS = 900_000, 24
"""First seed and number of the held-out fields: not in the library, and never trained on."""

FAMILIES = ("nominal", "reduced-time", "reduced-fuel")


class HeldFields:
    """Held-out fields with timetables, one pool for the three benchmark families.

    Parameters
    ----------
    observation : str
        What the policy sees.
    """

    def __init__(self, observation: str) -> None:
        self._observation = observation
        missions = [
            Mission(generate("nominal", HELD_SEED + number), threads=1)
            for number in range(HELD_FIELDS)
        ]
        events = max(mission.timetable.most_events for mission in missions)
        self._bodies = len(missions[0].names)
        self.pool = FieldPool(HELD_FIELDS, self._bodies, events)
        for slot, mission in enumerate(missions):
            self.pool.install(slot, mission)

    def evaluate(self, policy: Any, device: torch.device | str = "cpu") -> dict[str, float]:
        """Mean visits in each family, with the best move at every step.

        Parameters
        ----------
        policy : MaskableActorCriticPolicy
        """
        games = []
        for name in FAMILIES:
            limits = Limits(family(name).delta_v_m_s, family(name).duration_s)
            games += [(slot, limits) for slot in range(HELD_FIELDS)]

        def choose(board: Board) -> npt.NDArray[np.int64]:
            with torch.no_grad():
                # Not ``predict``: it insists on the number of targets of the training.
                distribution = policy.get_distribution(
                    obs_as_tensor(board.arrays, torch.device(device)), board.mask
                )
                actions = distribution.get_actions(deterministic=True)
            chosen: npt.NDArray[np.int64] = actions.cpu().numpy()
            return chosen

        serviced = np.zeros(len(games))
        episodes = new_episodes(len(games), self._bodies)
        for index, (slot, limits) in enumerate(games):
            start(self.pool, episodes, index, slot, limits.delta_v_m_s, limits.duration_s)
        running = np.arange(len(games))
        while True:
            board = Board(self._observation, running.size, self._bodies - 1)
            board.observe(self.pool.arrays, episodes, 0, running.size)
            alive = board.legal > 0
            if not alive.all():
                serviced[running[~alive]] = episodes.serviced[~alive]
                running = running[alive]
                episodes = kernels.Episodes(*(part[alive].copy() for part in episodes))
                if not running.size:
                    break
                continue
            rewards = np.zeros(running.size, dtype=np.float32)
            kernels.act(self.pool.arrays, episodes, 0, running.size, choose(board), rewards)
        means = serviced.reshape(len(FAMILIES), HELD_FIELDS).mean(axis=1)
        return dict(zip(FAMILIES, means.tolist(), strict=True))
