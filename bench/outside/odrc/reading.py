"""The debris, and the orbit that chasers begin on."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from ..reading import FloatArray, filled_lines, numbers_of, published

FILE = "odrc.csv"
HEADER = "a[m],e[prop],i[rad],r[rad],o[rad],t[rad]"


@published
def read_debris(path: Path) -> FloatArray:
    """The debris of a file, in their order.

    Returns
    -------
    (debris, 6) float64
        Semi-major axis [m], eccentricity, inclination, RAAN, argument of perigee and true anomaly
        [rad] at t = 0.
    """
    header, *lines = filled_lines(path)
    if header != HEADER:
        raise ValueError(f"the first line is not {HEADER!r}")
    return np.array([numbers_of(line, 6, ",") for line in lines])


def with_centroid(debris: FloatArray) -> FloatArray:
    """The orbit on which chasers begin, and after it the debris.

    Its size and inclination are the means of theirs; its angles, the directions in the mean.
    """
    shape = debris[:, :3].mean(axis=0)
    angles = np.arctan2(np.sin(debris[:, 3:]).sum(axis=0), np.cos(debris[:, 3:]).sum(axis=0))
    return np.vstack([np.concatenate([shape, angles % (2.0 * np.pi)]), debris])
