"""Limits on the departures, durations and costs of a pair's transfers."""

import math
from typing import NamedTuple


class Times(NamedTuple):
    """Departure times of transfers and limits on their duration.

    Attributes
    ----------
    interval : float
        Between departure events of a pair, at least [s].
    step, longest : float
        Of the grid of long transfers, and the longest of them, 0 for none [s].
    most : float
        Largest useful ΔV of a transfer [m/s].
    leave_by : float
        No transfer leaves later [s].
    """

    interval: float
    step: float
    longest: float
    most: float
    leave_by: float = math.inf
