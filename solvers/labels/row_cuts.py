"""Subset-row cuts in labels: tolls that a walk still owes, and their effect on dominance.

A *subset-row cut* of three targets says that routes which service two or three of them are at most
one in any plan (Jepsen, Petersen, Spoorendonk and Pisinger 2008). With a multiplier σ ≥ 0 every
route pays σ at its second service of a row. A walk needs a bit for that: whether it has serviced
one row and will pay at the next. The bit is forgotten on the way to a body outside the *memory* of
the cut, so that labels are told apart near its rows alone (limited memory: Pecin, Pessoa, Poggi and
Uchoa 2017). To forget is to pay less, which relaxes.

Bits stand in the memory of labels, beyond those of the bodies. Of two labels the one that owes more
still dominates if its lead is worth the tolls that the other one does not owe.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from adr_opt.kernels.core.compile import inlined
from adr_opt.mission.evidence import WORD, Cut

from ..networks.simd import lowest_bit

ROWS = 3
"""Number of targets of a cut; two of them pay."""


class CutTolls(NamedTuple):
    """The cuts in use; kernels for walks without cuts are compiled with None in place of it.

    Attributes
    ----------
    rows : (bodies, words) int64
        Bits of the cuts that each body is a row of.
    bits : (words,) int64
        Those of all cuts.
    toll : (words·63,) int64
        By position of a bit [fine units].
    """

    rows: np.ndarray
    bits: np.ndarray
    toll: np.ndarray


def tolls_of(cuts: Sequence[Cut], bodies: int, words: int, unit: float) -> CutTolls | None:
    """Bits and tolls of cuts, from the first bit after those of the bodies on.

    Parameters
    ----------
    cuts : sequence of Cut
    bodies, words : int
    unit : float
        In which labels count worth; tolls are rounded down, which relaxes.

    Returns
    -------
    CutTolls or None
        None for no cuts.
    """
    if not cuts:
        return None
    rows, bits = np.zeros((bodies, words), np.int64), np.zeros(words, np.int64)
    toll = np.zeros(words * WORD, np.int64)
    for number, cut in enumerate(cuts):
        word, bit = divmod(bodies + number, WORD)
        rows[list(cut.rows), word] |= 1 << bit
        bits[word] |= 1 << bit
        toll[bodies + number] = int(cut.multiplier / unit)
    return CutTolls(rows, bits, toll)


def words_for(bodies: int, cuts: int = 0) -> int:
    """Number of words of memory for bodies and cuts."""
    return (bodies + cuts - 1) // WORD + 1


def remember_cuts(neighbourhood: np.ndarray, cuts: Sequence[Cut], bodies: int) -> None:
    """Write the cuts that walks remember at each body."""
    for number, cut in enumerate(cuts):
        word, bit = divmod(bodies + number, WORD)
        neighbourhood[:, word] &= ~(1 << bit)
        neighbourhood[sorted(cut.memory), word] |= 1 << bit


@inlined
def toll_at(cuts, labels, label, neighbourhood, j):
    """Toll of a service of j for a label [fine units]."""
    owed = np.int64(0)
    if cuts is None:
        return owed
    for w in range(cuts.bits.size):
        paying = labels.memory[label, w] & neighbourhood[j, w] & cuts.rows[j, w]
        while paying:
            owed += cuts.toll[w * WORD + lowest_bit(paying)]
            paying &= paying - 1
    return owed


@inlined
def count_row(cuts, remembered, j):
    """Count a service of j in a memory; a service that pays resets the count."""
    if cuts is None:
        return
    for w in range(remembered.size):
        remembered[w] ^= cuts.rows[j, w]
