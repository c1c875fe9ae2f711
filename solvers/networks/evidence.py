"""Evidence of proofs, for certificates: see :mod:`adr_opt.mission.evidence`."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from adr_opt.mission.evidence import WORD, Cut, Evidence, Walks


def evidence_of(
    multipliers: np.ndarray,
    chasers: Sequence[tuple[int, ...]],
    most: Sequence[float],
    neighbourhoods: Sequence[np.ndarray] | None,
    slot_m_s: float,
    cuts: Sequence[Cut] = (),
) -> Evidence:
    """The evidence of a bound.

    Parameters
    ----------
    multipliers : (bodies,) float64
    chasers : sequence of tuple of int
        Numbers of those of each kind.
    most : sequence of float
        What no walk of each kind collects; −inf where there is none at all.
    neighbourhoods : sequence of (bodies, words) int64, optional
        What the walks of each kind remember, as labels have it; by default where they come from.
    slot_m_s : float
        [m/s].
    cuts : sequence of Cut
        What walks pay for, too.
    """
    there = [
        len(them) * value for them, value in zip(chasers, most, strict=True) if value > -math.inf
    ]
    # Where there is no walk there is no plan either: less than nothing is collected together.
    none = -1.0 - math.fsum(multipliers) - math.fsum(there)
    none -= math.fsum(cut.multiplier for cut in cuts)
    words = [None] * len(chasers) if neighbourhoods is None else neighbourhoods
    walks = tuple(
        Walks(them, value if value > -math.inf else none, as_bits(each, multipliers.size))
        for them, value, each in zip(chasers, most, words, strict=True)
    )
    return Evidence(np.array(multipliers), walks, slot_m_s, cuts=tuple(cuts))


def as_bits(words: np.ndarray | None, bodies: int) -> np.ndarray:
    """Whether walks remember a body (column) at another one (row)."""
    if words is None:
        return np.zeros((bodies, bodies), dtype=np.bool_)
    column = np.arange(bodies)
    return (words[:, column // WORD] >> (column % WORD) & 1).astype(np.bool_)
