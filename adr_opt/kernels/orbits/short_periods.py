"""Mean and osculating states: short-period variations by zonal harmonics, to first order.

Osculating elements swing about mean ones by what a revolution's perturbation is without its mean.
Gauss's equations give the rates of equinoctial elements along the mean orbit; their Fourier series
in the mean longitude, integrated term by term without a constant, is that swing. To first order
this is what Y. Kozai (Astronomical Journal 64, 1959, 367) and D. Brouwer (ibid., 378) wrote out in
closed form, but for every zonal harmonic, and regular for circles and every inclination because
the elements are taken in the frame of the mean orbit itself (R. Battin, An Introduction to the
Mathematics and Methods of Astrodynamics, revised edition, 1999, section 10.4, for the equations).
"""

from __future__ import annotations

import math

import numpy as np
import numpy.typing as npt

from ...common.constants import EARTH_RADIUS_M, MU_M3_S2
from . import equinoctial

Array = npt.NDArray[np.float64]

SAMPLES = 64
"""Samples per revolution: enough for eccentricities up to 0.3; more eccentric orbits take more."""

ROUNDS = 12
"""Iterations from osculating to mean elements; each gains three digits."""


def osculating(mean: Array, frame: Array, zonals: Array) -> Array:
    """The osculating state of a mean orbit.

    Parameters
    ----------
    mean : (6,) float64
        Mean equinoctial elements in the frame (:mod:`adr_opt.kernels.orbits.equinoctial`).
    frame : (3, 3) float64
        Rows are unit vectors; near the plane of the orbit.
    zonals : (3,) float64
        One of :data:`adr_opt.kernels.orbits.gravity.FIELDS`.

    Returns
    -------
    (6,) float64
        Inertial [m, m/s].
    """
    state: Array = equinoctial.state_of(mean, frame)
    own = equinoctial.own_frame(state)
    elements = equinoctial.elements(state, own)
    state = equinoctial.state_of(elements + swing(elements, own, zonals), own)
    return state


def mean_elements(state: Array, frame: Array, zonals: Array) -> Array:
    """Mean equinoctial elements of an osculating state: the inverse of :func:`osculating`."""
    given = equinoctial.elements(state, frame)
    mean: Array = given.copy()
    for _ in range(ROUNDS):
        reached = equinoctial.elements(osculating(mean, frame, zonals), frame)
        change = given - reached
        change[5] = math.remainder(change[5], math.tau)
        mean = mean + change
        if abs(change[0]) < 1e-6 and float(np.abs(change[1:]).max()) < 1e-13:
            break
    return mean


def swing(elements: Array, frame: Array, zonals: Array) -> Array:
    """Osculating minus mean elements at a point of a mean orbit in its own plane, shape (6,)."""
    if not zonals.any():
        return np.zeros(6)
    a, f, g = elements[:3]
    count = SAMPLES
    while (
        math.hypot(f, g) > 0.3 and count < 16 * SAMPLES and math.hypot(f, g) ** (count / 8) > 1e-8
    ):
        count *= 2
    longitudes = np.linspace(0.0, math.tau, count, endpoint=False)
    rates = _rates(a, f, g, longitudes, frame, zonals)
    series = np.fft.rfft(rates, axis=1) / count
    orders = np.arange(1, count // 2)
    turns = np.exp(1j * orders * elements[5])
    waves = series[:, 1 : count // 2] / (1j * orders)
    axis_wave = waves[0].copy()
    # A swing of the axis changes the pace: −3/2 of it in the longitude, integrated once more.
    waves[5] -= 1.5 / a * axis_wave / (1j * orders)
    found: Array = 2.0 * (waves * turns).real.sum(axis=1)
    return found


def _rates(a: float, f: float, g: float, longitudes: Array, frame: Array, zonals: Array) -> Array:
    """Rates of the elements due to the harmonics, per radian of mean longitude, shape (6, n)."""
    eccentric = longitudes.copy()
    for _ in range(50):
        error = eccentric + g * np.cos(eccentric) - f * np.sin(eccentric) - longitudes
        eccentric -= error / (1.0 - g * np.sin(eccentric) - f * np.cos(eccentric))
        if float(np.abs(error).max()) < 1e-14:
            break
    root = math.sqrt(1.0 - f * f - g * g)
    beta = 1.0 / (1.0 + root)
    c, s = np.cos(eccentric), np.sin(eccentric)
    x = a * ((1.0 - g * g * beta) * c + f * g * beta * s - f)
    y = a * ((1.0 - f * f * beta) * s + f * g * beta * c - g)
    r = np.hypot(x, y)
    cosine, sine = x / r, y / r
    outward = cosine[:, None] * frame[0] + sine[:, None] * frame[1]
    ahead = cosine[:, None] * frame[1] - sine[:, None] * frame[0]
    pull = _disturbing(r, outward, zonals)
    radial, along = np.sum(pull * outward, axis=1), np.sum(pull * ahead, axis=1)
    across = pull @ frame[2]
    n = math.sqrt(MU_M3_S2 / a**3)
    parameter = a * root * root
    w = 1.0 + f * cosine + g * sine
    q = math.sqrt(parameter / MU_M3_S2)
    f_rate = q * (radial * sine + ((w + 1.0) * cosine + f) * along / w)
    g_rate = q * (-radial * cosine + ((w + 1.0) * sine + g) * along / w)
    rates: Array = np.stack(
        [
            2.0 * a * q / (root * root) * ((f * sine - g * cosine) * radial + w * along),
            f_rate,
            g_rate,
            0.5 * q * cosine * across / w,
            0.5 * q * sine * across / w,
            -2.0 * r * radial / (n * a * a) + (f * g_rate - g * f_rate) * beta,
        ]
    )
    return rates / n


def _disturbing(r: Array, outward: Array, zonals: Array) -> Array:
    """Acceleration by the harmonics beyond a point mass, at unit vectors, shape (n, 3) [m/s²]."""
    s, q = outward[:, 2], EARTH_RADIUS_M / r
    c2, c3, c4 = (zonals[n - 2] * q**n for n in (2, 3, 4))
    along = 1.5 * c2 * (5.0 * s**2 - 1.0) + 2.5 * c3 * s * (7.0 * s**2 - 3.0)
    along = along + 1.875 * c4 * (21.0 * s**4 - 14.0 * s**2 + 1.0)
    polar = 3.0 * c2 * s + 1.5 * c3 * (5.0 * s**2 - 1.0) + 2.5 * c4 * s * (7.0 * s**2 - 3.0)
    pull: Array = along[:, None] * outward
    pull[:, 2] -= polar
    return MU_M3_S2 / r[:, None] ** 2 * pull
