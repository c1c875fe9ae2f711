"""The plan of mcrdv for `odrc` with a load of 10 or 12, as its results hold it.

Three chasers, 44,830.796 m/s. Departures are on a grid of twelve parts of the year, but for some
that a search between put elsewhere.
"""

from __future__ import annotations

from .scoring import LONGEST_S, Route

TOTAL_M_S = 44830.795731044986

_PART_S = LONGEST_S / 12

PLAN = (
    Route((11,), (0.0,)),
    Route((8, 6, 9), (0.0, _PART_S, 10 * _PART_S)),
    Route(
        (7, 1, 12, 5, 3, 2, 0, 4, 10),
        (
            0.0,
            302189.42878534796 + 1535612.8525898964,
            _PART_S,
            2 * _PART_S,
            3 * _PART_S,
            4 * _PART_S,
            5 * _PART_S,
            13273336.348734641 + 47269.10271099955,
            11 * _PART_S,
        ),
    ),
)
"""Debris by their number from 0; departures [s]."""
