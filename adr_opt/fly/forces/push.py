"""Low thrust for the library: windows of a leg, and the law of their steering."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from typing import NamedTuple

import numpy as np

from ...kernels.orbits.short_periods import Array
from ...plan.refined_thrust import RefinedThrust


class PushedWindow(NamedTuple):
    """Thrust over a window.

    Attributes
    ----------
    begin_s, end_s : float
    steering : tuple of float
        A to E of docs/model.md section 11.6.
    mass_kg : float
        At its beginning.
    force_n, flow_kg_s : float
    """

    begin_s: float
    end_s: float
    steering: tuple[float, float, float, float, float]
    mass_kg: float
    force_n: float
    flow_kg_s: float

    def law(self, start_s: float, axes: Array) -> Callable[[float, Array, object], Array]:
        """Acceleration as the library asks for it: rates of a state, in its axes.

        Parameters
        ----------
        start_s : float
            What its times count from.
        axes : (3, 3) float64
            From the frame of the plan to that of the library.
        """
        # The node is told by the third axis of the plan, as it is seen in the library.
        pole = np.ascontiguousarray(axes[:, 2])
        begin_s = self.begin_s - start_s

        def rates(time_s: float, state: Array, parameters: object) -> Array:
            mass = self.mass_kg - self.flow_kg_s * (time_s - begin_s)
            found = np.zeros(6)
            found[3:] = self.force_n / mass * direction(state, pole, self.steering)
            return found

        return rates


def direction(
    state: Array, pole: Array, steering: tuple[float, float, float, float, float]
) -> Array:
    """Unit vector of thrust at a state, latitudes counted from the equator of a pole."""
    a, b, c, d, e = steering
    place = state[:3]
    outward = place / math.sqrt(place @ place)
    momentum = _cross(place, state[3:])
    normal = momentum / math.sqrt(momentum @ momentum)
    node = _cross(pole, normal)
    node /= math.sqrt(node @ node)
    cosine, sine = float(node @ outward), float(_cross(normal, node) @ outward)
    along = c + 2.0 * (a * cosine + b * sine)
    found = (a * sine - b * cosine) * outward + along * _cross(normal, outward)
    found += (d * cosine + e * sine) * normal
    unit: Array = found / math.sqrt(found @ found)
    return unit


def _cross(first: Array, second: Array) -> Array:
    """Vector product; NumPy's takes several times as long."""
    a, b, c = first
    x, y, z = second
    return np.array([b * z - c * y, c * x - a * z, a * y - b * x])


def pushes(thrust: RefinedThrust) -> Iterator[PushedWindow]:
    """Windows of a leg in order, with the mass at the beginning of each."""
    flow, mass = thrust.force_n / thrust.exhaust_m_s, thrust.mass_kg
    for arc in thrust.arcs:
        for begin_s, end_s in arc.windows_s:
            yield PushedWindow(begin_s, end_s, arc.steering, mass, thrust.force_n, flow)
            mass -= flow * (end_s - begin_s)
