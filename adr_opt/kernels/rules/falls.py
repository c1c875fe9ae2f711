"""Prizes that fall with the end of the service (docs/model.md section 5).

A service is worth its greatest prize less what its end has lost of it. What is lost never falls
with time, so that being earlier stays no worse, and prizes without times bound those with them.
"""

from typing import NamedTuple

import numpy as np

from ..core.compile import inlined


class Falls(NamedTuple):
    """Losses of prizes with time.

    Attributes
    ----------
    first : (bodies + 1,) int64
        First step of each body.
    until : (steps,) float64
        Ends of services after which a step is lost, with the slack, ascending in each body [s].
    lost : (steps,) float64
        What is lost then, of the greatest prize.
    unit : float
        Of which all losses are whole multiples.
    """

    first: np.ndarray
    until: np.ndarray
    lost: np.ndarray
    unit: float


@inlined
def lost_at(falls, body, end):
    """Loss of a body's prize by the end of its service [s]; 0 where no prize falls."""
    if falls is None:
        return 0.0
    low, high = falls.first[body], falls.first[body + 1]
    lost = 0.0
    while low < high and falls.until[low] < end:
        lost = falls.lost[low]
        low += 1
    return lost
