"""Connections that are kept within some room."""

from __future__ import annotations

import numpy as np

from adr_opt.kernels.legs.found import ConnectionArrays
from adr_opt.legs.connections import ConnectionCache

EACH_BYTES = 30 * 10


def some(number: int) -> ConnectionArrays:
    """Ten connections that all bear a number."""
    numbers = np.full(10, float(number))
    return ConnectionArrays(
        numbers,
        numbers,
        numbers,
        numbers.astype(np.int8),
        numbers.astype(np.int32),
        numbers.astype(np.int8),
    )


def test_the_last_ones_asked_for_are_kept() -> None:
    """What is asked for again is not worked out again, as long as it is among the last ones."""
    made: list[int] = []

    def ask(number: int) -> ConnectionArrays:
        def find() -> ConnectionArrays:
            made.append(number)
            return some(number)

        return kept.get((number, 0), find)

    kept = ConnectionCache(3 * EACH_BYTES)
    for number in (1, 2, 3, 1, 4, 1, 2):
        assert ask(number).departure[0] == number
        assert kept.bytes == EACH_BYTES * len(kept) <= 3 * EACH_BYTES
    assert made == [1, 2, 3, 4, 2]
    kept.limit(0.0)
    assert (len(kept), kept.bytes) == (0, 0)
    assert ask(2).departure[0] == 2.0
    assert (len(kept), made[-1]) == (0, 2)
