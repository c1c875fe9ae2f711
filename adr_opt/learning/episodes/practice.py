"""A short practice run on a small mission, which compiles the environment's kernels."""

from __future__ import annotations

import numpy as np

from ...kernels.episodes import episodes as kernels
from ...kernels.episodes import worlds as world_kernels
from ...problem.uncertainty import CaptureUncertainty, Uncertainty
from ...run.warm_up import practice_mission
from .board import OBSERVATIONS, Board, sees_worlds
from .pool import FieldPool, new_episodes, playing_time_s, start
from .worlds import UncertainPool, begin_in_worlds, new_worlds


def practise() -> None:
    """Compile the kernels called by both environments, with every observation."""
    for drifts in (False, True):
        mission = practice_mission(drifts)
        bodies, budget = len(mission.names), mission.chaser.tank.delta_v_m_s
        duration_s = playing_time_s(mission.instance)
        pool, episodes = FieldPool.of(mission), new_episodes(1, bodies)
        which, slots = np.zeros(1, dtype=np.int32), np.zeros(1, dtype=np.int64)
        rewards = np.zeros(1, dtype=np.float32)
        uncertain = UncertainPool(pool, [Uncertainty(capture=CaptureUncertainty(success=0.5))])
        uncertain.install(0)
        worlds = new_worlds(uncertain, 1)
        for name in OBSERVATIONS:
            board = Board(name, 1, bodies - 1)
            start(pool, episodes, 0, 0, budget, duration_s)
            board.observe(pool.arrays, episodes, 0, 1)
            actions = board.mask.argmax(axis=1)
            kernels.act(pool.arrays, episodes, 0, 1, actions, rewards)
            kernels.act(pool.arrays, episodes, 0, 1, actions, rewards, board.order)
            kernels.body_of(int(actions[0]), bodies - 1)
            limits = np.array([budget]), np.array([duration_s])
            kernels.begin_many(pool.arrays, episodes, which, slots, *limits)
            board.observe_these(pool.arrays, episodes, which)
            if sees_worlds(name):
                begin_in_worlds(pool, episodes, worlds, which, (slots, slots))
                board.observe(pool.arrays, episodes, 0, 1, worlds)
                board.observe_these(pool.arrays, episodes, which, worlds)
                taken = 0, 1, actions, rewards, board.order
                world_kernels.act_in_worlds(pool.arrays, episodes, worlds, *taken)
