"""Relative speeds of encounters by inclinations (docs/worth.md, equation 5)."""

from __future__ import annotations

from functools import cache

import numpy as np

from .air import FLOAT

STEP_DEG = 2
"""Step of inclinations of the table."""

POINTS = 2000
"""Points in latitude; the integrand has a logarithmic peak where inclinations nearly agree."""


@cache
def mean_speeds() -> FLOAT:
    """Mean relative speed of encounters over the speed of both orbits.

    Returns
    -------
    (tilt, tilt) float64
        By inclinations from 0° to 180°, :data:`STEP_DEG` apart. The mean is over encounters, not
        over time: fast ones count more.
    """
    # Half a step off the equator and the pole, where directions and latitudes degenerate.
    tilts = np.radians(np.clip(np.arange(0, 181, STEP_DEG), 0.25, 179.75))
    angles = 0.5 * np.pi * (np.arange(POINTS) + 0.5) / POINTS
    table = np.empty((len(tilts), len(tilts)))
    for row, tilt in enumerate(tilts):
        for column in range(row, len(tilts)):
            table[row, column] = table[column, row] = _mean(tilt, tilts[column], angles)
    table.setflags(write=False)
    return table


def _mean(tilt: float, other: float, angles: FLOAT) -> float:
    """Mean of the squared relative speed over that of the speed, over latitudes both reach."""
    low, high = sorted((np.sin(tilt), np.sin(other)))
    sines = low * np.sin(angles)
    cosines = 1.0 - sines**2
    density = 1.0 / np.sqrt(np.maximum(high**2 - sines**2, 1e-12))
    along = np.cos(tilt) * np.cos(other) / cosines
    across = np.sqrt(np.maximum(1.0 - np.cos(tilt) ** 2 / cosines, 0.0))
    across *= np.sqrt(np.maximum(1.0 - np.cos(other) ** 2 / cosines, 0.0))
    squares = [2.0 * np.maximum(1.0 - along + sign * across, 0.0) for sign in (1.0, -1.0)]
    first = sum(float(density @ square) for square in squares)
    second = sum(float(density @ np.sqrt(square)) for square in squares)
    return first / second
