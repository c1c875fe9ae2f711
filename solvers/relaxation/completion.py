"""How much can still be collected from any state: an upper bound, as a table for kernels.

What guides a search and what bounds it: the values of all states of :mod:`.walks` after a
few steps on the multipliers.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from adr_opt.kernels.compile import kernel
from adr_opt.kernels.timetable import earliest_taken
from adr_opt.mission import Mission

from .network import SLACK
from .walks import WalkBound


class CompletionTable(NamedTuple):
    """Upper bounds on what can still be collected, for kernels: see :func:`completion_value`.

    Attributes
    ----------
    packed : (width + rows·width,) int32
        As :attr:`Values.best`.
    start, departure
        As in :class:`Network`.
    bucket : (bodies, buckets) int64
        First row of a body at or after the start of each of equal stretches of time.
    bucket_rate : float
        Stretches per second.
    multipliers : (bodies,) float64
        π of each target; 0 for other bodies.
    slot : float
        [m/s].
    width, top, bits : int
    unit : float
        Prize per unit of value.
    """

    packed: np.ndarray
    start: np.ndarray
    departure: np.ndarray
    bucket: np.ndarray
    bucket_rate: float
    multipliers: np.ndarray
    slot: float
    width: int
    top: int
    bits: int
    unit: float


BUCKET_S = 120.0


@kernel
def _fill_buckets(start, departure, rate, bucket):
    for i in range(start.size - 1):
        row = start[i]
        for b in range(bucket.shape[1]):
            # A little early, so that no rounding of the quotient skips a row.
            while departure[row] < b / rate - 1e-3:
                row += 1
            bucket[i, b] = row


@kernel
def completion_value(table, body, time, left):
    """Most that the targets still to come can be worth, less their multipliers.

    For any partial plan that ends in the state, and any way to complete it,

        objective ≤ prizes collected + completion_value + Σ over targets not visited π_j .

    Parameters
    ----------
    table : CompletionTable
    body : int
    time : float
        Since when the chaser is free [s].
    left : float
        ΔV left [m/s].

    Returns
    -------
    value : float
        At least 0: a plan may end anywhere.
    """
    bucket = min(int(time * table.bucket_rate), table.bucket.shape[1] - 1)
    row = table.bucket[body, bucket]
    earliest = earliest_taken(time)
    while table.departure[row] < earliest:
        row += 1
    slots = min(int(left / table.slot + SLACK), table.top)
    return (table.packed[(row + 1) * table.width + slots] >> table.bits) * table.unit


def completion_table(bound: WalkBound, multipliers: np.ndarray) -> CompletionTable:
    """The table of given multipliers; it keeps the arrays of ``bound``, which is used up."""
    _, rounded = bound.evaluate(multipliers)
    network = bound.network
    final = network.departure[np.isfinite(network.departure)].max(initial=0.0)
    bucket = np.empty((network.start.size - 1, int(final / BUCKET_S) + 2), dtype=np.int64)
    _fill_buckets(network.start, network.departure, 1.0 / BUCKET_S, bucket)
    return CompletionTable(
        bound.values.best,
        network.start,
        network.departure,
        bucket,
        1.0 / BUCKET_S,
        rounded,
        bound.slot,
        bound.width,
        bound.top,
        bound.bits,
        bound.unit,
    )


def guide(
    mission: Mission,
    *,
    iterations: int = 60,
    delta_v_slot_m_s: float = 100.0,
    jobs: int = 1,
) -> CompletionTable:
    """A completion table with multipliers after some iterations: what guides a search.

    Parameters
    ----------
    mission : Mission
    iterations : int
        Evaluations of the bound; each sweeps the whole timetable once.
    delta_v_slot_m_s : float
    jobs : int
        Threads.
    """
    from .multipliers import Descent  # which stands on this module

    bound = WalkBound(mission, delta_v_slot_m_s, jobs)
    descent = Descent(bound)
    for _ in range(iterations):
        descent.step()
        if descent.done:
            break
    return completion_table(bound, descent.multipliers)
