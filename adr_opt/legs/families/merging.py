"""Merging of the connections of several families, without dominated ones."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from ...kernels.core.lists import ranks
from ...kernels.legs.found import ConnectionArrays
from ...kernels.legs.given import undominated

FloatArray = npt.NDArray[np.float64]


def of_family(
    number: int,
    departure: FloatArray,
    arrival: FloatArray,
    delta_v: FloatArray,
    revolutions: npt.NDArray[np.int8],
) -> ConnectionArrays:
    """Connections of one family in any order, without crossings, which :func:`merged` adds.

    Parameters
    ----------
    number : int
        Of the family.
    departure, arrival, delta_v, revolutions : (connections,)
        As of :class:`.ConnectionArrays`.
    """
    crossing = np.zeros(departure.size, dtype=np.int32)
    family = np.full(departure.size, number, dtype=np.int8)
    return ConnectionArrays(departure, arrival, delta_v, revolutions, crossing, family)


def merged(
    found: ConnectionArrays | None, more: ConnectionArrays, latest_s: float, resolution_m_s: float
) -> ConnectionArrays:
    """Two lists of connections of a pair merged into one.

    Parameters
    ----------
    found : ConnectionArrays or None
    more : ConnectionArrays
        In any order.
    latest_s : float
        Connections that arrive later are left out [s].
    resolution_m_s : float
        A connection that saves no more than this is dominated [m/s].
    """
    lists = [more] if found is None else [found, more]
    columns = [np.concatenate(parts) for parts in zip(*lists, strict=True)]
    order = np.lexsort((columns[2], columns[1], columns[0]))
    ordered = ConnectionArrays(*(column[order] for column in columns))
    kept = undominated(
        ordered.departure, ordered.arrival, ordered.delta_v, latest_s, resolution_m_s
    )
    left = ConnectionArrays(*(column[kept] for column in ordered))
    return left._replace(crossing=ranks(left.arrival))
