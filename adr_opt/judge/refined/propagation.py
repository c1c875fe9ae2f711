"""Free motion by variation of parameters, in modified equinoctial elements.

The judge's own propagation, in other variables and by another method than those of
:mod:`adr_opt.kernels.orbits.coast`. Five of the six elements change by the harmonics alone, a
thousandth of what positions and velocities change by, and so does what rounding and the method
leave behind: two years end within centimetres of the collocation. In Cartesian coordinates it was a
metre after half of that, which a judge of metres has not to spare.

The elements are those of M. Walker, B. Ireland and J. Owens, Celestial Mechanics 36 (1985); the
method is the one of order 8 of E. Hairer, S. Nørsett and G. Wanner, Solving Ordinary Differential
Equations I (1993), with SciPy's coefficients and equal steps. Sums are compensated.
"""

import math

import numpy as np
import numpy.typing as npt
from scipy.integrate import DOP853

from ...common.constants import EARTH_RADIUS_M, MU_M3_S2
from ...kernels.core.compile import inlined, kernel

Array = npt.NDArray[np.float64]

STAGES = DOP853.n_stages
BEFORE = np.ascontiguousarray(DOP853.A[:STAGES, :STAGES])
WEIGHTS = np.ascontiguousarray(DOP853.B)
"""Weights of earlier stages in a stage, and of all stages in a step."""
for _array in (BEFORE, WEIGHTS):
    _array.setflags(write=False)


@kernel
def rates_of(elements: Array, zonals: Array, rates: Array) -> None:
    """Rates of change of the elements."""
    p, f, g, h, k, longitude = (
        elements[0],
        elements[1],
        elements[2],
        elements[3],
        elements[4],
        elements[5],
    )
    c, s = math.cos(longitude), math.sin(longitude)
    w = 1.0 + f * c + g * s
    r = p / w
    square, apart = 1.0 + h * h + k * k, h * h - k * k
    tilt = h * s - k * c
    # Unit vectors outward, ahead, and across.
    out_x = (c + apart * c + 2.0 * h * k * s) / square
    out_y = (s - apart * s + 2.0 * h * k * c) / square
    out_z = 2.0 * tilt / square
    across_x, across_y, across_z = 2.0 * k / square, -2.0 * h / square, (2.0 - square) / square
    ahead_x = across_y * out_z - across_z * out_y
    ahead_y = across_z * out_x - across_x * out_z
    ahead_z = across_x * out_y - across_y * out_x
    # What the harmonics add to the pull of a point.
    flat, t = EARTH_RADIUS_M * EARTH_RADIUS_M / (r * r), out_z * out_z
    second = 1.5 * zonals[0] * flat
    third = 2.5 * zonals[1] * flat * EARTH_RADIUS_M / r * out_z
    fourth = 0.625 * zonals[2] * flat * flat
    side = second * (1.0 - 5.0 * t) + third * (3.0 - 7.0 * t)
    side -= fourth * (3.0 - 42.0 * t + 63.0 * t * t)
    polar = second * (3.0 - 5.0 * t) + third * (6.0 - 7.0 * t)
    polar -= fourth * (15.0 - 70.0 * t + 63.0 * t * t)
    point = -MU_M3_S2 / (r * r)
    odd = -1.5 * zonals[1] * point * flat * EARTH_RADIUS_M / r
    x, y, z = point * side * out_x, point * side * out_y, point * polar * out_z + odd
    radial = x * out_x + y * out_y + z * out_z
    along = x * ahead_x + y * ahead_y + z * ahead_z
    normal = x * across_x + y * across_y + z * across_z
    pace = math.sqrt(p / MU_M3_S2)
    rates[0] = 2.0 * r * pace * along
    rates[1] = pace * (radial * s + (((w + 1.0) * c + f) * along - tilt * g * normal) / w)
    rates[2] = pace * (-radial * c + (((w + 1.0) * s + g) * along + tilt * f * normal) / w)
    rates[3] = 0.5 * pace * square * normal / w * c
    rates[4] = 0.5 * pace * square * normal / w * s
    rates[5] = math.sqrt(MU_M3_S2 * p) / (r * r) + pace * tilt * normal / w


@inlined
def begin_stage(at, step, elements, lost, rates, stage):
    """Write the elements of a stage of a step, from the rates of the stages before it."""
    for axis in range(6):
        total = 0.0
        for before in range(at):
            total += BEFORE[at, before] * rates[before, axis]
        stage[axis] = elements[axis] + (lost[axis] + step * total)


@inlined
def end_step(step, elements, lost, rates):
    """Advance elements by a step from the rates of its stages, with compensated summation."""
    for axis in range(6):
        total = 0.0
        for at in range(STAGES):
            total += WEIGHTS[at] * rates[at, axis]
        add = step * total + lost[axis]
        found = elements[axis] + add
        lost[axis] = add - (found - elements[axis])
        elements[axis] = found


@kernel
def advance(elements: Array, duration: float, steps: int, zonals: Array) -> float:
    """Propagate elements in place, in a number of equal steps; the least radius passed [m].

    Parameters
    ----------
    elements : (6,) float64
        p, f, g, h, k and the true longitude L [m, rad].
    duration : float
        Of either sign [s].
    steps : int
    zonals : (3,) float64
        J2, J3 and J4; 0 for those that are left out.
    """
    step = duration / steps
    rates, stage, lost = np.empty((STAGES, 6)), np.empty(6), np.zeros(6)
    least: float = radius_of(elements)
    for _ in range(steps):
        for at in range(STAGES):
            begin_stage(at, step, elements, lost, rates, stage)
            rates_of(stage, zonals, rates[at])
        end_step(step, elements, lost, rates)
        least = min(least, radius_of(elements))
        # Small longitudes have more digits.
        if elements[5] > math.pi:
            elements[5] -= math.tau
        elif elements[5] < -math.pi:
            elements[5] += math.tau
    return least


@inlined
def radius_of(elements):
    """Distance from the centre of the Earth [m]."""
    c, s = math.cos(elements[5]), math.sin(elements[5])
    return elements[0] / (1.0 + elements[1] * c + elements[2] * s)


@kernel
def elements_of(state: Array) -> Array:
    """Elements of a state on a closed prograde orbit, shape (6,)."""
    x, y, z, u, v, w = state[0], state[1], state[2], state[3], state[4], state[5]
    r = math.sqrt(x * x + y * y + z * z)
    momentum_x, momentum_y, momentum_z = y * w - z * v, z * u - x * w, x * v - y * u
    square = momentum_x**2 + momentum_y**2 + momentum_z**2
    momentum = math.sqrt(square)
    h, k = -momentum_y / (momentum + momentum_z), momentum_x / (momentum + momentum_z)
    whole, apart = 1.0 + h * h + k * k, h * h - k * k
    first_x, first_y, first_z = (1.0 + apart) / whole, 2.0 * h * k / whole, -2.0 * k / whole
    second_x, second_y, second_z = 2.0 * h * k / whole, (1.0 - apart) / whole, 2.0 * h / whole
    # The vector that points to the perigee and is as long as the eccentricity.
    e_x = (v * momentum_z - w * momentum_y) / MU_M3_S2 - x / r
    e_y = (w * momentum_x - u * momentum_z) / MU_M3_S2 - y / r
    e_z = (u * momentum_y - v * momentum_x) / MU_M3_S2 - z / r
    found = np.empty(6)
    found[0] = square / MU_M3_S2
    found[1] = e_x * first_x + e_y * first_y + e_z * first_z
    found[2] = e_x * second_x + e_y * second_y + e_z * second_z
    found[3], found[4] = h, k
    found[5] = math.atan2(
        x * second_x + y * second_y + z * second_z, x * first_x + y * first_y + z * first_z
    )
    return found


@kernel
def state_of(elements: Array) -> Array:
    """State from elements, shape (6,) [m, m/s]."""
    p, f, g, h, k = elements[0], elements[1], elements[2], elements[3], elements[4]
    c, s = math.cos(elements[5]), math.sin(elements[5])
    whole, apart = 1.0 + h * h + k * k, h * h - k * k
    r, speed = p / (1.0 + f * c + g * s), math.sqrt(MU_M3_S2 / p)
    found = np.empty(6)
    # Along the two axes of the plane, x and y, and then turned into space.
    x, y, u, v = r * c, r * s, -speed * (g + s), speed * (f + c)
    found[0] = ((1.0 + apart) * x + 2.0 * h * k * y) / whole
    found[1] = (2.0 * h * k * x + (1.0 - apart) * y) / whole
    found[2] = (-2.0 * k * x + 2.0 * h * y) / whole
    found[3] = ((1.0 + apart) * u + 2.0 * h * k * v) / whole
    found[4] = (2.0 * h * k * u + (1.0 - apart) * v) / whole
    found[5] = (-2.0 * k * u + 2.0 * h * v) / whole
    return found
