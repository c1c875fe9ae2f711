"""Fields held back from training, and what a policy collects there."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import numpy.typing as npt

from ..kernels.episodes import episodes as kernels
from ..mission.mission import Mission
from ..sources.generator import family, generate
from .decoding import pick
from .episodes import Board, FieldPool, new_episodes, start

FAMILIES = ("nominal", "reduced-time", "reduced-fuel")

HELD_SEED, HELD_FIELDS = 900_000, 24
"""First seed and number of the fields by which trainings are watched."""


class HeldFields:
    """Fields with their timetables, one pool for the three benchmark families.

    Parameters
    ----------
    first, count : int
        First seed, and number.
    """

    def __init__(self, first: int = HELD_SEED, count: int = HELD_FIELDS) -> None:
        missions = [Mission(generate("nominal", first + at), threads=1) for at in range(count)]
        events = max(mission.timetable.most_events for mission in missions)
        self._bodies, self._count = len(missions[0].names), count
        self.pool = FieldPool(count, self._bodies, events)
        for slot, mission in enumerate(missions):
            self.pool.install(slot, mission)

    def visits(
        self, choose: Callable[[Board], npt.NDArray[np.int64]], observation: str = "choices"
    ) -> dict[str, npt.NDArray[np.int32]]:
        """Visits on each field in each family, with the moves that are chosen.

        Parameters
        ----------
        choose : callable
            Actions of a board.
        observation : str
        """
        episodes = new_episodes(len(FAMILIES) * self._count, self._bodies)
        for at, name in enumerate(np.repeat(FAMILIES, self._count).tolist()):
            limits = family(name)
            given = limits.delta_v_m_s, limits.duration_s
            start(self.pool, episodes, at, at % self._count, *given)
        running, serviced = np.arange(episodes.slot.size), np.zeros_like(episodes.serviced)
        while running.size:
            board = Board(observation, running.size, self._bodies - 1)
            board.observe(self.pool.arrays, episodes, 0, running.size)
            alive = board.legal > 0
            serviced[running] = episodes.serviced
            if alive.all():
                rewards = np.zeros(running.size, dtype=np.float32)
                actions = choose(board)
                kernels.act(self.pool.arrays, episodes, 0, running.size, actions, rewards)
            else:
                running, episodes = running[alive], pick(episodes, np.flatnonzero(alive))
        return dict(zip(FAMILIES, serviced.reshape(len(FAMILIES), -1), strict=True))

    def means(
        self, choose: Callable[[Board], npt.NDArray[np.int64]], observation: str = "choices"
    ) -> dict[str, float]:
        """Mean visits in each family."""
        return {name: float(of.mean()) for name, of in self.visits(choose, observation).items()}
