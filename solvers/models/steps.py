"""Prizes as integers, for solvers that require them."""

from __future__ import annotations

import numpy as np

from adr_opt.common.tolerance import MOST_STEPS, are_multiples

PARTS = 2**40
"""Approximate sum of all prizes in steps, if they are not multiples of the unit."""


def in_steps(prize: np.ndarray, unit: float) -> tuple[np.ndarray, float]:
    """Prizes in whole steps, rounded up.

    Parameters
    ----------
    prize : (bodies,) float64
    unit : float
        The steps, if all prizes are multiples of it and there are not too many.

    Returns
    -------
    steps : (bodies,) int64
        Prizes in steps, rounded up.
    step : float
    """
    if are_multiples(prize.tolist(), unit) and prize.sum() / unit <= MOST_STEPS:
        return np.rint(prize / unit).astype(np.int64), unit
    step = float(prize.sum()) / PARTS
    # A quotient may be rounded down across an integer; one step more covers that.
    return np.where(prize > 0.0, np.floor(prize / step) + 1.0, 0.0).astype(np.int64), step
