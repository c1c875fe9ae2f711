"""Error model of a flight.

Burns follow the proportional part of C. Gates's model (A Simplified Model of Midcourse Maneuver
Execution Errors, JPL Technical Report 32-504, 1963): an error along the burn and one across it, in
both directions alike, each normal, without bias, and as large as the burn makes it. The parts that
do not depend on the size of a burn are taken to be none.
"""

from __future__ import annotations

import math
from dataclasses import asdict, dataclass

import numpy as np

from ...common.errors import InputError
from ...kernels.orbits.short_periods import Array

MOST_MAGNITUDE, MOST_POINTING_DEG = 0.2, 10.0
MOST_POSITION_M, MOST_VELOCITY_M_S = 1e5, 100.0
"""Largest accepted errors: beyond them, burns and trajectories are far from the planned ones."""


@dataclass(frozen=True)
class FlightErrors:
    """Standard deviations of the errors of a flight.

    Attributes
    ----------
    burn_magnitude : float
        Of the size of a burn, as a share of it.
    burn_pointing_deg : float
        Of its direction, about each of the two axes across it [deg].
    navigation_position_m, navigation_velocity_m_s : float
        Of where the chaser is when a leg begins, on each axis [m], [m/s].

    Raises
    ------
    InputError
        One is negative, not a number, or too large to be meant.
    """

    burn_magnitude: float = 0.005
    burn_pointing_deg: float = 0.5
    navigation_position_m: float = 10.0
    navigation_velocity_m_s: float = 0.01

    def __post_init__(self) -> None:
        for name, most in (
            ("burn_magnitude", MOST_MAGNITUDE),
            ("burn_pointing_deg", MOST_POINTING_DEG),
            ("navigation_position_m", MOST_POSITION_M),
            ("navigation_velocity_m_s", MOST_VELOCITY_M_S),
        ):
            value = getattr(self, name)
            if not 0.0 <= value <= most:
                raise InputError(f"{name} = {value:g}: must lie between 0 and {most:g}")

    def of_departure(self, drawn: Array) -> Array:
        """Errors of the state at departure from standard normal numbers, shape (6, n)."""
        found: Array = drawn.copy()
        found[:3] *= self.navigation_position_m
        found[3:] *= self.navigation_velocity_m_s
        return found

    def of_burns(self, burns: Array, drawn: Array) -> Array:
        """Executed burns from standard normal numbers, both of shape (3, n) [m/s].

        An isotropic vector falls apart into independent parts along a burn and across it, so that
        three numbers a burn are enough.
        """
        square = np.sum(burns * burns, axis=0)
        share = np.sum(drawn * burns, axis=0) / np.maximum(square, 1e-300)
        along = share * burns
        pointing = math.radians(self.burn_pointing_deg)
        across = drawn - along
        found: Array = burns + np.sqrt(square) * (self.burn_magnitude * along + pointing * across)
        return found

    def to_dict(self) -> dict[str, float]:
        """The errors as plain data."""
        return asdict(self)
