"""A time-expanded network of legs, as arrays."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np


class Network(NamedTuple):
    """Rows, body after body, each body's in order of departure, and their legs.

    One row more closes each body: nothing leaves any more.

    Attributes
    ----------
    start : (bodies + 1,) int64
        First row of each body.
    departure : (rows,) float64
        [s]; +inf in closing rows.
    destination : (rows,) int32
        Of all legs of the row.
    first : (rows + 1,) int64
        First leg of each row; the legs of a row in order of arrival, each cheaper than the one
        before.
    landing : (legs,) int32
        Row of the destination at the end of service.
    delta_v : (legs,) float64
        [m/s].
    since : (legs,) int32
        Who was ready by this row has no use for the leg, see :mod:`.network`; −1 for none.
    fresh : (rows,) int32
        Who was ready by this row has no use for any leg of the row.
    is_station, may_end : (bodies,) bool
        As in :class:`adr_opt.kernels.rules.rules.Rules`.
    roots : (starts,) int64
        Row at which each of the missions begins that move on it.
    shortest : float
        Least time from departure to the end of service of any leg but launches [s].
    end : (legs,) float64
        End of service [s], or empty: only walks that pay for time, or whose prizes fall, ask for
        it.
    """

    start: np.ndarray
    departure: np.ndarray
    destination: np.ndarray
    first: np.ndarray
    landing: np.ndarray
    delta_v: np.ndarray
    since: np.ndarray
    fresh: np.ndarray
    is_station: np.ndarray
    may_end: np.ndarray
    roots: np.ndarray
    shortest: float
    end: np.ndarray


def joined(firsts: list[np.ndarray]) -> np.ndarray:
    """One list of first legs from those of all bodies; closing rows have no legs."""
    before = np.cumsum([0, *(int(first[-1]) for first in firsts)])
    parts = [first + legs for first, legs in zip(firsts, before[:-1], strict=True)]
    return np.append(np.concatenate(parts), before[-1])
