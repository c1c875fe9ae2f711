"""Losses of prizes in buckets of time, for walks."""

from __future__ import annotations

import numpy as np

from adr_opt.kernels.rules.falls import Falls

from ..networks.arrays import Network
from ..networks.buckets import Buckets


def prize_losses(
    network: Network, buckets: Buckets, falls: Falls | None, unit: float, bits: int
) -> np.ndarray | None:
    """Lower bounds on the losses of prizes of services that end in each bucket.

    A leg that lands in an earlier bucket than another one ends no later, so what is left out for
    its sake has lost no less.

    Parameters
    ----------
    network : Network
        With ends of services, where prizes fall.
    buckets : Buckets
        Of the network.
    falls : Falls or None
    unit : float
        Prize that one unit of value is worth.
    bits : int
        Of the next body in a packed value.

    Returns
    -------
    (buckets,) int32 or None
        Packed as values are; None where no prize falls.
    """
    if falls is None:
        return None
    earliest = np.full(buckets.opens.size, np.inf)
    landing = buckets.of_row[network.landing]
    np.minimum.at(earliest, landing, network.end)
    made = np.zeros(earliest.size, dtype=np.int64)
    for body in np.flatnonzero(np.diff(falls.first)):
        steps = slice(falls.first[body], falls.first[body + 1])
        own = slice(buckets.start[body], buckets.start[body + 1])
        lost = np.append(0.0, falls.lost[steps])[np.searchsorted(falls.until[steps], earliest[own])]
        # Nothing lands where there is no earliest end.
        lost[np.isinf(earliest[own])] = 0.0
        made[own] = np.floor(lost / unit).astype(np.int64) << bits
    return made.astype(np.int32)
