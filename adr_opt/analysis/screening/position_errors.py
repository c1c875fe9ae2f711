"""Position errors: covariances and sizes of objects, from a file."""

from __future__ import annotations

import math
import os
from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from ...common.errors import InputError
from ...sources.csv_table import named_numbers

Array = npt.NDArray[np.float64]

COLUMNS = ("object", "radius_m", "cr_r_m2", "ct_r_m2", "ct_t_m2", "cn_r_m2", "cn_t_m2", "cn_n_m2")
"""Columns of a file of position errors; covariances as in a table of target errors."""

EVERYBODY = "*"
"""Name of the row for objects without a row of their own."""


@dataclass(frozen=True)
class PositionErrors:
    """Position covariance and radius of an object.

    Attributes
    ----------
    radius_m : float
        Of a sphere that holds it [m].
    covariance_m2 : (3, 3) float64
        Of its position: radial, along, and along its angular momentum [m²].
    """

    radius_m: float
    covariance_m2: Array

    def turned(self, state: Array) -> Array:
        """The covariance in the axes of a state of the object, shape (3, 3) [m²]."""
        axes = orbital_axes(state)
        turned: Array = axes.T @ self.covariance_m2 @ axes
        return turned


def orbital_axes(state: Array) -> Array:
    """Unit vectors radial, along-track and along the angular momentum as rows, shape (3, 3)."""
    radial = state[:3] / np.linalg.norm(state[:3])
    momentum = np.cross(state[:3], state[3:])
    cross = momentum / np.linalg.norm(momentum)
    return np.array([radial, np.cross(cross, radial), cross])


def errors_of(errors: Mapping[str, PositionErrors], *names: str | None) -> PositionErrors | None:
    """The errors of an object by its first known name, else those of the default row."""
    found = (errors[name] for name in (*names, EVERYBODY) if name is not None and name in errors)
    return next(found, None)


def read_errors(path: str | os.PathLike[str]) -> dict[str, PositionErrors]:
    """Position errors of a CSV file with the columns :data:`COLUMNS`, by name.

    Raises
    ------
    InputError
        It cannot be read or has other columns, a value is no number, a covariance is none, or a
        name stands twice.
    """
    found: dict[str, PositionErrors] = {}
    for where, name, numbers in named_numbers(str(path), COLUMNS):
        radius, rr, tr, tt, nr, nt, nn = numbers
        covariance = np.array([[rr, tr, nr], [tr, tt, nt], [nr, nt, nn]])
        if not 0.0 < radius < math.inf:
            raise InputError(f"{where}: radius_m = {radius:g}: must be a positive number of metres")
        if not np.isfinite(covariance).all() or np.linalg.eigvalsh(covariance)[0] <= 0.0:
            raise InputError(f"{where}: the covariance must be positive definite, in m²")
        found[name] = PositionErrors(radius, covariance)
    return found
