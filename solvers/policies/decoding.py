"""Decoding of a policy into a plan: greedily, or by sampling."""

from __future__ import annotations

import math
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor

import numpy as np
import numpy.typing as npt

from adr_opt.kernels.episodes import episodes as kernels
from adr_opt.kernels.episodes.lookahead import EQUAL_PRIZES
from adr_opt.learning.episodes import (
    Board,
    FieldPool,
    check_playable,
    new_episodes,
    playing_time_s,
    start,
)
from adr_opt.learning.episodes.board import follows_chains
from adr_opt.mission.mission import Mission

from .policy import Policy, log_probabilities
from .promises import FloatArray, follow_chains, promises

Sequence = npt.NDArray[np.int64]
Found = Callable[[Sequence], object]
"""Callback for every plan, as a sequence of bodies."""

Enough = Callable[[], bool]

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
        More targets than the policy was made for, or a mission that episodes cannot play.
    """

    def __init__(self, mission: Mission, policy: Policy, threads: int = 1) -> None:
        targets = len(mission.names) - 1
        policy.check_size(targets)
        check_playable(mission)
        self.mission, self.policy = mission, policy
        self._threads = threads
        # A policy for a fixed number of targets sees the missing ones as bodies that are not there.
        self.targets = policy.targets or targets
        self.budget = mission.instance.chaser.tank.delta_v_m_s - mission.reserve_m_s
        self.duration = playing_time_s(mission.instance)
        self.pool = FieldPool.for_one(mission, self.targets + 1)
        self.pool.install(0, mission)

    @property
    def sees_chains(self) -> bool:
        """Whether the policy's observation includes chains."""
        return follows_chains(self.policy.observation)

    def begin(self, count: int) -> kernels.Episodes:
        """``count`` episodes at the start of the mission."""
        episodes = new_episodes(count, self.targets + 1)
        for index in range(count):
            start(self.pool, episodes, index, 0, self.budget, self.duration)
        return episodes

    def board(self, episodes: kernels.Episodes) -> Board:
        """The policy's observations of episodes."""
        count = episodes.slot.size
        board = Board(self.policy.observation, count, self.targets)
        parts = min(self._threads, count // LEAST_PART)
        if parts < 2:
            board.observe(self.pool.arrays, episodes, 0, count)
            return board
        edges = np.linspace(0, count, parts + 1).astype(int).tolist()
        with ThreadPoolExecutor(parts) as pool:
            list(
                pool.map(
                    lambda first, last: board.observe(self.pool.arrays, episodes, first, last),
                    edges[:-1],
                    edges[1:],
                )
            )
        return board


def pick(episodes: kernels.Episodes, rows: npt.NDArray[np.int64]) -> kernels.Episodes:
    """Copies of some episodes, in the order of ``rows``, which may repeat."""
    return kernels.Episodes(*(np.ascontiguousarray(part[rows]) for part in episodes))


def play(
    field: Field,
    count: int,
    noise: Callable[[tuple[int, ...]], npt.NDArray[np.float32]] | None,
    temperature: float,
    found: Found,
) -> None:
    """Play ``count`` episodes to their end concurrently.

    The best promise that they come across is kept. Without noise, so is the plan of following the
    chains alone: what they gain on each other is nearly free.

    Parameters
    ----------
    noise : callable, optional
        Gumbel noise of a shape: the move with the best sum of log-probability and noise is a
        sample of the policy. Without it the best move is taken.
    temperature : float
        Divides the scores before sampling.
    """

    def choose(board: Board) -> npt.NDArray[np.int64]:
        scores, _ = field.policy.judge(board.arrays, board.mask)
        if noise is not None:
            scores = log_probabilities(scores, temperature) + noise(scores.shape)
            scores[~board.mask] = -np.inf
        best: npt.NDArray[np.int64] = scores.argmax(axis=1)
        return best

    promise = BestPromise(field)
    most = finish(field, field.begin(count), [[] for _ in range(count)], choose, found, promise)
    promise.keep(most, found)
    if noise is None and field.sees_chains:
        finish(field, field.begin(1), [[]], follow_chains, found)


def finish(
    field: Field,
    episodes: kernels.Episodes,
    made: list[list[int]],
    choose: Callable[[Board], npt.NDArray[np.int64]],
    found: Found,
    promise: BestPromise | None = None,
) -> float:
    """Play from given states to the end of every mission.

    Parameters
    ----------
    made : list of list of int
        How each of them came about, bodies; written.
    choose : callable
        The actions that follow upon a board.
    promise : BestPromise, optional
        Sees every board.

    Returns
    -------
    most : float
        Prize of the best of them [mean prizes].
    """
    most = 0.0
    running = np.arange(episodes.slot.size)
    rewards = np.zeros(running.size, dtype=np.float32)
    while running.size:
        board = field.board(episodes)
        alive = board.legal > 0
        if not alive.all():
            for row in running[~alive]:
                found(np.array(made[row], dtype=np.int64))
            most = max(most, float(episodes.collected[~alive].max()))
            running = running[alive]
            if not running.size:
                break
            episodes = pick(episodes, np.flatnonzero(alive))
            board = field.board(episodes)
        if promise is not None:
            promise.look(board, episodes)
            if promise.row >= 0:
                promise.made = list(made[running[promise.row]])
        actions = choose(board)
        kernels.act(field.pool.arrays, episodes, 0, running.size, actions, rewards)
        for row, action in zip(running.tolist(), actions.tolist(), strict=True):
            made[row].append(int(kernels.body_of(action, field.targets)))
    return most


class BestPromise:
    """The best promise seen: a flyable plan, whatever the policy makes of it.

    Parameters
    ----------
    field : Field

    Attributes
    ----------
    row : int
        Its row in the board looked at last; −1 if that has no better one.
    made : list of int
        How its state came about, bodies; to be set when ``row`` is.
    """

    def __init__(self, field: Field) -> None:
        self._field = field
        self._most = -math.inf
        self._state: kernels.Episodes | None = None
        self.row = -1
        self.made: list[int] = []

    def look(self, board: Board, episodes: kernels.Episodes) -> FloatArray | None:
        """Examine the observations of states.

        Returns what they promise, see :func:`.promises.promises`; None if the
        policy sees no chains.
        """
        promised = promises(board) if self._field.sees_chains else None
        self.row = -1
        if promised is not None and promised.max() > self._most + EQUAL_PRIZES:
            self._most = float(promised.max())
            self.row = int(promised.max(axis=1).argmax())
            self._state = pick(episodes, np.array([self.row]))
        return promised

    def keep(self, most: float, found: Found) -> None:
        """Build its plan by following the chains, if ``most`` mean prizes are less."""
        if self._state is not None and self._most > most + EQUAL_PRIZES:
            finish(self._field, self._state, [self.made], follow_chains, found)


def gumbel(rng: np.random.Generator) -> Callable[[tuple[int, ...]], npt.NDArray[np.float32]]:
    """A source of Gumbel noise."""

    def draw(shape: tuple[int, ...]) -> npt.NDArray[np.float32]:
        return rng.gumbel(size=shape).astype(np.float32)

    return draw


def chunks(total: int, size: int) -> list[int]:
    """``total`` split into parts of at most ``size``."""
    return [min(size, total - done) for done in range(0, total, size)]
