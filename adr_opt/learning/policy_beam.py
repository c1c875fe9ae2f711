"""Beam search guided by a policy, level by level over visits."""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from ..common.constants import HOUR_S
from ..kernels.episodes import episodes as kernels
from ..kernels.episodes.episodes import HOME
from .decoding import Enough, Field, Found, Sequence, pick
from .policy import FloatArray, log_probabilities

EQUAL_PRIZES = 1e-6
"""Difference within which prizes count as equal [mean prizes]."""

MOVED = 6
"""Number of children moved and compared exactly, as a multiple of the width."""

REFUELLED = 0.25
"""Share of the width that continues from the station."""


@dataclass(frozen=True)
class PolicyBeamSettings:
    """Selection of partial plans in a policy-guided beam.

    Attributes
    ----------
    width : int
        Partial plans kept after each visit.
    prior_weight : float
        Worth of a unit of log-probability [mean prizes].
    time_weight, delta_v_weight : float
        Worth of an hour and of a km/s that are left [mean prizes per h, per km/s].
    """

    width: int
    prior_weight: float = 0.05
    time_weight: float = 0.17
    delta_v_weight: float = 0.38


class _Trail:
    """Tree of the moves of all partial plans."""

    def __init__(self) -> None:
        self._bodies = [HOME]
        self._parents = [-1]

    def add(self, bodies: Sequence, parents: Sequence) -> Sequence:
        """Add one move each; returns the new nodes."""
        first = len(self._bodies)
        self._bodies.extend(bodies.tolist())
        self._parents.extend(parents.tolist())
        return np.arange(first, len(self._bodies))

    def back(self, node: int) -> list[int]:
        """Bodies on the way to a node."""
        sequence: list[int] = []
        while node > 0:
            sequence.append(self._bodies[node])
            node = self._parents[node]
        return sequence[::-1]


class _Partial(NamedTuple):
    """Partial plans: states, nodes of the trail, and sums of log-probabilities."""

    episodes: kernels.Episodes
    nodes: Sequence
    priors: FloatArray


class _Children(NamedTuple):
    """Partial plans after one more move: parent nodes in the trail, and worth in mean prizes."""

    episodes: kernels.Episodes
    parents: Sequence
    priors: FloatArray
    worth: npt.NDArray[np.float64]

    def best(self, most: int, words: Sequence, trail: _Trail) -> _Partial:
        """The best children, only one per set of visits and body; ``words`` hash the visits."""
        order = np.argsort(-self.worth, kind="stable")
        body = self.episodes.body.astype(np.int64)
        same = (self.episodes.visited * words).sum(axis=1) ^ (body << 1)
        _, firsts = np.unique(same[order], return_index=True)
        kept = order[np.sort(firsts)][:most]
        nodes = trail.add(body[kept], self.parents[kept])
        return _Partial(pick(self.episodes, kept), nodes, self.priors[kept])


def beam(field: Field, settings: PolicyBeamSettings, found: Found, enough: Enough) -> int:
    """Search level by level over visits, with one call of the network per level.

    A refuelling on the way is part of the level, so states before and after it are never compared.
    Plans that service the same targets and end at the same body are the same state but for time
    and ΔV; only the best of them is kept.

    Returns
    -------
    states : int
        States judged.
    """
    trail = _Trail()
    level = _Partial(field.begin(1), np.zeros(1, dtype=np.int64), np.zeros(1, dtype=np.float32))
    words = np.random.default_rng(0).integers(1, 2**62, size=field.targets + 1, dtype=np.int64)
    best, most, states, ended = 0, -np.inf, 0, False
    while level.nodes.size:
        # With unequal prizes the last level need not have the plan that collects most.
        collected, delta_v = level.episodes.collected, level.episodes.delta_v
        first = int(np.lexsort((delta_v, -collected))[0])
        if collected[first] > most + EQUAL_PRIZES:
            best, most = int(level.nodes[first]), float(collected[first])
        partial, targets = level, []
        for refuelled in (False, True):
            scores, board = field.judged(partial.episodes)
            states += partial.nodes.size
            ended = enough()
            if ended or not board.legal.any():
                break
            worth, priors = _worth_of_moves(settings, scores, board.mask, partial)
            targets.append(_move(field, settings, partial, worth, priors, slice(0, field.targets)))
            if refuelled:
                break
            station = slice(field.targets, field.targets + 1)
            stops = _move(field, settings, partial, worth, priors, station)
            if not stops.parents.size:
                break
            partial = stops.best(max(1, int(REFUELLED * settings.width)), words, trail)
        if ended or not targets:
            break
        level = _side_by_side(targets).best(settings.width, words, trail)
    found(np.array(trail.back(best), dtype=np.int64))
    return states


def _worth_of_moves(
    settings: PolicyBeamSettings, scores: FloatArray, mask: npt.NDArray[np.bool_], partial: _Partial
) -> tuple[npt.NDArray[np.float64], FloatArray]:
    """Worth of every move in advance, and its log-probability with all earlier ones.

    −inf where a move is illegal.
    """
    priors: FloatArray = log_probabilities(scores) + partial.priors[:, None]
    # Illegal moves have no log-probability; 0 keeps 0 · −∞ out of what follows.
    logs = np.where(mask, priors, 0.0).astype(np.float64)
    worth: npt.NDArray[np.float64] = settings.prior_weight * logs
    worth = worth + partial.episodes.collected[:, None]
    worth[~mask] = -np.inf
    return worth, priors


def _move(
    field: Field,
    settings: PolicyBeamSettings,
    partial: _Partial,
    worth: npt.NDArray[np.float64],
    priors: FloatArray,
    actions: slice,
) -> _Children:
    """Make the best moves among ``actions``, and evaluate the resulting states."""
    rows, moves = np.nonzero(worth[:, actions] > -np.inf)
    moves = moves + actions.start
    value = worth[rows, moves]
    most = MOVED * settings.width
    if most < rows.size:
        chosen = np.argpartition(-value, most - 1)[:most]
        rows, moves, value = rows[chosen], moves[chosen], value[chosen]
    episodes = pick(partial.episodes, rows)
    rewards = np.zeros(rows.size, dtype=np.float32)
    kernels.act(field.pool.arrays, episodes, 0, rows.size, moves, rewards)
    ends = (
        value
        - settings.time_weight * episodes.time / HOUR_S
        + settings.delta_v_weight * episodes.left / 1000.0
    )
    return _Children(episodes, partial.nodes[rows], priors[rows, moves], ends)


def _side_by_side(parts: list[_Children]) -> _Children:
    """Children of the same level merged."""
    episodes = kernels.Episodes(
        *(np.concatenate(arrays) for arrays in zip(*(part.episodes for part in parts), strict=True))
    )
    parents, priors, worth = (
        np.concatenate(arrays) for arrays in zip(*(part[1:] for part in parts), strict=True)
    )
    return _Children(episodes, parents, priors, worth)
