"""Uniform random numbers, identical on every machine, and orbits drawn with them."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np

from ...common.constants import EARTH_RADIUS_M
from ...problem.orbit import Orbit

LARGEST_SEED = 2**63 - 1

Uniform = Callable[[float, float], float]
"""Function that draws a number between two limits."""


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


Range = tuple[float, float]


def rounded(
    semi_major_axis_m: float,
    eccentricity: float,
    inclination_deg: float,
    raan_deg: float,
    argument_of_perigee_deg: float,
    true_anomaly_deg: float,
) -> Orbit:
    """An orbit, rounded to the digits of the file."""
    return Orbit(
        semi_major_axis_m=round(semi_major_axis_m, 3),
        eccentricity=round(eccentricity, 7),
        inclination_deg=round(inclination_deg, 6),
        raan_deg=round(raan_deg, 6),
        argument_of_perigee_deg=round(argument_of_perigee_deg, 6),
        true_anomaly_deg=round(true_anomaly_deg, 6),
    )


def draw_ellipse(
    uniform: Uniform,
    altitude_km: Range,
    inclination_deg: Range,
    eccentricity: Range,
    raan_deg: Range,
) -> Orbit:
    """An orbit drawn from ranges of elements.

    Perigee and anomaly go all around. The altitude is that of the semi-major axis.
    """
    altitude, inclination = uniform(*altitude_km), uniform(*inclination_deg)
    return rounded(
        EARTH_RADIUS_M + 1e3 * altitude,
        uniform(*eccentricity),
        inclination,
        uniform(*raan_deg),
        uniform(0.0, 360.0),
        uniform(0.0, 360.0),
    )
