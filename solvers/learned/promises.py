"""What chains promise, read from boards of the observation ``lookahead``."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from adr_opt.episodes import Board
from adr_opt.episodes.board import MOVES
from adr_opt.kernels import episodes as kernels
from adr_opt.kernels.lookahead import BEHIND, LEAD, PROMISE
from adr_opt.kernels.observation import MOVE_FIELDS

from .policy import FloatArray


def promises(board: Board, episodes: kernels.Episodes) -> FloatArray:
    """Targets of the whole mission that the chains after each move promise.

    Returns
    -------
    promises : (episodes, actions) float32
        −inf where no chain was followed.
    """
    chains = _chains(board)
    total = 10.0 * chains[..., PROMISE] + episodes.serviced[:, None]
    promised: FloatArray = np.where(chains[..., BEHIND] > 0.0, total, np.float32(-np.inf))
    return promised


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
