"""Gravity of the Earth with the zonal harmonics J2, J3 and J4, and its gradient.

With s = z/r and Legendre's polynomials P_n the potential is μ/r (1 − Σ J_n (R/r)ⁿ P_n(s)). Its
first and second derivatives simplify by P′_{n+1} = (n+1) P_n + s P′_n (O. Montenbruck and E. Gill,
Satellite Orbits, 2000, section 3.2, for the potential; the derivatives are worked out here).
"""

import math

import numpy as np

from ...common.constants import EARTH_RADIUS_M, J2, MU_M3_S2
from ..core.compile import inlined

J3 = -2.53265649e-6
"""Third zonal harmonic of the Earth, −√7 C̄₃₀ of EGM-96."""

J4 = -1.61962159e-6
"""Fourth zonal harmonic of the Earth, −3 C̄₄₀ of EGM-96."""

FIELDS = {
    "two-body": np.array([0.0, 0.0, 0.0]),
    "j2": np.array([J2, 0.0, 0.0]),
    "j3": np.array([J2, J3, 0.0]),
    "j4": np.array([J2, J3, J4]),
}
"""The harmonics (J2, J3, J4) of each gravity field available to flights."""
for _field in FIELDS.values():
    _field.setflags(write=False)


@inlined
def pull(x, y, z, zonals):
    """Acceleration of free motion.

    Parameters
    ----------
    x, y, z : float
        Inertial position, z along the axis of the Earth [m].
    zonals : (3,) float64
        One of :data:`FIELDS`.

    Returns
    -------
    x, y, z : float
        [m/s²].
    """
    square = x * x + y * y + z * z
    r = math.sqrt(square)
    s = z / r
    q = EARTH_RADIUS_M / r
    c2 = zonals[0] * q * q
    outward = c2 * 1.5 * (5.0 * s * s - 1.0)
    polar = c2 * 3.0 * s
    if zonals[1] != 0.0 or zonals[2] != 0.0:
        c3, c4 = zonals[1] * q**3, zonals[2] * q**4
        outward += c3 * 2.5 * s * (7.0 * s * s - 3.0)
        outward += c4 * 1.875 * (21.0 * s**4 - 14.0 * s * s + 1.0)
        polar += c3 * 1.5 * (5.0 * s * s - 1.0) + c4 * 2.5 * s * (7.0 * s * s - 3.0)
    strength = MU_M3_S2 / square
    along = strength * (outward - 1.0) / r
    return along * x, along * y, along * z - strength * polar


@inlined
def gradient(x, y, z, zonals, out):
    """The symmetric matrix ∂(acceleration)/∂(position), shape (3, 3) [1/s²]; written to ``out``."""
    square = x * x + y * y + z * z
    r = math.sqrt(square)
    u, v, s = x / r, y / r, z / r
    q = EARTH_RADIUS_M / r
    c2, c3, c4 = zonals[0] * q * q, zonals[1] * q**3, zonals[2] * q**4
    t = s * s
    # Factors of the identity, of r̂ r̂ᵀ, of r̂ ẑᵀ + ẑ r̂ᵀ and of ẑ ẑᵀ.
    unit = -1.0 + c2 * 1.5 * (5.0 * t - 1.0)
    unit += c3 * 2.5 * s * (7.0 * t - 3.0) + c4 * 1.875 * (21.0 * t * t - 14.0 * t + 1.0)
    radial = 3.0 - c2 * 7.5 * (7.0 * t - 1.0)
    radial -= c3 * 52.5 * s * (3.0 * t - 1.0) + c4 * 13.125 * (33.0 * t * t - 18.0 * t + 1.0)
    mixed = c2 * 15.0 * s + c3 * 7.5 * (7.0 * t - 1.0) + c4 * 52.5 * s * (3.0 * t - 1.0)
    polar = -3.0 * c2 - 15.0 * s * c3 - c4 * 7.5 * (7.0 * t - 1.0)
    k = MU_M3_S2 / (square * r)
    out[0, 0] = k * (unit + radial * u * u)
    out[1, 1] = k * (unit + radial * v * v)
    out[2, 2] = k * (unit + radial * t + 2.0 * mixed * s + polar)
    out[0, 1] = out[1, 0] = k * radial * u * v
    out[0, 2] = out[2, 0] = k * (radial * u * s + mixed * u)
    out[1, 2] = out[2, 1] = k * (radial * v * s + mixed * v)
