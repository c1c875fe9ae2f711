"""Uniform random numbers, identical on every machine."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np

LARGEST_SEED = 2**63 - 1

Uniform = Callable[[float, float], float]
"""Draws a number between two limits."""


def stream(seed: int, purpose: int) -> Uniform:
    """A source of uniform numbers, independent for different purposes of one seed.

    Raw PCG-64 output and IEEE arithmetic: NumPy's distributions may change between versions, and
    functions such as log and sin differ between machines.
    """
    bits = np.random.PCG64(np.random.SeedSequence([purpose, seed]))

    def uniform(low: float, high: float) -> float:
        return low + (high - low) * ((int(bits.random_raw()) >> 11) * 2.0**-53)

    return uniform


def at_percentile(percentiles: Sequence[float], values: Sequence[float], share: float) -> float:
    """Quantile of a population at a share, linear between known percentiles.

    With a uniform ``share`` this draws from the population, by + − × / alone.

    Parameters
    ----------
    percentiles : sequence of float
        Ascending, from 0 to 100.
    values : sequence of float
        The values at these percentiles.
    share : float
        Between 0 and 1.
    """
    percentile = 100.0 * share
    k = 1
    while k < len(percentiles) - 1 and percentile > percentiles[k]:
        k += 1
    width = percentiles[k] - percentiles[k - 1]
    return values[k - 1] + (values[k] - values[k - 1]) * ((percentile - percentiles[k - 1]) / width)
