"""From a policy to a plan: the best move again and again, samples, or a beam."""

from __future__ import annotations

import math
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from adr_opt.episodes import Board, FieldPool, new_episodes, start
from adr_opt.episodes.board import MOVES
from adr_opt.kernels import episodes as kernels
from adr_opt.kernels.constants import STATION
from adr_opt.kernels.lookahead import BEHIND, LEAD, PROMISE
from adr_opt.kernels.observation import MOVE_FIELDS
from adr_opt.mission import Mission

from .policy import FloatArray, Policy, log_probabilities

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
        self.mission, self.policy = mission, policy
        self._threads = threads
        # A policy for a fixed number of targets sees the missing ones as bodies that are not there.
        self.targets = policy.targets or targets
        self.budget = mission.instance.mission.delta_v_m_s
        self.duration = mission.instance.mission.duration_s
        table = mission.timetable.table
        self.pool = FieldPool(1, self.targets + 1, table.entries.shape[1])
        self.pool.install(0, mission)

    @property
    def sees_chains(self) -> bool:
        """Whether the policy's observation has chains."""
        return bool(self.policy.observation == "lookahead")

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
) -> int:
    """Go on from states to the end of every mission.

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
    most : int
        Targets of the best of them.
    """
    most = 0
    running = np.arange(episodes.slot.size)
    rewards = np.zeros(running.size, dtype=np.float32)
    while running.size:
        board = field.board(episodes)
        alive = board.legal > 0
        if not alive.all():
            for row in running[~alive]:
                found(np.array(made[row], dtype=np.int64))
            most = max(most, int(episodes.serviced[~alive].max()))
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


def promises(field: Field, board: Board, episodes: kernels.Episodes) -> FloatArray | None:
    """Targets of the whole mission that the chains after each move promise.

    Returns
    -------
    promises : (episodes, actions), optional
        −inf where no chain was followed. None if the policy sees no chains.
    """
    if not field.sees_chains:
        return None
    chains = _chains(board)
    total = 10.0 * chains[..., PROMISE] + episodes.serviced[:, None]
    return np.where(chains[..., BEHIND] > 0.0, total, np.float32(-np.inf))


def time_left_of_best(board: Board) -> FloatArray:
    """Time left at the end of the chain that promises most, after each move [10 h]."""
    chains = _chains(board)
    counts, left = chains[..., 0:BEHIND:2], chains[..., 1:BEHIND:2]
    best = np.where(counts > chains[..., PROMISE, None] - 0.05, left, np.float32(0.0))
    longest: FloatArray = best.max(axis=-1)
    return longest


def follow_chains(board: Board) -> npt.NDArray[np.int64]:
    """The moves after which chains promise most; what they promise never gets less."""
    lead = np.where(board.mask, _chains(board)[..., LEAD], np.float32(-np.inf))
    best: npt.NDArray[np.int64] = lead.argmax(axis=1)
    return best


def _chains(board: Board) -> FloatArray:
    assert isinstance(board.arrays, dict)
    return board.arrays[MOVES][..., len(MOVE_FIELDS) :]


class BestPromise:
    """The best promise seen: a plan that can be flown, whatever the policy makes of it.

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
        """Look at the boards of states; returns what they promise, see :func:`promises`."""
        promised = promises(self._field, board, episodes)
        self.row = -1
        if promised is not None and promised.max() > self._most:
            self._most = float(promised.max())
            self.row = int(promised.max(axis=1).argmax())
            self._state = pick(episodes, np.array([self.row]))
        return promised

    def keep(self, most: int, found: Found) -> None:
        """Make the plan behind it, by following the chains, if ``most`` targets are fewer."""
        if self._state is not None and self._most > most:
            finish(self._field, self._state, [self.made], follow_chains, found)


def gumbel(rng: np.random.Generator) -> Callable[[tuple[int, ...]], npt.NDArray[np.float32]]:
    """A source of Gumbel noise."""

    def draw(shape: tuple[int, ...]) -> npt.NDArray[np.float32]:
        return rng.gumbel(size=shape).astype(np.float32)

    return draw


AFTERWARDS = 0.5
"""Worth of ten hours left at the end of the chain that promises most [targets]."""


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


class _Trail:
    """How the partial plans of every level of a beam came about."""

    def __init__(self) -> None:
        self._bodies = [np.full(1, STATION)]
        self._parents = [np.zeros(1, dtype=np.int64)]

    def add(self, bodies: Sequence, parents: Sequence) -> None:
        """The next level: last bodies, and places in the level before."""
        self._bodies.append(bodies)
        self._parents.append(parents)

    @property
    def level(self) -> int:
        """The last level."""
        return len(self._bodies) - 1

    def back(self, level: int, place: int) -> list[int]:
        """The bodies on the way to a place."""
        sequence: list[int] = []
        while level > 0:
            sequence.append(int(self._bodies[level][place]))
            place = int(self._parents[level][place])
            level -= 1
        return sequence[::-1]


def beam(field: Field, settings: BeamSettings, found: Found, enough: Enough) -> int:
    """Level by level over moves, all states of a level judged by the network at once.

    Plans that service the same targets and end at the same body are the same state but for time
    and ΔV; only the best of them is kept. Where the policy sees chains, partial plans are compared
    by what these promise, and the best promise is kept, whatever becomes of the plan behind it.

    Returns
    -------
    states : int
        States judged.
    """
    episodes = field.begin(1)
    priors = np.zeros(1)
    trail = _Trail()
    best_count, best_key = -1, (0.0, 0.0)
    best_place: tuple[int, int] = (0, 0)
    best_promise = BestPromise(field)
    words = np.random.default_rng(0).integers(1, 2**62, size=field.targets + 1, dtype=np.int64)
    states = 0
    while True:
        board = field.board(episodes)
        states += board.legal.size
        for row in np.flatnonzero(episodes.serviced >= best_count):
            key = (-float(episodes.delta_v[row]), float(priors[row]))
            if episodes.serviced[row] > best_count or key > best_key:
                best_count, best_key = int(episodes.serviced[row]), key
                best_place = (trail.level, int(row))
        if not board.legal.any():
            break
        promised = best_promise.look(board, episodes)
        if best_promise.row >= 0:
            best_promise.made = trail.back(trail.level, best_promise.row)
        if enough():
            break
        scores, _ = field.policy.judge(board.arrays, board.mask)
        logs = log_probabilities(scores) + priors[:, None].astype(np.float32)
        if promised is None:
            rows, actions = np.nonzero(board.mask)
            promise = settings.prior_weight * logs[rows, actions]
        else:
            rows, actions = np.nonzero(promised > -np.inf)
            promise = (promised + AFTERWARDS * time_left_of_best(board))[rows, actions]
            promise = promise + settings.prior_weight * logs[rows, actions]
        # Cheaply by promise first: only these children are worth a move.
        most = min(rows.size, 6 * settings.width)
        chosen = np.argpartition(-promise, most - 1)[:most] if most < rows.size else slice(None)
        rows, actions, promise = rows[chosen], actions[chosen], promise[chosen]
        children = pick(episodes, rows)
        rewards = np.zeros(rows.size, dtype=np.float32)
        kernels.act(field.pool.arrays, children, 0, rows.size, actions, rewards)
        worth = (
            children.serviced
            + promise
            - settings.time_weight * children.time / 3600.0
            + settings.delta_v_weight * children.left / 1000.0
        )
        order = np.argsort(-worth, kind="stable")
        same = (children.visited * words).sum(axis=1) ^ (children.body.astype(np.int64) << 1)
        _, firsts = np.unique(same[order], return_index=True)
        kept = order[np.sort(firsts)][: settings.width]
        priors = logs[rows[kept], actions[kept]].astype(float)
        episodes = pick(children, kept)
        trail.add(episodes.body.astype(np.int64), rows[kept])
    found(np.array(trail.back(*best_place), dtype=np.int64))
    best_promise.keep(best_count, found)
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
