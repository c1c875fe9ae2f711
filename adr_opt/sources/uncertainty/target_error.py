"""The error of a body's stated position: a covariance at a time."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

import numpy as np
import numpy.typing as npt

from ...common.errors import InputError

Array = npt.NDArray[np.float64]

Coordinates = Literal["rtn", "inertial", "elements"]

LEAST_EIGENVALUE = -1e-6
"""Negative eigenvalues of correlations above this count as rounded zeros."""


@dataclass(frozen=True, eq=False)
class TargetError:
    """Covariance of a body's state at a time, and of its decay.

    Attributes
    ----------
    covariance : (7, 7) float64
        Of six coordinates and of ``decay_m_per_day``, the speed at which its semi-major axis falls
        beyond what is said.
    coordinates : {"rtn", "inertial", "elements"}
        ``rtn``: inertial position [m] and velocity [m/s] along the axes outward, along the track
        and across it; ``inertial``: along those of the instance. ``elements``: mean equinoctial
        elements in the frame of the first axes, as lengths [m]: semi-major axis a, then a times
        each of the eccentricity vector (two), of the turn of the plane (two) and of the mean
        longitude.
    since_s : float
        Time after the epoch of the instance at which it holds [s].

    Raises
    ------
    InputError
        It is no covariance: not symmetric, or some combination has a negative variance.
    """

    covariance: Array
    coordinates: Coordinates = "rtn"
    since_s: float = 0.0

    def __post_init__(self) -> None:
        size = np.abs(self.covariance).max()
        if not np.allclose(self.covariance, self.covariance.T, rtol=1e-6, atol=1e-12 * size):
            raise InputError("the covariance is not symmetric; give the same value on both sides")
        if (np.diag(self.covariance) < 0.0).any():
            raise InputError("the covariance has a negative variance; correct its diagonal")
        values = np.linalg.eigvalsh(self._correlations()[0])
        if values[0] < LEAST_EIGENVALUE:
            raise InputError(
                "the covariance is not positive semidefinite: some combination of its coordinates "
                "has a negative variance; correct it"
            )

    def __bool__(self) -> bool:
        """Whether there is an error."""
        return bool(self.covariance.any())

    def factor(self) -> Array:
        """A matrix F with F Fᵀ the covariance, shape (7, 7).

        By the symmetric root of the correlations: there is one, whatever basis equal eigenvalues
        come with, so that equal seeds draw alike on every machine.
        """
        correlations, sigmas = self._correlations()
        values, vectors = np.linalg.eigh(correlations)
        root = (vectors * np.sqrt(np.maximum(values, 0.0))) @ vectors.T
        found: Array = sigmas[:, None] * root
        return found

    def _correlations(self) -> tuple[Array, Array]:
        """Correlations, shape (7, 7), and standard deviations, (7,)."""
        sigmas = np.sqrt(np.diag(self.covariance))
        scale = np.where(sigmas > 0.0, sigmas, 1.0)
        return self.covariance / np.outer(scale, scale), sigmas
