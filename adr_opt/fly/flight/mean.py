"""Mean dynamics of J2, restated for `fly` (docs/model.md sections 1 and 2).

Nothing of :mod:`adr_opt.kernels` is used here but constants: elements are moved by their rates in
boinor's terms, and coasts by its propagator, so that an error in one of the two shows.
"""

from __future__ import annotations

import math

import numpy as np

from ...common.constants import EARTH_RADIUS_M, J2
from ...problem.orbit import Orbit
from .two_body import State, TwoBody


class MeanDynamics(TwoBody):
    """Orbits with drifting nodes, and coasts on arcs with drifting planes.

    A coast between burns is Kepler motion within its plane, at the pace at which the mean argument
    of latitude of a circle of its semi-major axis advances; the plane turns with the node. Its
    apsides stay where they are from the node.
    """

    def body(self, orbit: Orbit, time_s: float) -> State:
        """Position [m] and velocity [m/s] of a body at a time, on its planning circle."""
        a, e = orbit.semi_major_axis_m, orbit.eccentricity
        inclination = math.radians(orbit.inclination_deg)
        n, half = self._pull(a, a * (1.0 - e * e))
        square = math.cos(inclination) ** 2
        perigee_rate = half * (5.0 * square - 1.0)
        anomaly_rate = n + half * math.sqrt(1.0 - e * e) * (3.0 * square - 1.0)
        position, velocity = self.circle_at_epoch(orbit)
        # From the epoch on along the circle: by the mean latitude, not by the time.
        gone = math.remainder((perigee_rate + anomaly_rate) * time_s, math.tau)
        position, velocity = super().coast((position, velocity), gone / n)
        node = -2.0 * half * math.cos(inclination) * time_s
        return _turned(position, node), _turned(velocity, node)

    def coast(self, state: State, time_s: float) -> State:
        """State after a coast.

        Raises
        ------
        ArithmeticError
            The orbit is not closed, or the propagator finds no answer.
        """
        position, velocity = state
        inverse_axis = 2.0 / math.hypot(*position) - float(velocity @ velocity) / self._mu
        if not inverse_axis > 0.0:
            raise ArithmeticError(f"at {math.hypot(*velocity):.6g} m/s the chaser leaves the Earth")
        axis = 1.0 / inverse_axis
        momentum = np.cross(position, velocity)
        cosine = momentum[2] / math.hypot(*momentum)
        n, half = self._pull(axis, axis)
        pace = 1.0 + half / n * (8.0 * cosine * cosine - 2.0)
        position, velocity = super().coast(state, pace * time_s)
        node = -2.0 * half * cosine * time_s
        return _turned(position, node), _turned(velocity, node)

    def _pull(self, axis: float, parameter: float) -> tuple[float, float]:
        """Mean motion, and the common factor ¾ J2 n (R/p)² of all rates [rad/s]."""
        n = math.sqrt(self._mu / axis**3)
        return n, 0.75 * J2 * n * (EARTH_RADIUS_M / parameter) ** 2


def _turned(vector: np.ndarray, angle: float) -> np.ndarray:
    """A vector rotated about the axis of the Earth."""
    c, s = math.cos(angle), math.sin(angle)
    x, y, z = vector
    return np.array([c * x - s * y, s * x + c * y, z])
