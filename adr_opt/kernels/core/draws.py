"""Draws of uncertain worlds: uniform numbers by key, and quantile functions to transform them.

A draw is a function of the state of a world and of a key alone (docs/model.md section 13), so that
rehearsals and environments meet the same worlds. What the distributions are is described in
:mod:`adr_opt.problem.uncertainty`.
"""

import math

import numpy as np

from .compile import inlined, kernel

GOLDEN = np.uint64(0x9E3779B97F4A7C15)
FIRST_FACTOR = np.uint64(0xBF58476D1CE4E5B9)
SECOND_FACTOR = np.uint64(0x94D049BB133111EB)
ONE = np.uint64(1)
FIRST_SHIFT, SECOND_SHIFT, THIRD_SHIFT = np.uint64(30), np.uint64(27), np.uint64(31)
EXCESS_BITS = np.uint64(12)
"""Low bits of a 64-bit state that do not fit into the 52-bit fraction of a float."""


def _rational(above, below):
    """Coefficients of a rational function: numerator and denominator."""
    return tuple(tuple(float(number) for number in text.split()) for text in (above, below))


# M. J. Wichura, Algorithm AS 241 (PPND16), Applied Statistics 37(3), 1988: numerators and
# denominators of three rational functions, highest power first.
CENTRE = _rational(
    "2509.0809287301226727 33430.575583588128105 67265.770927008700853 45921.953931549871457 "
    "13731.693765509461125 1971.5909503065514427 133.14166789178437745 3.387132872796366608",
    "5226.495278852854561 28729.085735721942674 39307.89580009271061 21213.794301586595867 "
    "5394.1960214247511077 687.1870074920579083 42.313330701600911252 1.0",
)
SHOULDER = _rational(
    "7.7454501427834140764e-4 0.0227238449892691845833 0.24178072517745061177 "
    "1.27045825245236838258 3.64784832476320460504 5.7694972214606914055 4.6303378461565452959 "
    "1.42343711074968357734",
    "1.05075007164441684324e-9 5.475938084995344946e-4 0.0151986665636164571966 "
    "0.14810397642748007459 0.68976733498510000455 1.6763848301838038494 2.05319162663775882187 "
    "1.0",
)
TAIL = _rational(
    "2.01033439929228813265e-7 2.71155556874348757815e-5 0.0012426609473880784386 "
    "0.026532189526576123093 0.29656057182850489123 1.7848265399172913358 5.4637849111641143699 "
    "6.6579046435011037772",
    "2.04426310338993978564e-15 1.4215117583164458887e-7 1.8463183175100546818e-5 "
    "7.868691311456132591e-4 0.0148753612908506148525 0.13692988092273580531 "
    "0.59983220655588793769 1.0",
)


@inlined
def _mixed(state):
    """The finaliser of splitmix64 (Steele, Lea, Flood, OOPSLA 2014)."""
    state = (state ^ (state >> FIRST_SHIFT)) * FIRST_FACTOR
    state = (state ^ (state >> SECOND_SHIFT)) * SECOND_FACTOR
    return state ^ (state >> THIRD_SHIFT)


@kernel
def world_state(seed):
    """State of a world by its seed, both uint64."""
    return _mixed(seed * GOLDEN + ONE)


@kernel
def uniform_at(state, key):
    """A uniform number in (0, 1) from the state of a world and the key of an event, both uint64."""
    return (np.float64(_mixed(key + state) >> EXCESS_BITS) + 0.5) * 2.0**-52


@inlined
def _quotient(function, r):
    """A rational function by its coefficients, at a number."""
    above, below = function[0][0], function[1][0]
    for place in range(1, 8):
        above = above * r + function[0][place]
        below = below * r + function[1][place]
    return above, below


@kernel
def normal_quantile(probability):
    """Quantile of the standard normal distribution at a probability in (0, 1)."""
    q = probability - 0.5
    if abs(q) <= 0.425:
        above, below = _quotient(CENTRE, 0.180625 - q * q)
        return above * q / below
    r = math.sqrt(-math.log(probability if q <= 0.0 else 1.0 - probability))
    above, below = _quotient(SHOULDER, r - 1.6) if r <= 5.0 else _quotient(TAIL, r - 5.0)
    return -above / below if q < 0.0 else above / below


@kernel
def lognormal_at(uniform, sigma, least, most):
    """A lognormal factor of median 1 within bounds, at a uniform number; 1 without spread."""
    if sigma == 0.0:
        return 1.0
    return min(max(math.exp(sigma * normal_quantile(uniform)), least), most)


@kernel
def delay_at(uniform, chance, mean, most):
    """A delay that occurs with a chance, exponential up to a maximum, at a uniform number [s]."""
    if uniform >= chance:
        return 0.0
    # Given that there is one, the number is uniform again, over the chance.
    return min(-mean * math.log1p(-uniform / chance), most)


LATE_SHARE = 0.9
"""Share of tries that take no longer than the late try."""

PARTS = 64
"""Number of equally likely parts into which the factor is split to add the delay."""

HALVINGS = 40
"""Of the interval that holds the late try."""


@kernel
def late_try(planned, factor, delay):
    """Time of a try, by factor and delay, exceeded with a chance of 1 − :data:`LATE_SHARE` [s].

    Parameters
    ----------
    planned : float
        [s].
    factor : (float, float, float)
        Spread and bounds.
    delay : (float, float, float)
        Chance, mean and maximum [s].
    """
    sigma, least, most_factor = factor
    chance, mean, most = delay
    alone = planned * lognormal_at(LATE_SHARE, sigma, least, most_factor)
    if chance == 0.0 or mean == 0.0 or most == 0.0:
        return alone
    longest = delay_at(chance * (1.0 - 1e-15), chance, mean, most)
    low, high = planned * least if sigma > 0.0 else planned, planned * most_factor + longest
    for _ in range(HALVINGS):
        middle = 0.5 * (low + high)
        within = 0.0
        for part in range(PARTS):
            rest = middle - planned * lognormal_at((part + 0.5) / PARTS, sigma, least, most_factor)
            if rest >= most:
                within += 1.0
            elif rest >= 0.0:
                within += 1.0 - chance * math.exp(-rest / mean)
        if within < LATE_SHARE * PARTS:
            low = middle
        else:
            high = middle
    return high
