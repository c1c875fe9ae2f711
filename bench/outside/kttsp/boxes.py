"""Proofs that no leg of a pair leaves within one span of time and arrives within another.

A box is a span of departures and one of arrivals. Over it, distances r, angles θ between both ends
and the components of both targets' velocities lie in intervals that the targets' greatest speeds
give. What an arc costs is bounded from below over all of them:

*Planes.* An arc's plane holds both ends. Its angle γ to a target's plane, about the end at that
target, has sin γ = |h · r'| / sin θ with the normal h of that plane and the direction r' of the
other end, and both angles together are no less than the angle between the planes of both targets.
Where the ends are all but in line with the centre, h · r' says nothing and an arc may lie in any
plane between: then what one angle has less the other has more, and this is gone through in parts.

*Energy.* What velocities lose across leaves a budget within the plane, and with it a range of
speeds at both ends, so one of 1 − x² = s / 2a.

*Flight.* T(x) as in :mod:`.lambert` falls with λ, ∂T/∂λ = −2λ²/y, and for a number of revolutions
it has one valley in x, so that the x of all arcs of the box lie between those of its corners.

*Velocities.* Over an interval of x the radial and transverse velocities at both ends lie in
intervals, and no arc of the box costs less than their least distance to those of the targets.

Nothing is sampled. All comparisons give way by ``SLACK``, which is far above rounding.
"""

import math

from adr_opt.kernels.core.compile import inlined, kernel

from . import kepler, lambert
from .costs import REVOLUTIONS

SLACK = 1e-7
"""Relative; what rounding and the steps of Householder's method leave out is less by far."""

PIECES = 6
"""How often an interval of x is halved before it counts as possible."""

TILTS = 16
"""Parts of the angle between the planes that an arc may take at its beginning."""

FREE = 0.9
"""Share of that angle of which less is known; above it parts are hardly worth their time."""


@inlined
def _apart(low, high, other_low, other_high):
    """The least distance of two intervals."""
    return max(low - other_high, other_low - high, 0.0)


@inlined
def _burn(up_low, up_high, round_low, round_high, span, cosine):
    """The least impulse between velocities of an arc and those of a target.

    ``cosine`` is the largest of the angle between the planes, which is at most a right angle.
    """
    radial = _apart(up_low, up_high, span[6], span[7])
    turning = _apart(round_low, round_high, span[8] * cosine, span[9] * cosine)
    return math.sqrt(
        radial * radial + turning * turning + span[8] * span[8] * (1.0 - cosine * cosine)
    )


@inlined
def _product(a_low, a_high, b_low, b_high):
    """The product of two intervals."""
    one, two, three, four = a_low * b_low, a_low * b_high, a_high * b_low, a_high * b_high
    return min(one, two, three, four), max(one, two, three, four)


@kernel
def _cost(x_low, x_high, one, other, box, least_across):
    """The least cost over an interval of x.

    Parameters
    ----------
    x_low, x_high : float
    one, other : (10,) float64
        Rows of :func:`.spans.spans`.
    box : tuple of float
        λ (least, largest), γ sqrt(μs/2) σ (least, largest), γ alone (least, largest), ρ (least,
        largest), largest cosines of both planes.
    least_across : float
        Of both ends together [m/s].
    """
    l_low, l_high, gs_low, gs_high, g_low, g_high, rho_low, rho_high, cos_1, cos_2 = box
    xx_high = max(x_low * x_low, x_high * x_high)
    xx_low = 0.0 if x_low <= 0.0 <= x_high else min(x_low * x_low, x_high * x_high)
    ll_high = max(l_low * l_low, l_high * l_high)
    ll_low = 0.0 if l_low <= 0.0 <= l_high else min(l_low * l_low, l_high * l_high)
    # y² = 1 − λ²(1 − x²), which is at least λ² x².
    one_low, one_high = 1.0 - xx_high, 1.0 - xx_low
    drop = max(ll_high * one_high, ll_low * one_high)
    rise = min(ll_high * one_low, ll_low * one_low)
    y_low = math.sqrt(max(1.0 - drop, ll_low * xx_low, 0.0))
    y_high = math.sqrt(max(1.0 - rise, 0.0))
    ly_low, ly_high = _product(l_low, l_high, y_low, y_high)
    lx_low, lx_high = _product(l_low, l_high, x_low, x_high)
    turn_low, turn_high = max(y_low + lx_low, 0.0), max(y_high + lx_high, 0.0)
    sum_low, sum_high = ly_low + x_low, ly_high + x_high
    less_low, less_high = ly_low - x_high, ly_high - x_low
    tilt_low, tilt_high = _product(rho_low, rho_high, sum_low, sum_high)
    a_low, a_high = _product(g_low, g_high, less_low - tilt_high, less_high - tilt_low)
    b_low, b_high = _product(g_low, g_high, -less_high - tilt_high, -less_low - tilt_low)
    up_1_low, up_1_high = _product(a_low, a_high, 1.0 / one[5], 1.0 / one[4])
    up_2_low, up_2_high = _product(b_low, b_high, 1.0 / other[5], 1.0 / other[4])
    first = _burn(
        up_1_low, up_1_high, gs_low * turn_low / one[5], gs_high * turn_high / one[4], one, cos_1
    )
    second = _burn(
        up_2_low, up_2_high, gs_low * turn_low / other[5], gs_high * turn_high / other[4],
        other, cos_2,
    )  # fmt: skip
    return max(first + second, least_across)


@kernel
def _possible_between(x_low, x_high, one, other, box, least_across, limit):
    """Whether an interval of x may hold an arc within a limit."""
    pieces = 1 << PIECES
    at = 0
    # Dyadic pieces from left to right, as wide as can be shown to be impossible.
    while at < pieces:
        width = at & -at if at else pieces
        while True:
            low = x_low + (x_high - x_low) * at / pieces
            high = x_low + (x_high - x_low) * (at + width) / pieces
            if _cost(low, high, one, other, box, least_across) > limit:
                break
            if width == 1:
                return True
            width >>= 1
        at += width
    return False


@inlined
def _angles(one, other, normal_1, normal_2, between):
    """Bounds of both planes' angles: sines that they have at least, by the box."""
    theta = math.acos(
        min(max(one[0] * other[0] + one[1] * other[1] + one[2] * other[2], -1.0), 1.0)
    )
    theta_low = max(theta - one[3] - other[3] - SLACK, 0.0)
    theta_high = min(theta + one[3] + other[3] + SLACK, math.pi)
    most = 1.0
    if theta_high < 0.5 * math.pi:
        most = math.sin(theta_high)
    elif theta_low > 0.5 * math.pi:
        most = math.sin(theta_low)
    tilt = math.sin(between) if between < 0.5 * math.pi else 1.0
    height_2 = abs(other[0] * normal_1[0] + other[1] * normal_1[1] + other[2] * normal_1[2])
    height_1 = abs(one[0] * normal_2[0] + one[1] * normal_2[1] + one[2] * normal_2[2])
    sine_1 = max(height_2 - tilt * other[3] - SLACK, 0.0) / most
    sine_2 = max(height_1 - tilt * one[3] - SLACK, 0.0) / most
    return theta_low, theta_high, sine_1, sine_2


@inlined
def _slowest(speed, cosine, elsewhere, own, budget, limit):
    """The least speed of an arc in its plane at an end whose target has a transverse speed v.

    With an angle γ between the planes the arc is no slower than v cos γ − √(L² − (v sin γ + w)²),
    w being what the other end loses across. Where v is above the limit L this grows with γ, so that
    it is least at the least γ; and it is no less than what the largest γ that L allows leaves of
    v cos γ, less the budget that all γ of both ends have in common.

    Parameters
    ----------
    speed, cosine, elsewhere : float
        v, the largest cos γ, and the least w.
    own, budget : float
        The square root at the least γ of both ends, and that budget [m/s].
    limit : float
        L [m/s].
    """
    if speed <= limit:
        return 0.0
    steepest = (limit - elsewhere) / speed
    common = speed * math.sqrt(max(1.0 - steepest * steepest, 0.0)) - budget
    return max(speed * cosine - own, common, 0.0)


@inlined
def _turned(x, y, z, one, other):
    """The component of a vector along the cross product of two directions."""
    return (
        x * (one[1] * other[2] - one[2] * other[1])
        + y * (one[2] * other[0] - one[0] * other[2])
        + z * (one[0] * other[1] - one[1] * other[0])
    )


@kernel
def possible(one, other, normal_1, normal_2, between, fly_low, fly_high, limit):
    """Whether a box may hold a leg within a limit; ``False`` is a proof that it holds none.

    Parameters
    ----------
    one, other : (10,) float64
        Rows of :func:`.spans.spans`, of the origin and of the destination.
    normal_1, normal_2 : (3,) float64
        Of both targets' planes.
    between : float
        Angle between the planes [rad].
    fly_low, fly_high : float
        Shortest and longest flight of the box [s].
    limit : float
        [m/s].
    """
    limit = limit * (1.0 + SLACK) + 1e-5
    theta_low, theta_high, sine_1, sine_2 = _angles(one, other, normal_1, normal_2, between)
    if sine_1 > 1.0 or sine_2 > 1.0:
        return True  # an empty box would be proof enough, but rounding must not make one
    angle_1, angle_2 = math.asin(sine_1), math.asin(sine_2)
    least_across = one[8] * sine_1 + other[8] * sine_2
    back = min(one[8] + other[8] * math.cos(between), other[8] + one[8] * math.cos(between))
    if angle_1 + angle_2 < between < 0.5 * math.pi and limit < back:
        # An angle beyond a right one, against a target's motion, costs at least ``back``. Of the
        # others the sum of sines is concave, so that it is least where one angle is.
        first = one[8] * sine_1 + other[8] * math.sin(min(between - angle_1, 0.5 * math.pi))
        second = one[8] * math.sin(min(between - angle_2, 0.5 * math.pi)) + other[8] * sine_2
        least_across = min(first, second)
    if least_across > limit:
        return False
    box = one, other, normal_1, normal_2, theta_low, theta_high, fly_low, fly_high
    if not _possible_tilted(box, sine_1, sine_2, least_across, limit):
        return False
    if angle_1 + angle_2 > FREE * between:
        return True
    # The same arc costs the more at an end the larger its angle there, and beyond a right one no
    # less than at that: so what is known of an angle may be taken for it.
    width = (between - angle_1 - angle_2) / TILTS
    for part in range(TILTS):
        # The first angle is no less than where the part begins, the other one than where it ends.
        sine_1 = math.sin(min(angle_1 + part * width, 0.5 * math.pi))
        sine_2 = math.sin(min(angle_2 + (TILTS - 1 - part) * width, 0.5 * math.pi))
        least_across = one[8] * sine_1 + other[8] * sine_2
        if least_across <= limit and _possible_tilted(box, sine_1, sine_2, least_across, limit):
            return True
    return False


@kernel
def _possible_tilted(box, sine_1, sine_2, least_across, limit):
    """The same, of arcs whose angles to both planes are at least those of these sines."""
    one, other, normal_1, normal_2, theta_low, theta_high, fly_low, fly_high = box
    mu = kepler.MU_MOON_M3_S2
    budget = math.sqrt(limit * limit - least_across * least_across)
    cos_1, cos_2 = math.sqrt(1.0 - sine_1 * sine_1), math.sqrt(1.0 - sine_2 * sine_2)
    # Energies: speeds in the plane are near those of the targets.
    up_1, up_2 = max(abs(one[6]), abs(one[7])), max(abs(other[6]), abs(other[7]))
    fast_1 = math.sqrt(up_1 * up_1 + (one[9] * cos_1) ** 2) + budget
    fast_2 = math.sqrt(up_2 * up_2 + (other[9] * cos_2) ** 2) + budget
    own = math.sqrt(limit * limit - (one[8] * sine_1 + other[8] * sine_2) ** 2)
    slow_1 = _slowest(one[8], cos_1, other[8] * sine_2, own, budget, limit)
    slow_2 = _slowest(other[8], cos_2, one[8] * sine_1, own, budget, limit)
    inverse_low = max(2.0 / one[5] - fast_1**2 / mu, 2.0 / other[5] - fast_2**2 / mu)
    inverse_high = min(2.0 / one[4] - slow_1**2 / mu, 2.0 / other[4] - slow_2**2 / mu)
    if inverse_low > inverse_high:
        return False
    rate = math.sqrt(mu) / (2.0 * math.pi)
    most = REVOLUTIONS
    if inverse_high > 0.0:
        most = min(int(rate * fly_high * inverse_high**1.5 * (1.0 + SLACK)), REVOLUTIONS)
    else:
        most = 0
    fewest = 0
    if inverse_low > 0.0:
        fewest = max(math.ceil(rate * fly_low * inverse_low**1.5 * (1.0 - SLACK)) - 1, 0)
    normal = _turned(normal_1[0], normal_1[1], normal_1[2], one, other)
    normal_other = _turned(normal_2[0], normal_2[1], normal_2[2], one, other)
    for way in range(2):
        sign = 1.0 if way == 0 else -1.0
        # Against both targets' motion costs both their speeds, against one's that one's.
        against = 0.0
        if sign * normal < -one[3] - other[3] - SLACK:
            against += one[8]
        if sign * normal_other < -one[3] - other[3] - SLACK:
            against += other[8]
        if against > limit:
            continue
        if _possible_way(
            one, other, theta_low, theta_high, sign, cos_1, cos_2, least_across, inverse_low,
            inverse_high, fewest, most, fly_low, fly_high, limit,
        ):  # fmt: skip
            return True
    return False


@kernel
def _possible_way(  # noqa: PLR0913
    one, other, theta_low, theta_high, sign, cos_1, cos_2, least_across, inverse_low,
    inverse_high, fewest, most, fly_low, fly_high, limit,
):  # fmt: skip
    """The same, in one direction about the centre."""
    mu = kepler.MU_MOON_M3_S2
    half_low, half_high = 0.5 * theta_low, 0.5 * theta_high
    root_low, root_high = math.sqrt(one[4] * other[4]), math.sqrt(one[5] * other[5])
    far = max(abs(one[5] - other[4]), abs(other[5] - one[4]))
    near = _apart(one[4], one[5], other[4], other[5])
    chord_low = math.sqrt(near * near + (2.0 * root_low * math.sin(half_low)) ** 2)
    chord_high = math.sqrt(far * far + (2.0 * root_high * math.sin(half_high)) ** 2)
    s_low = 0.5 * (one[4] + other[4] + chord_low)
    s_high = 0.5 * (one[5] + other[5] + chord_high)
    size_low = root_low * max(math.cos(half_high), 0.0) / s_high
    size_high = min(root_high * math.cos(half_low) / s_low, 1.0 - 1e-12)
    l_low, l_high = (size_low, size_high) if sign > 0.0 else (-size_high, -size_low)
    if chord_low <= 0.0:
        return True
    rho_low = max((one[4] - other[5]) / (chord_low if one[4] < other[5] else chord_high), -1.0)
    rho_high = min((one[5] - other[4]) / (chord_low if one[5] > other[4] else chord_high), 1.0)
    bend = 2.0 * root_low * math.sin(half_low) / chord_high
    sigma_high = min(2.0 * root_high * math.sin(half_high) / chord_low, 1.0)
    rho = max(abs(rho_low), abs(rho_high))
    sigma_low = max(bend, math.sqrt(max(1.0 - rho * rho, 0.0)))
    g_low, g_high = math.sqrt(0.5 * mu * s_low), math.sqrt(0.5 * mu * s_high)
    box = (
        l_low, l_high, g_low * sigma_low, g_high * sigma_high, g_low, g_high, rho_low, rho_high,
        cos_1, cos_2,
    )  # fmt: skip
    wanted_low = fly_low * math.sqrt(2.0 * mu / s_high) / s_high * (1.0 - SLACK)
    wanted_high = fly_high * math.sqrt(2.0 * mu / s_low) / s_low * (1.0 + SLACK)
    # x² = 1 − s / 2a.
    left_low = min(0.5 * s_low * inverse_low, 0.5 * s_high * inverse_low)
    left_high = max(0.5 * s_low * inverse_high, 0.5 * s_high * inverse_high)
    outer = math.sqrt(max(1.0 - left_low, 0.0)) + SLACK
    inner = math.sqrt(max(1.0 - left_high, 0.0)) - SLACK
    for revolutions in range(fewest, most + 1):
        if revolutions == 0:
            ends = (
                lambert.invert(
                    wanted_high, l_high, 0, False, lambert._guess_direct(wanted_high, l_high)
                ) - SLACK,
                lambert.invert(
                    wanted_low, l_low, 0, False, lambert._guess_direct(wanted_low, l_low)
                ) + SLACK,
            )  # fmt: skip
            if _possible_clipped(ends, inner, outer, one, other, box, least_across, limit):
                return True
            continue
        least, _ = lambert.least_flight(l_high, revolutions)
        if wanted_high < least * (1.0 - SLACK):
            break
        if wanted_high < least * (1.0 + SLACK):
            return True
        lowest = _invert(wanted_high, l_high, revolutions, False)
        highest = _invert(wanted_high, l_high, revolutions, True)
        least, _ = lambert.least_flight(l_low, revolutions)
        if wanted_low < least * (1.0 + SLACK):
            ends = lowest - SLACK, highest + SLACK
            if _possible_clipped(ends, inner, outer, one, other, box, least_across, limit):
                return True
            continue
        ends = lowest - SLACK, _invert(wanted_low, l_low, revolutions, False) + SLACK
        if _possible_clipped(ends, inner, outer, one, other, box, least_across, limit):
            return True
        ends = _invert(wanted_low, l_low, revolutions, True) - SLACK, highest + SLACK
        if _possible_clipped(ends, inner, outer, one, other, box, least_across, limit):
            return True
    return False


@inlined
def _invert(wanted, ratio, revolutions, upper):
    x = lambert._guess_round(wanted, revolutions, upper)
    return lambert.invert(wanted, ratio, revolutions, upper, x)


@kernel
def _possible_clipped(ends, inner, outer, one, other, box, least_across, limit):
    """Whether x between two ends, and of a size between two others, may cost no more."""
    low, high = max(ends[0], -outer), min(ends[1], outer)
    if low > high:
        return False
    if inner <= 0.0:
        return _possible_between(low, high, one, other, box, least_across, limit)
    if low <= -inner:
        to = min(high, -inner)
        if _possible_between(low, to, one, other, box, least_across, limit):
            return True
    if high >= inner:
        since = max(low, inner)
        if _possible_between(since, high, one, other, box, least_across, limit):
            return True
    return False
