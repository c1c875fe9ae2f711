"""Promises of chains, from observations that include them."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from adr_opt.common.constants import HOUR_S
from adr_opt.kernels.episodes.lookahead import Promises
from adr_opt.learning.episodes import Board

FloatArray = npt.NDArray[np.float64]

MOST_H = 50.0
"""Time left beyond which more is worth nothing [h]."""


def promises(board: Board) -> FloatArray:
    """Prize of the whole mission promised by the chains after each move, in mean prizes.

    Returns
    -------
    promises : (episodes, actions) float64
        −inf where no chain was followed.
    """
    return _chains(board).prize


def time_left_of_best(board: Board) -> FloatArray:
    """Time left at the end of the most promising chain after each move [10 h]."""
    longest: FloatArray = np.minimum(_chains(board).time_left / HOUR_S, MOST_H) / 10.0
    return longest


def follow_chains(board: Board) -> npt.NDArray[np.int64]:
    """Moves with the most promising chains, whose promise never decreases."""
    best: npt.NDArray[np.int64] = _chains(board).lead.argmax(axis=1)
    return best


def _chains(board: Board) -> Promises:
    assert board.promises is not None
    return board.promises
