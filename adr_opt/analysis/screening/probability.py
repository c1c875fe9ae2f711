"""Probability of a collision in a short encounter."""

from __future__ import annotations

import math

import numpy as np
import numpy.typing as npt

Array = npt.NDArray[np.float64]

SPREAD = 12.0
"""Standard deviations beyond which a normal distribution is negligible."""

PRECISION = 1e-10
"""Relative precision of the integral."""

NOTHING = 1e-30
"""Probability below which precision does not matter."""


def collision_probability(
    apart_m: Array, rate_m_s: Array, covariance_m2: Array, radius_m: float
) -> float:
    """Probability that two objects come within a distance, in two dimensions.

    In a short encounter the relative motion is straight, and what lies along it does not matter:
    the normal distribution of the relative position is integrated over a disc across the relative
    velocity (Foster and Estes, NASA JSC-25898, 1992). Along the one axis of the distribution the
    integral is a difference of error functions, as in Alfano, *A numerical implementation of
    spherical object collision probability*, J. Astronautical Sciences 53(1), 2005.

    Parameters
    ----------
    apart_m, rate_m_s : (3,) float64
        Of the one object from the other at the least distance, in any axes [m, m/s].
    covariance_m2 : (3, 3) float64
        Of the relative position, the sum of both if they are independent [m²].
    radius_m : float
        Sum of both radii [m].
    """
    from scipy.integrate import quad

    along = rate_m_s / np.linalg.norm(rate_m_s)
    miss = apart_m - (apart_m @ along) * along
    across = np.linalg.svd(along[None])[2][1:]
    variances, axes = np.linalg.eigh(across @ covariance_m2 @ across.T)
    one, other = np.sqrt(variances).tolist()
    x, y = np.abs(axes.T @ (across @ miss)).tolist()

    def slice_at(turn: float) -> float:
        u, half = radius_m * math.sin(turn), radius_m * math.cos(turn)
        # Far out, the complements differ in more digits than the functions themselves.
        scale = math.sqrt(2.0) * one
        inside = math.erfc((x - half) / scale) - math.erfc((x + half) / scale)
        return half * inside * math.exp(-0.5 * ((u - y) / other) ** 2)

    # Beyond some deviations the integrand is nothing, and a rule might miss what is narrow.
    low, high = max(-radius_m, y - SPREAD * other), min(radius_m, y + SPREAD * other)
    if low >= high:
        return 0.0
    turns = math.asin(low / radius_m), math.asin(high / radius_m)
    total, _ = quad(slice_at, *turns, epsabs=NOTHING, epsrel=PRECISION, limit=200)
    return float(total / (2.0 * math.sqrt(2.0 * math.pi) * other))
