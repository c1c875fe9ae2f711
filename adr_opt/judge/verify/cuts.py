"""Subset-row cuts: of three targets, at most one route of a plan services two or more.

Every route may be made to pay at its second service of such a row: the routes of a plan pay once
together, at most. A walk may return to targets, so it pays at every even service, the second, the
fourth and so on; and at a body outside the memory of the cut it forgets an odd one. Both only make
it pay no more than a plan would: what holds for walks holds for plans.
"""

from __future__ import annotations

from collections.abc import Sequence
from fractions import Fraction
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from ...plan.certificate import ProvenCut

WORD = 63
"""Number of cuts, or of targets, per integer."""


class Tolls(NamedTuple):
    """Payments of walks for cuts, with bit c % 63 of word c // 63 for cut c.

    Attributes
    ----------
    rows, memory : (words, bodies) int64
        Cuts that a body is a row of, and those that are remembered there.
    toll : (cuts,) int64
    """

    rows: npt.NDArray[np.int64]
    memory: npt.NDArray[np.int64]
    toll: npt.NDArray[np.int64]


def tolls_of(cuts: Sequence[ProvenCut], names: Sequence[str], unit: Fraction) -> Tolls:
    """Tolls in units, rounded down: in favour of walks."""
    body = {name: number for number, name in enumerate(names)}
    words = (len(cuts) + WORD - 1) // WORD
    rows, memory = (np.zeros((words, len(names)), dtype=np.int64) for _ in range(2))
    toll = np.zeros(len(cuts), dtype=np.int64)
    for number, cut in enumerate(cuts):
        word, bit = number // WORD, np.int64(1) << (number % WORD)
        rows[word, [body[name] for name in cut.targets]] |= bit
        memory[word, [body[name] for name in cut.memory]] |= bit
        toll[number] = min(Fraction(cut.multiplier) // unit, 2**58 // len(cuts))
    return Tolls(rows, memory, toll)


def tolls(bits: npt.NDArray[Any], toll: npt.NDArray[np.int64]) -> npt.NDArray[np.int64]:
    """Sums of the tolls whose bits are set, shape (labels,)."""
    total = np.zeros(bits.shape[1], np.int64)
    for cut in range(toll.size):
        total += (bits[cut // WORD] >> (cut % WORD) & 1) * toll[cut]
    return total
