"""Connections of a pair as arrays."""

from typing import NamedTuple

import numpy as np

SHORT, DRIFT, LAUNCH, GIVEN, LOW_THRUST = range(5)
"""Numbers of the built-in families of legs; registered families follow."""


class ConnectionArrays(NamedTuple):
    """Connections of a pair, in order of departure, then of arrival.

    Attributes
    ----------
    departure, arrival, delta_v : (connections,) float64
        [s], [s], [m/s]. The arrival is the end of the approach.
    revolutions : (connections,) int8
        Phasing revolutions k; 0 of given connections.
    crossing : (connections,) int32
        Those of one crossing arrive at one time, up to rounding; the later the crossing, the later.
    family : (connections,) int8
        Number of the family of legs that each is of.
    """

    departure: np.ndarray
    arrival: np.ndarray
    delta_v: np.ndarray
    revolutions: np.ndarray
    crossing: np.ndarray
    family: np.ndarray
