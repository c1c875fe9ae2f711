"""The debris, and the orbit that chasers begin on."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from adr_opt.common.errors import InputError

from ..reading import FloatArray, filled_lines, numbers_of

FILE = "odrc.csv"
HEADER = "a[m],e[prop],i[rad],r[rad],o[rad],t[rad]"


def read_debris(path: Path) -> FloatArray:
    """The debris of a file, in their order.

    Returns
    -------
    (debris, 6) float64
        Semi-major axis [m], eccentricity, inclination, RAAN, argument of perigee and true anomaly
        [rad] at t = 0.
    """
    lines = list(filled_lines(path))
    if not lines or lines[0][1] != HEADER:
        raise InputError(f"{path}: the first line must be {HEADER!r}; give the file as it is")
    rows = []
    for number, line in lines[1:]:
        where = f"{path}: line {number}"
        row = numbers_of(line, 6, where, ",")
        if row[0] <= 0.0 or not 0.0 <= row[1] < 1.0:
            raise InputError(f"{where}: no closed orbit; give the file as it is")
        rows.append(row)
    if not rows:
        raise InputError(f"{path}: no debris in it; give the file as it is")
    return np.array(rows)


def with_centroid(debris: FloatArray) -> FloatArray:
    """The orbit on which chasers begin, and after it the debris.

    Its size and inclination are the means of theirs; its angles, the directions in the mean.
    """
    shape = debris[:, :3].mean(axis=0)
    angles = np.arctan2(np.sin(debris[:, 3:]).sum(axis=0), np.cos(debris[:, 3:]).sum(axis=0))
    return np.vstack([np.concatenate([shape, angles % (2.0 * np.pi)]), debris])
