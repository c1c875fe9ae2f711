"""Decoding of a policy into plans: greedily, by sampling, or as the prior of a search."""

from __future__ import annotations

from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from typing import TypeVar

import numpy as np
import numpy.typing as npt

from ..kernels.episodes import episodes as kernels
from ..kernels.episodes.worlds import WorldStates
from ..mission.mission import Mission
from .episodes import Board, FieldPool, check_playable, new_episodes, playing_time_s, start
from .policy import Policy, log_probabilities

Sequence = npt.NDArray[np.int64]
Found = Callable[[Sequence], object]
"""Callback for every plan, as a sequence of bodies."""

Enough = Callable[[], bool]

Part = TypeVar("Part", kernels.Episodes, WorldStates)

LEAST_PART = 8
"""Number of episodes up to which another thread does not pay."""


class Field:
    """A mission as a field for episodes.

    Parameters
    ----------
    mission : Mission
    policy : Policy
    threads : int
        Threads that work out what the policy sees of many episodes.

    Raises
    ------
    InputError
        A mission that episodes cannot play.
    """

    def __init__(self, mission: Mission, policy: Policy, threads: int = 1) -> None:
        check_playable(mission)
        self.mission, self.policy = mission, policy
        self._threads = threads
        self.targets = len(mission.names) - 1
        self._budget = mission.instance.chaser.tank.delta_v_m_s - mission.reserve_m_s
        self._duration_s = playing_time_s(mission.instance)
        self.pool = FieldPool.of(mission)
        self._alone = self.begin(1)

    def begin(self, count: int) -> kernels.Episodes:
        """``count`` episodes at the start of the mission."""
        episodes = new_episodes(count, self.targets + 1)
        for index in range(count):
            start(self.pool, episodes, index, 0, self._budget, self._duration_s)
        return episodes

    def judged(self, episodes: kernels.Episodes) -> tuple[npt.NDArray[np.float32], Board]:
        """Scores of the policy, (episodes, actions), and the board that they follow from."""
        count = episodes.slot.size
        board = Board("choices", count, self.targets)
        seen = board.choices

        def judge(first: int, last: int) -> npt.NDArray[np.float32]:
            board.observe(self.pool.arrays, episodes, first, last)
            return self.policy.scores(seen.moves[first:last], seen.mission[first:last])

        parts = max(1, min(self._threads, count // LEAST_PART))
        edges = np.linspace(0, count, parts + 1).astype(int).tolist()
        if parts == 1:
            return judge(0, count), board
        with ThreadPoolExecutor(parts) as pool:
            return np.concatenate(list(pool.map(judge, edges[:-1], edges[1:]))), board

    def moves(
        self, body: int, time: float, left: float, since_refuel: int, visited: npt.NDArray[np.bool_]
    ) -> Sequence:
        """Legal moves of a state as bodies, in the policy's order of preference.

        Parameters
        ----------
        body : int
            Where the chaser is.
        time, left : float
            When it became free to leave [s]; ΔV left [m/s].
        since_refuel : int
            Targets serviced since it last refuelled.
        visited : (bodies,) bool
        """
        episode = self._alone
        episode.body[0], episode.time[0], episode.left[0] = body, time, left
        episode.since[0] = since_refuel
        episode.visited[0, : visited.size] = visited
        scores, board = self.judged(episode)
        actions = np.argsort(-scores[0], kind="stable")[: board.legal[0]]
        return np.array([kernels.body_of(a, self.targets) for a in actions], dtype=np.int64)


def pick(of: Part, rows: npt.NDArray[np.int64]) -> Part:
    """Copies of some episodes or of their worlds, in the order of ``rows``, which may repeat."""
    return type(of)(*(np.ascontiguousarray(part[rows]) for part in of))


def play(
    field: Field,
    count: int,
    found: Found,
    rng: np.random.Generator | None = None,
    temperature: float = 1.0,
) -> None:
    """Play ``count`` missions to their end side by side.

    Parameters
    ----------
    found : callable
        Called with every plan.
    rng : Generator, optional
        Draws moves by their probability; without it the best move is made.
    temperature : float
        Divides the scores before sampling.
    """
    episodes, made = field.begin(count), [list[int]() for _ in range(count)]
    running = np.arange(count)
    rewards = np.zeros(count, dtype=np.float32)
    while running.size:
        scores, board = field.judged(episodes)
        alive = board.legal > 0
        for row in running[~alive]:
            found(np.array(made[row], dtype=np.int64))
        if not alive.all():
            running, scores = running[alive], scores[alive]
            episodes = pick(episodes, np.flatnonzero(alive))
        if rng is not None:
            # The best sum of log-probability and Gumbel noise is a sample.
            scores = log_probabilities(scores, temperature)
            scores += rng.gumbel(size=scores.shape).astype(np.float32)
        actions = scores.argmax(axis=1)
        kernels.act(field.pool.arrays, episodes, 0, running.size, actions, rewards)
        for row, action in zip(running.tolist(), actions.tolist(), strict=True):
            made[row].append(int(kernels.body_of(action, field.targets)))
