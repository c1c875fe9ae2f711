"""What targets do within spans of time, and what legs between them cost at least at any time."""

import math

import numpy as np

from adr_opt.kernels.core.compile import kernel

from . import kepler


@kernel
def spans(elements, times, half, out):
    """What a target does within ``half`` of each of some times.

    Parameters
    ----------
    elements : (6,) float64
    times : (times,) float64
        [s].
    half : float
        [s].
    out : (times, 10) float64
        Is filled: direction (3), angle that it may be off [rad], least and largest distance [m],
        radial velocity and transverse velocity, each least and largest [m/s].
    """
    axis, e = elements[0], elements[1]
    p = axis * (1.0 - e * e)
    unit = math.sqrt(kepler.MU_MOON_M3_S2 / p)
    fastest = math.sqrt(kepler.MU_MOON_M3_S2 * p) / (axis * (1.0 - e)) ** 2
    off = fastest * half
    r, v = np.empty(3), np.empty(3)
    for k in range(times.size):
        kepler.state(elements, times[k], r, v)
        length = math.sqrt(r[0] * r[0] + r[1] * r[1] + r[2] * r[2])
        for place in range(3):
            out[k, place] = r[place] / length
        radial = (r[0] * v[0] + r[1] * v[1] + r[2] * v[2]) / length
        across = math.sqrt(kepler.MU_MOON_M3_S2 * p) / length
        out[k, 3] = off
        out[k, 4] = max(length - unit * e * half, axis * (1.0 - e))
        out[k, 5] = min(length + unit * e * half, axis * (1.0 + e))
        out[k, 6] = max(radial - unit * e * off, -unit * e)
        out[k, 7] = min(radial + unit * e * off, unit * e)
        out[k, 8] = max(across - unit * e * off, unit * (1.0 - e))
        out[k, 9] = min(across + unit * e * off, unit * (1.0 + e))


def least_cost_m_s(elements_i, elements_j):
    """What a leg costs at least, at any time [m/s].

    An impulse at a distance r changes the angular momentum about the centre by r times itself at
    most, and both impulses together change that of the origin to that of the destination.
    """
    momenta, far = [], 0.0
    for elements in (elements_i, elements_j):
        axis, e = elements[:2]
        size = math.sqrt(kepler.MU_MOON_M3_S2 * axis * (1.0 - e * e))
        momenta.append(size * normal_of(elements))
        far = max(far, axis * (1.0 + e))
    return float(np.linalg.norm(momenta[0] - momenta[1])) / far


def normal_of(elements):
    """The direction of a target's angular momentum, (3,)."""
    sine, cosine = math.sin(elements[2]), math.cos(elements[2])
    return np.array([sine * math.sin(elements[3]), -sine * math.cos(elements[3]), cosine])
