"""Lambert's problem for all numbers of revolutions, both branches and both directions.

D. Izzo, "Revisiting Lambert's problem", Celestial Mechanics and Dynamical Astronomy 121, 2015,
1–15: with the chord c, the semi-perimeter s and λ² = 1 − c/s, the flight T = t sqrt(2μ/s³) is a
function of x alone, which Householder's method inverts in a few steps,

    T(x) = (ψ + Mπ) / (1 − x²)^{3/2} − (x − λy) / (1 − x²),    y = sqrt(1 − λ²(1 − x²)),
    cos ψ = xy + λ(1 − x²) .

For M > 0 there is a least flight; longer ones have two solutions, one on either side of its x.
"""

import math

import numpy as np

from adr_opt.kernels.core.compile import inlined, kernel

SERIES = 1e-2
"""Nearer to x = 1 than this the flight is taken from a series; the rest loses digits there."""

STEPS, MANY, CLOSE = 20, 100, 1e-9
"""Steps of a method that are enough where it converges, most steps, and the step in x after which
the error is that of rounding."""

LN_2 = math.log(2.0)


@inlined
def _series(argument):
    """The hypergeometric function F(3, 1; 5/2; z), for small z."""
    term = total = 1.0
    for n in range(60):
        term *= (3.0 + n) / (2.5 + n) * argument
        total += term
        if abs(term) < 1e-16 * abs(total):
            break
    return total


@kernel
def flight(x, ratio, revolutions):
    """T of x: the flight without dimension.

    Parameters
    ----------
    x, ratio : float
        x, and λ.
    revolutions : int
        M.
    """
    left = 1.0 - x * x
    y = math.sqrt(1.0 - ratio * ratio * left)
    if abs(x - 1.0) < SERIES:
        eta = y - ratio * x
        s = 0.5 * (1.0 - ratio - x * eta)
        whole = 0.5 * (eta**3 * 4.0 / 3.0 * _series(s) + 4.0 * ratio * eta)
        return whole + revolutions * math.pi / abs(left) ** 1.5 if revolutions else whole
    if left > 0.0:
        angle = math.acos(min(max(x * y + ratio * left, -1.0), 1.0)) + revolutions * math.pi
    else:
        angle = math.asinh((y - x * ratio) * math.sqrt(-left))
    return (angle / math.sqrt(abs(left)) - x + ratio * y) / left


@inlined
def _slopes(x, ratio, taken):
    """The first three derivatives of T at x, where it is ``taken``."""
    left = 1.0 - x * x
    cube = ratio**3
    y = math.sqrt(1.0 - ratio * ratio * left)
    first = (3.0 * taken * x - 2.0 + 2.0 * cube * x / y) / left
    second = (3.0 * taken + 5.0 * x * first + 2.0 * (1.0 - ratio * ratio) * cube / y**3) / left
    third = 7.0 * x * second + 8.0 * first
    third = (third - 6.0 * (1.0 - ratio * ratio) * cube * ratio * ratio * x / y**5) / left
    return first, second, third


@kernel
def invert(wanted, ratio, revolutions, upper, x):
    """The x of a flight, by Householder's method of third order from a guess.

    The flight falls with x, and with revolutions it falls to the least one and rises again: from
    each x one can tell on which side of it the one looked for lies. So that one is kept between
    two others, and where a step leads outside, or not far enough, they are halved instead. Near
    the line through the centre the method alone goes astray.

    Parameters
    ----------
    wanted, ratio : float
    revolutions : int
    upper : bool
        Of the two solutions with revolutions, that beyond the least flight. There has to be one.
    x : float
        The guess.
    """
    low, high = -1.0, 1.0 if revolutions else math.inf
    if not low < x < high:
        x = 0.0
    for number in range(MANY):
        taken = flight(x, ratio, revolutions)
        off = taken - wanted
        first, second, third = _slopes(x, ratio, taken)
        # On the other side of the least flight its own solution would be found.
        strays = revolutions > 0 and (first > 0.0) != upper
        if upper if strays else (off > 0.0) != upper:
            low = x
        else:
            high = x
        above = first * first - 0.5 * off * second
        below = first * (first * first - off * second) + third * off * off / 6.0
        now = x - off * above / below if below != 0.0 else math.inf
        if not strays and abs(now - x) < CLOSE:
            return now
        # After the steps that are enough where all goes well, every other one halves.
        if strays or not low < now < high or (number >= STEPS and number % 2 == 0):
            now = 0.5 * (low + high) if high < math.inf else 2.0 * low + 2.0
        x = now
        if high - low < CLOSE:
            break
    return x


@kernel
def least_flight(ratio, revolutions):
    """The least T with so many revolutions, M > 0, and its x; by Halley's method.

    The slope of T rises with x and passes zero there: between an x where it falls and one where it
    rises it is kept, and halved where a step leads outside.
    """
    x, low, high = 0.0, -1.0, 1.0
    taken = math.acos(ratio) + ratio * math.sqrt(1.0 - ratio * ratio) + revolutions * math.pi
    for number in range(MANY):
        first, second, third = _slopes(x, ratio, taken)
        if first < 0.0:
            low = x
        else:
            high = x
        below = 2.0 * second * second - first * third
        now = x - 2.0 * first * second / below if below != 0.0 else math.inf
        if abs(now - x) < CLOSE:
            break
        if not low < now < high or (number >= STEPS and number % 2 == 0):
            now = 0.5 * (low + high)
        x = now
        taken = flight(x, ratio, revolutions)
        if high - low < CLOSE:
            break
    return taken, x


@inlined
def _guess_direct(wanted, ratio):
    """A first x without revolutions."""
    middle = math.acos(ratio) + ratio * math.sqrt(1.0 - ratio * ratio)
    parabolic = 2.0 / 3.0 * (1.0 - ratio**3)
    if wanted >= middle:
        return (middle - wanted) / (wanted - middle + 4.0)
    if wanted <= parabolic:
        return 2.5 * parabolic * (parabolic - wanted) / (wanted * (1.0 - ratio**5)) + 1.0
    return (wanted / middle) ** (LN_2 / math.log(parabolic / middle)) - 1.0


@inlined
def _guess_round(wanted, revolutions, upper):
    """A first x with revolutions, on either branch."""
    if upper:
        third = (8.0 * wanted / (revolutions * math.pi)) ** (2.0 / 3.0)
    else:
        third = ((revolutions + 1.0) * math.pi / (8.0 * wanted)) ** (2.0 / 3.0)
    return (third - 1.0) / (third + 1.0)


@kernel
def arcs(r_1, r_2, seconds, mu, most_revolutions, found):
    """The velocities of all arcs from one position to another in a given time.

    Parameters
    ----------
    r_1, r_2 : (3,) float64
        [m].
    seconds, mu : float
        [s], [m³/s²].
    most_revolutions : int
    found : (arcs, 6) float64
        Is filled with velocities at both ends [m/s]; room for ``4 most_revolutions + 2``.

    Returns
    -------
    int
        How many there are: without revolutions one in each direction, with some two or none; none
        at all where the positions lie on a line with the centre.
    """
    cross = np.empty(3)
    cross[0] = r_1[1] * r_2[2] - r_1[2] * r_2[1]
    cross[1] = r_1[2] * r_2[0] - r_1[0] * r_2[2]
    cross[2] = r_1[0] * r_2[1] - r_1[1] * r_2[0]
    area = math.sqrt(cross[0] ** 2 + cross[1] ** 2 + cross[2] ** 2)
    length_1 = math.sqrt(r_1[0] ** 2 + r_1[1] ** 2 + r_1[2] ** 2)
    length_2 = math.sqrt(r_2[0] ** 2 + r_2[1] ** 2 + r_2[2] ** 2)
    if area < 1e-14 * length_1 * length_2:
        return 0
    chord = math.sqrt((r_2[0] - r_1[0]) ** 2 + (r_2[1] - r_1[1]) ** 2 + (r_2[2] - r_1[2]) ** 2)
    s = 0.5 * (length_1 + length_2 + chord)
    wanted = seconds * math.sqrt(2.0 * mu / s) / s
    size = math.sqrt(max(1.0 - chord / s, 0.0))
    tangent_1, tangent_2 = np.empty(3), np.empty(3)
    for axis in range(3):
        b, c = (axis + 1) % 3, (axis + 2) % 3
        tangent_1[axis] = (cross[b] * r_1[c] - cross[c] * r_1[b]) / (area * length_1)
        tangent_2[axis] = (cross[b] * r_2[c] - cross[c] * r_2[b]) / (area * length_2)
    count = 0
    for way in range(2):
        # The short way round turns with the cross product, the long way against it.
        ratio, sign = (size, 1.0) if way == 0 else (-size, -1.0)
        most = min(int(wanted / math.pi), most_revolutions)
        for revolutions in range(most + 1):
            branches = 1
            if revolutions > 0:
                branches = 2
                # T is more than Mπ; only the last number of revolutions may be too many.
                if (
                    wanted
                    < math.acos(ratio)
                    + ratio * math.sqrt(1.0 - ratio * ratio)
                    + revolutions * math.pi
                ):
                    least, _ = least_flight(ratio, revolutions)
                    if wanted < least:
                        break
            for branch in range(branches):
                if revolutions == 0:
                    x = _guess_direct(wanted, ratio)
                else:
                    x = _guess_round(wanted, revolutions, branch == 1)
                x = invert(wanted, ratio, revolutions, branch == 1, x)
                _velocities(
                    x, ratio, sign, s, chord, mu, r_1, r_2, length_1, length_2,
                    tangent_1, tangent_2, found[count],
                )  # fmt: skip
                count += 1
    return count


@inlined
def _velocities(  # noqa: PLR0913
    x, ratio, sign, s, chord, mu, r_1, r_2, length_1, length_2, tangent_1, tangent_2, out
):
    """Both velocities of the arc of x, by their radial and transverse parts."""
    y = math.sqrt(1.0 - ratio * ratio * (1.0 - x * x))
    gamma = math.sqrt(0.5 * mu * s)
    rho = (length_1 - length_2) / chord
    sigma = math.sqrt(max(1.0 - rho * rho, 0.0))
    radial_1 = gamma * ((ratio * y - x) - rho * (ratio * y + x)) / length_1
    radial_2 = -gamma * ((ratio * y - x) + rho * (ratio * y + x)) / length_2
    across_1 = sign * gamma * sigma * (y + ratio * x) / length_1
    across_2 = sign * gamma * sigma * (y + ratio * x) / length_2
    for axis in range(3):
        out[axis] = radial_1 * r_1[axis] / length_1 + across_1 * tangent_1[axis]
        out[3 + axis] = radial_2 * r_2[axis] / length_2 + across_2 * tangent_2[axis]
