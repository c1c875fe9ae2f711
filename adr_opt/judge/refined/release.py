"""Orbits on which objects are released, for the judge: means of osculating elements over a lap."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from ...common.constants import EARTH_RADIUS_M, MU_M3_S2
from .propagation import advance, elements_of

PLACES = 144
"""Number of times in a revolution over which elements are averaged."""

STEPS = 2
"""Integration steps between two of those times."""


class Released(NamedTuple):
    """The orbit of a released object.

    Attributes
    ----------
    altitude_m : float
        Mean semi-major axis above the radius of the Earth.
    eccentricity : float
        Of the mean eccentricity vector.
    """

    altitude_m: float
    eccentricity: float


def released(state: npt.NDArray[np.float64], zonals: npt.NDArray[np.float64]) -> Released:
    """Mean size and shape of the orbit from a state on.

    Harmonics change both within a revolution, by some kilometres; their means over one do not
    change to first order.

    Parameters
    ----------
    state : (6,) float64
        [m, m/s].
    zonals : (3,) float64
        J2, J3 and J4.
    """
    elements = elements_of(state)
    revolution = math.tau * math.sqrt(_axis(elements) ** 3 / MU_M3_S2)
    axes, shapes = np.empty(PLACES), np.empty((PLACES, 2))
    for place in range(PLACES):
        axes[place], shapes[place] = _axis(elements), elements[1:3]
        advance(elements, revolution / PLACES, STEPS, zonals)
    return Released(float(axes.mean()) - EARTH_RADIUS_M, math.hypot(*shapes.mean(axis=0)))


def _axis(elements: npt.NDArray[np.float64]) -> float:
    return float(elements[0] / (1.0 - elements[1] ** 2 - elements[2] ** 2))
