"""Curves of phase over time between two planes, at nodes."""

from typing import NamedTuple

import numpy as np

NODES = 16
"""Number of interpolation nodes, a constant so that the compiler unrolls the loop over them."""


class Curves(NamedTuple):
    """Costs of the sequences of a pair by flight time, for each number of revolutions.

    Attributes
    ----------
    time : (revolutions + 1, nodes) float64
        Flight times of the nodes [s].
    coefficients : (revolutions + 1, 5, nodes) float64
        Newton's divided differences of the four numbers, and of ε (:mod:`.precession`) under J2;
        none where limits are wide.
    """

    time: np.ndarray
    coefficients: np.ndarray
