"""Subset-row cuts in labels: what a walk still owes, and by how much that blurs dominance.

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
    """The cuts in use.

    Attributes
    ----------
    any : bool
    rows : (bodies, words) int64
        Bits of the cuts that each body is a row of.
    bits : (words,) int64
        Those of all cuts.
    toll : (words·63,) int64
        By position of a bit [fine units].
    """

    any: bool
    rows: np.ndarray
    bits: np.ndarray
    toll: np.ndarray


def no_tolls(bodies: int, words: int) -> CutTolls:
    """No cuts."""
    return CutTolls(
        False, np.zeros((bodies, words), np.int64), np.zeros(words, np.int64),
        np.zeros(words * WORD, np.int64),
    )  # fmt: skip


def tolls_of(cuts: Sequence[Cut], bodies: int, words: int, unit: float) -> CutTolls:
    """Bits and tolls of cuts, from the first bit after those of the bodies on.

    Parameters
    ----------
    cuts : sequence of Cut
    bodies, words : int
    unit : float
        In which labels count worth; tolls are rounded down, which relaxes.
    """
    found = no_tolls(bodies, words)
    for number, cut in enumerate(cuts):
        word, bit = divmod(bodies + number, WORD)
        for body in cut.rows:
            found.rows[body, word] |= 1 << bit
        found.bits[word] |= 1 << bit
        found.toll[bodies + number] = int(cut.multiplier / unit)
    return found._replace(any=bool(cuts))


def words_for(bodies: int, cuts: int = 0) -> int:
    """Number of words of memory for bodies and cuts."""
    return (bodies + cuts - 1) // WORD + 1


def remember_cuts(neighbourhood: np.ndarray, cuts: Sequence[Cut], bodies: int) -> None:
    """Write which cuts walks remember at each body."""
    for number, cut in enumerate(cuts):
        word, bit = divmod(bodies + number, WORD)
        neighbourhood[:, word] &= ~(1 << bit)
        neighbourhood[sorted(cut.memory), word] |= 1 << bit


@inlined
def toll_at(cuts, memory, neighbourhood, j):
    """Toll of a service of j for a walk with a memory [fine units]."""
    owed = np.int64(0)
    for w in range(memory.size):
        paying = memory[w] & neighbourhood[j, w] & cuts.rows[j, w]
        while paying:
            owed += cuts.toll[w * WORD + lowest_bit(paying)]
            paying &= paying - 1
    return owed


@inlined
def owed_beyond(cuts, memory, other):
    """Tolls that a walk with one memory may still have to pay, and one with another not."""
    owed = np.int64(0)
    for w in range(other.size):
        beyond = memory[w] & ~other[w] & cuts.bits[w]
        while beyond:
            owed += cuts.toll[w * WORD + lowest_bit(beyond)]
            beyond &= beyond - 1
    return owed
