"""ΔV of a leg of low thrust, from one orbit to another as they are at departure.

Every element but the fast one is changed at its greatest rate; the parts are added as squares. With
modified equinoctial elements x = (a, f, g, h, k) and the greatest rates ẋ per unit of thrust,

    ΔV = 1.5 sqrt( Σ ((x_i − x_j) / ẋ_i)² ),    duration = ΔV / thrust,

where nodes and perigees drift by their secular J2 rates.
"""

from __future__ import annotations

import numpy as np

from ..reading import FloatArray

MU_M3_S2, EARTH_RADIUS_M, J2 = 3.986004e14, 6.378137e6, 1.082626e-3
"""Constants of the estimate [m³/s²], [m]."""

FACTOR, THRUST_M_S2 = 1.5, 3e-3


def equinoctial(bodies: FloatArray, times_s: FloatArray) -> FloatArray:
    """Modified equinoctial elements a, f, g, h, k of bodies at times.

    Parameters
    ----------
    bodies : (bodies, 6) float64
        As read: [m], –, [rad].
    times_s : (times,) float64

    Returns
    -------
    (5, times, bodies) float64
        a [m]; the others without dimension.
    """
    axis, eccentricity, inclination, raan, perigee, _ = bodies.T
    motion = np.sqrt(MU_M3_S2 / axis**3)
    strength = 1.5 * J2 * (EARTH_RADIUS_M / (axis * (1.0 - eccentricity**2))) ** 2 * motion
    node_rate = -strength * np.cos(inclination)
    perigee_rate = strength * (2.0 - 2.5 * np.sin(inclination) ** 2)
    node = raan + node_rate * times_s[:, None]
    longitude = node + perigee + perigee_rate * times_s[:, None]
    tangent = np.tan(0.5 * inclination)
    return np.array(
        [
            np.broadcast_to(axis, node.shape),
            eccentricity * np.cos(longitude),
            eccentricity * np.sin(longitude),
            tangent * np.cos(node),
            tangent * np.sin(node),
        ]
    )


def greatest_rates(elements: FloatArray) -> FloatArray:
    """The greatest rates of a, f, g, h, k per unit of thrust, of the same shape [s], [1/(m/s)]."""
    axis, f, g, h, k = elements
    square = f * f + g * g
    eccentricity = np.sqrt(square)
    slow = np.sqrt(axis * (1.0 - square) / MU_M3_S2)
    wide = 1.0 + h * h + k * k
    return np.array(
        [
            2.0 * np.sqrt(axis**3 * (1.0 + eccentricity) / (MU_M3_S2 * (1.0 - eccentricity))),
            2.0 * slow,
            2.0 * slow,
            0.5 * slow * wide / (np.sqrt(1.0 - g * g) + f),
            0.5 * slow * wide / (np.sqrt(1.0 - f * f) + g),
        ]
    )


def matrices(bodies: FloatArray, departures_s: FloatArray) -> tuple[FloatArray, FloatArray]:
    """All legs at given departures.

    Returns
    -------
    duration, delta_v : (departures, bodies, bodies) float64
        By origin and destination [s], [m/s]; infinite from a body to itself.
    """
    at = equinoctial(bodies, departures_s)
    off = at[:, :, :, None] - at[:, :, None, :]
    parts = off / greatest_rates(at)[:, :, :, None]
    delta_v = FACTOR * np.sqrt((parts * parts).sum(axis=0))
    delta_v[:, range(len(bodies)), range(len(bodies))] = np.inf
    return delta_v / THRUST_M_S2, delta_v
