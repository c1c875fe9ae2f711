"""Legs dominated for a chaser that has waited: an earlier departure was at least as good.

A leg is stale for a chaser that was ready when another one left for the same body that lands no
later and costs no more. Connections cannot tell, since a chaser ready in between has a use for
it. Of those that labels could take again and again while they wait, nearly all are stale.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from adr_opt.kernels.core.compile import kernel

LOOK_BACK = 8
"""Number of earlier departures to compare each leg with; an omission is harmless."""


class RowLegs(NamedTuple):
    """Legs by row.

    Attributes
    ----------
    destination, first, delta_v
        As in :class:`.arrays.Network`.
    landing : (legs,) int32 or float64
        When legs land, in any measure of time.
    """

    destination: np.ndarray
    first: np.ndarray
    landing: np.ndarray
    delta_v: np.ndarray


@kernel
def mark_stale(begin, end, bodies, legs, since, fresh):
    """Find from which ready row on the legs of a body are dominated.

    Parameters
    ----------
    begin, end : int
        The rows of the body.
    bodies : int
    legs : RowLegs
    since : (legs,) int32
        Written: the leg is dominated for a chaser ready by this row; −1 for none.
    fresh : (rows,) int32
        Written: all legs of the row are dominated for a chaser ready by this row.
    """
    destination, first, landing, delta_v = legs
    earlier = np.full((bodies, LOOK_BACK), -1)
    for row in range(begin, end):
        ahead = earlier[destination[row]]
        for leg in range(first[row], first[row + 1]):
            since[leg] = -1
        for other in ahead:
            if other < 0:
                break
            least, at = np.inf, first[other]
            for leg in range(first[row], first[row + 1]):
                while at < first[other + 1] and landing[at] <= landing[leg]:
                    least = min(least, delta_v[at])
                    at += 1
                if since[leg] < 0 and least <= delta_v[leg]:
                    since[leg] = other
        fresh[row] = row
        for leg in range(first[row], first[row + 1]):
            fresh[row] = min(fresh[row], since[leg])
        for place in range(LOOK_BACK - 1, 0, -1):
            ahead[place] = ahead[place - 1]
        ahead[0] = row
