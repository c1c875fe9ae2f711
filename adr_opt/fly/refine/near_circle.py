"""Mean elements near a circle: of an integrated state, counted from its own node."""

from __future__ import annotations

import math

import numpy as np

from ...kernels.orbits import equinoctial
from ...kernels.orbits.short_periods import Array, mean_elements


def near_circle(state: Array, zonals: Array) -> Array:
    """Mean semi-major axis, eccentricity vector, inclination, node and argument of latitude.

    Parameters
    ----------
    state : (6,) float64
        Osculating and inertial [m, m/s].
    zonals : (3,) float64
        One of :data:`adr_opt.kernels.orbits.gravity.FIELDS`.

    Returns
    -------
    (6,) float64
        a [m], e cos ω, e sin ω, i, Ω, ω + M [rad].
    """
    frame = equinoctial.own_frame(state)
    mean = equinoctial.state_of(mean_elements(state, frame, zonals), frame)
    normal = np.cross(mean[:3], mean[3:])
    normal /= np.linalg.norm(normal)
    node = math.atan2(normal[0], -normal[1])
    to_node = np.array([math.cos(node), math.sin(node), 0.0])
    axes = np.array([to_node, np.cross(normal, to_node), normal])
    of = equinoctial.elements(mean, axes)
    inclination = math.acos(min(max(float(normal[2]), -1.0), 1.0))
    return np.array([of[0], of[1], of[2], inclination, node, of[5]])
