"""Least cost of completing a partial plan, as guidance for a search of cheaper plans.

The best walks of two sweeps, by body, time and ΔV left: of one that pays for ΔV, and of one that
does not. From the first follows what it costs at least to collect the rest; from the second, more
finely, whether it can be collected.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from adr_opt.kernels.core.compile import inlined

from ..networks.layers import SLACK
from .walks import WalkBound


class Sweep(NamedTuple):
    """Values of the best walks of a sweep.

    Attributes
    ----------
    start : (bodies + 1,) int64
    closes : (buckets,) float64
        As in :class:`solvers.networks.buckets.Buckets`.
    best : (layers, layer) int32
        Packed, as :class:`.sweeps.Values` says.
    bits, width, top : int
    slot, unit : float
        As of the bound that made it.
    """

    start: np.ndarray
    closes: np.ndarray
    best: np.ndarray
    bits: int
    width: int
    top: int
    slot: float
    unit: float


class CostGuide(NamedTuple):
    """Least costs of completion, for kernels: see :func:`least_cost`.

    Attributes
    ----------
    paying, free : Sweep
        With and without paying for ΔV.
    price : float
        Of a unit of worth to walks that pay [m/s].
    worth : float
        What a whole plan has to be worth.
    most : float
        What it has to cost less than [m/s].
    """

    paying: Sweep
    free: Sweep
    price: float
    worth: float
    most: float


def swept(bound: WalkBound, best: np.ndarray | None = None) -> Sweep:
    """The values of a bound's last sweep, or of an earlier one."""
    buckets = bound.buckets
    found = bound.values.best if best is None else best
    return Sweep(
        buckets.start,
        buckets.closes,
        found,
        bound.bits,
        bound.width,
        bound.top,
        bound.slot,
        bound.unit,
    )


def no_costs() -> CostGuide:
    """Unused costs, for kernels with such an argument."""
    best = np.zeros((1, 2), dtype=np.int32)
    none = Sweep(np.zeros(2, dtype=np.int64), np.zeros(1), best, 1, 1, 0, 1.0, 1.0)
    return CostGuide(none, none, 0.0, 0.0, 0.0)


@inlined
def _value(sweep, body, has):
    """Most that a walk can still collect."""
    low, high = sweep.start[body], sweep.start[body + 1] - 1
    while low < high:
        middle = (low + high) // 2
        if sweep.closes[middle] < has.time:
            low = middle + 1
        else:
            high = middle
    slots = min(int(has.left / sweep.slot + SLACK), sweep.top)
    packed = sweep.best[min(has.kits, sweep.best.shape[0] - 1), (low + 1) * sweep.width + slots]
    return (packed >> sweep.bits) * sweep.unit


@inlined
def least_cost(guide, body, has, collected):
    """Least cost of what a chaser still has to collect [m/s]; +inf where it cannot.

    Parameters
    ----------
    guide : CostGuide
    body : int
    has : Resources
        Those there.
    collected : float
        What it has collected.
    """
    if collected + _value(guide.free, body, has) < guide.worth:
        return np.inf
    return guide.price * (guide.worth - collected) - _value(guide.paying, body, has)
