"""Interpolation of states between those of a table.

CCSDS 502.0-B names the methods: a polynomial of a degree through the nearest states, of positions
alone (Lagrange) or with their velocities as derivatives (Hermite).
"""

from __future__ import annotations

import numpy as np

from .ephemeris import Array

METHODS = ("LAGRANGE", "HERMITE", "LINEAR")
"""Supported values of INTERPOLATION."""

USUAL = "LAGRANGE", 7
"""Method and degree if a file states none: 8 positions are right to 2 mm in low orbit with 120 s
between them and to 5 cm with 180 s. SGP4's velocities are not the derivatives of its positions, so
that Hermite's method stalls at metres there."""

CHUNK = 65536
"""Number of times interpolated at once."""


def points_of(method: str, degree: int) -> int:
    """Number of states that a polynomial of some degree passes through."""
    if method == "LINEAR":
        return 2
    return degree + 1 if method == "LAGRANGE" else max(2, (degree + 2) // 2)


def interpolated(knots: Array, states: Array, times: Array, method: str, degree: int) -> Array:
    """States at times between those of a table.

    Parameters
    ----------
    knots : (states,) float64
        Times of the table, rising [s].
    states : (states, 6) float64
        [m, m/s].
    times : (times,) float64
        Within those of the table [s].
    method : {"LAGRANGE", "HERMITE", "LINEAR"}
    degree : int

    Returns
    -------
    (times, 6) float64
        Velocities by Lagrange's method are interpolated as positions are.
    """
    count = min(points_of(method, degree), knots.size)
    found = np.empty((times.size, 6))
    for begin in range(0, times.size, CHUNK):
        part = slice(begin, begin + CHUNK)
        # The interval of each time in the middle of its states, but for the ends of the table.
        first = np.searchsorted(knots, times[part], side="right") - (count + 1) // 2
        first = np.clip(first, 0, knots.size - count)
        window = first[:, None] + np.arange(count)
        if method == "HERMITE":
            found[part] = _hermite(knots[window], states[window], times[part])
        else:
            weights = _weights(knots[window], times[part])
            found[part] = np.einsum("tp,tpc->tc", weights, states[window])
    return found


def _weights(knots: Array, times: Array) -> Array:
    """Weights of the states in Lagrange's form, shape (times, states)."""
    count = knots.shape[1]
    weights = np.ones_like(knots)
    for one in range(count):
        for other in range(count):
            if other != one:
                weights[:, one] *= (times - knots[:, other]) / (knots[:, one] - knots[:, other])
    return weights


def _hermite(knots: Array, states: Array, times: Array) -> Array:
    """Positions and velocities by a polynomial with given values and derivatives."""
    count = knots.shape[1]
    middle, scale = 0.5 * (knots[:, :1] + knots[:, -1:]), knots[:, -1:] - knots[:, :1]
    scale = np.where(scale > 0.0, scale, 1.0)
    z = np.repeat((knots - middle) / scale, 2, axis=1)
    x = ((times[:, None] - middle) / scale)[:, 0]
    # Divided differences, with a derivative where two knots coincide (Newton's form).
    values = np.repeat(states[:, :, :3], 2, axis=1)
    slopes = np.repeat(states[:, :, 3:], 2, axis=1) * scale[:, :, None]
    table, coefficients = values, [values[:, 0]]
    for order in range(1, 2 * count):
        gap = z[:, order:] - z[:, :-order]
        step = table[:, 1:] - table[:, :-1]
        is_double = gap == 0.0
        quotient = step / np.where(is_double, 1.0, gap)[:, :, None]
        table = np.where(is_double[:, :, None], slopes[:, : step.shape[1]], quotient)
        coefficients.append(table[:, 0])
    position, velocity = coefficients[-1], np.zeros_like(coefficients[-1])
    for order in range(2 * count - 2, -1, -1):
        ahead = (x - z[:, order])[:, None]
        velocity = velocity * ahead + position
        position = position * ahead + coefficients[order]
    return np.column_stack((position, velocity / scale))
