"""When transfers of a pair may leave, how long they may take, and what they may cost."""

from typing import NamedTuple


class Times(NamedTuple):
    """When transfers may leave, and how long they may take.

    Attributes
    ----------
    interval : float
        Between departure events of a pair, at least [s].
    step, longest : float
        Of the grid of long transfers, and the longest of them, 0 for none [s].
    most : float
        Transfers that cost more are of no use to anybody [m/s].
    """

    interval: float
    step: float
    longest: float
    most: float
