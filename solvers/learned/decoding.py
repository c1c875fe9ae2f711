"""From a policy to a plan: the best move again and again, samples, or a beam."""

from __future__ import annotations

import math
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from adr_opt.episodes import Board, FieldPool, new_episodes, start
from adr_opt.kernels import episodes as kernels
from adr_opt.kernels.constants import STATION
from adr_opt.mission import Mission

from .policy import Policy, log_probabilities

Sequence = npt.NDArray[np.int64]
Found = Callable[[Sequence], None]
"""Hears of every plan, a sequence of bodies."""

Enough = Callable[[], bool]

LEAST_PART = 8
"""Fewer episodes are not worth a thread."""


class Field:
    """A mission as episodes are played on it.

    Parameters
    ----------
    mission : Mission
    policy : Policy
    threads : int
        Threads that work out what the policy sees of many episodes.

    Raises
    ------
    InputError
        More targets than the policy was made for.
    """

    def __init__(self, mission: Mission, policy: Policy, threads: int = 1) -> None:
        targets = len(mission.names) - 1
        policy.check_size(targets)
        self.policy = policy
        self._threads = threads
        # A policy for a fixed number of targets sees the missing ones as bodies that are not there.
        self.targets = policy.targets or targets
        self.budget = mission.instance.mission.delta_v_m_s
        self.duration = mission.instance.mission.duration_s
        table = mission.timetable.table
        self.pool = FieldPool(1, self.targets + 1, table.entries.shape[1])
        self.pool.install(0, mission)

    def begin(self, count: int) -> kernels.Episodes:
        """``count`` episodes at the start of the mission."""
        episodes = new_episodes(count, self.targets + 1)
        for index in range(count):
            start(self.pool, episodes, index, 0, self.budget, self.duration)
        return episodes

    def board(self, episodes: kernels.Episodes) -> Board:
        """What the policy sees of episodes."""
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
    """Copies of some episodes, in the order of ``rows``; a row may occur often."""
    return kernels.Episodes(*(np.ascontiguousarray(part[rows]) for part in episodes))


def play(
    field: Field,
    count: int,
    noise: Callable[[tuple[int, ...]], npt.NDArray[np.float32]] | None,
    temperature: float,
    found: Found,
) -> None:
    """Play ``count`` episodes to their end side by side.

    Parameters
    ----------
    noise : callable, optional
        Gumbel noise of a shape: the move with the best sum of log-probability and noise is a
        sample of the policy. Without it the best move is taken.
    temperature : float
        Divides the scores before sampling.
    """
    episodes = field.begin(count)
    running = np.arange(count)
    made: list[list[int]] = [[] for _ in range(count)]
    rewards = np.zeros(count, dtype=np.float32)
    while running.size:
        board = field.board(episodes)
        alive = board.legal > 0
        if not alive.all():
            for row in running[~alive]:
                found(np.array(made[row], dtype=np.int64))
            running = running[alive]
            if not running.size:
                return
            episodes = pick(episodes, np.flatnonzero(alive))
            board = field.board(episodes)
        scores, _ = field.policy.judge(board.arrays, board.mask)
        if noise is not None:
            scores = log_probabilities(scores, temperature) + noise(scores.shape)
            scores[~board.mask] = -np.inf
        actions = scores.argmax(axis=1)
        kernels.act(field.pool.arrays, episodes, 0, running.size, actions, rewards)
        for row, action in zip(running.tolist(), actions.tolist(), strict=True):
            made[row].append(STATION if action == field.targets else action + 1)


def gumbel(rng: np.random.Generator) -> Callable[[tuple[int, ...]], npt.NDArray[np.float32]]:
    """A source of Gumbel noise."""

    def draw(shape: tuple[int, ...]) -> npt.NDArray[np.float32]:
        return rng.gumbel(size=shape).astype(np.float32)

    return draw


@dataclass(frozen=True)
class BeamSettings:
    """How a beam by policy keeps partial plans.

    Attributes
    ----------
    width : int
        Partial plans kept after each move.
    prior_weight : float
        Worth of a unit of log-probability [targets].
    time_weight, delta_v_weight : float
        Worth of an hour [targets per h] and of a km/s left [targets per km/s].
    """

    width: int
    prior_weight: float = 0.05
    time_weight: float = 0.17
    delta_v_weight: float = 0.38


def beam(field: Field, settings: BeamSettings, found: Found, enough: Enough) -> int:
    """Level by level over moves, all states of a level judged by the network at once.

    Plans that service the same targets and end at the same body are the same state but for time
    and ΔV; only the best of them is kept.

    Returns
    -------
    states : int
        States judged.
    """
    episodes = field.begin(1)
    priors = np.zeros(1)
    history = [np.full(1, STATION)]
    parents = [np.zeros(1, dtype=np.int64)]
    best_count, best_key = -1, (0.0, 0.0)
    best_place: tuple[int, int] = (0, 0)
    words = np.random.default_rng(0).integers(1, 2**62, size=field.targets + 1, dtype=np.int64)
    states = 0
    level = 0
    while True:
        board = field.board(episodes)
        states += board.legal.size
        for row in np.flatnonzero(episodes.serviced >= best_count):
            key = (-float(episodes.delta_v[row]), float(priors[row]))
            if episodes.serviced[row] > best_count or key > best_key:
                best_count, best_key = int(episodes.serviced[row]), key
                best_place = (level, int(row))
        if not board.legal.any() or enough():
            break
        scores, _ = field.policy.judge(board.arrays, board.mask)
        logs = log_probabilities(scores) + priors[:, None].astype(np.float32)
        rows, actions = np.nonzero(board.mask)
        # Cheaply by prior first: only these children are worth a move.
        promise = logs[rows, actions]
        most = min(rows.size, 6 * settings.width)
        chosen = np.argpartition(-promise, most - 1)[:most] if most < rows.size else slice(None)
        rows, actions, promise = rows[chosen], actions[chosen], promise[chosen]
        children = pick(episodes, rows)
        rewards = np.zeros(rows.size, dtype=np.float32)
        kernels.act(field.pool.arrays, children, 0, rows.size, actions, rewards)
        worth = (
            children.serviced
            + settings.prior_weight * promise
            - settings.time_weight * children.time / 3600.0
            + settings.delta_v_weight * children.left / 1000.0
        )
        order = np.argsort(-worth, kind="stable")
        same = (children.visited * words).sum(axis=1) ^ (children.body.astype(np.int64) << 1)
        _, firsts = np.unique(same[order], return_index=True)
        kept = order[np.sort(firsts)][: settings.width]
        episodes = pick(children, kept)
        priors = promise[kept].astype(float)
        parents.append(rows[kept])
        history.append(episodes.body.astype(np.int64))
        level += 1
    sequence: list[int] = []
    depth, place = best_place
    while depth > 0:
        sequence.append(int(history[depth][place]))
        place = int(parents[depth][place])
        depth -= 1
    found(np.array(sequence[::-1], dtype=np.int64))
    return states


def chunks(total: int, size: int) -> list[int]:
    """``total`` in parts of at most ``size``."""
    return [min(size, total - done) for done in range(0, total, size)]


def best_of(mission: Mission) -> tuple[Found, Callable[[], tuple[Sequence, float]]]:
    """A listener that keeps the plan with the most prize, then the least ΔV."""
    best: dict[str, tuple[float, float, Sequence]] = {}

    def found(sequence: Sequence) -> None:
        timing = mission.time(sequence)
        key = (timing.objective, -timing.delta_v)
        if "plan" not in best or key > best["plan"][:2]:
            best["plan"] = (*key, sequence)

    def kept() -> tuple[Sequence, float]:
        if "plan" not in best:
            return np.empty(0, dtype=np.int64), -math.inf
        objective, _, sequence = best["plan"]
        return sequence, objective

    return found, kept


def without_last_refuelling(sequence: Sequence) -> list[int]:
    """A sequence without refuelling stops that nothing follows."""
    bodies = [int(body) for body in sequence]
    while bodies and bodies[-1] == STATION:
        bodies.pop()
    return bodies
