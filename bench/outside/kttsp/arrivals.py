"""When a target can be reached at the earliest, by when one is ready at another."""

import math

import numpy as np

from adr_opt.kernels.core.compile import inlined, kernel

from . import kepler, lambert
from .costs import REVOLUTIONS

HALVINGS = 12
"""Of a step between arrivals, for the first one that is within the limit."""

NEAR = 20
"""Departures that are tried on either side of one."""

ZOOMS = 4
"""How often departures are tried closer to each other."""


@inlined
def _revolutions(r_1, w_1, r_2, w_2, budget, mu, seconds):
    """The least and the largest number of revolutions of arcs whose speeds at both ends are near.

    A speed gives an energy, so a period; speeds in the plane that differ from w by the budget at
    most leave a range of periods.
    """
    low = max(2.0 / r_1 - (w_1 + budget) ** 2 / mu, 2.0 / r_2 - (w_2 + budget) ** 2 / mu)
    one, other = max(w_1 - budget, 0.0), max(w_2 - budget, 0.0)
    high = min(2.0 / r_1 - one * one / mu, 2.0 / r_2 - other * other / mu)
    if high <= 0.0 or high < low:
        return 0, -1
    rate = seconds * math.sqrt(mu) / (2.0 * math.pi)
    most = int(rate * high**1.5 * (1.0 + 1e-9))
    least = 0
    if low > 0.0:
        least = max(math.ceil(rate * low**1.5 * (1.0 - 1e-9)) - 1, 0)
    return least, most


@kernel
def within(r_1, v_1, r_2, v_2, seconds, limit):
    """Whether some arc costs no more than a limit.

    What velocities have across the plane of the ends is lost on either side; what is left of the
    limit bounds the change within the plane, with it the direction and the energy of the arc, and
    only arcs within these bounds are worked out.
    """
    mu = kepler.MU_MOON_M3_S2
    n_x = r_1[1] * r_2[2] - r_1[2] * r_2[1]
    n_y = r_1[2] * r_2[0] - r_1[0] * r_2[2]
    n_z = r_1[0] * r_2[1] - r_1[1] * r_2[0]
    area = math.sqrt(n_x * n_x + n_y * n_y + n_z * n_z)
    across_1 = v_1[0] * n_x + v_1[1] * n_y + v_1[2] * n_z
    across_2 = v_2[0] * n_x + v_2[1] * n_y + v_2[2] * n_z
    if abs(across_1) + abs(across_2) > limit * area * (1.0 + 1e-9):
        return False
    length_1 = math.sqrt(r_1[0] ** 2 + r_1[1] ** 2 + r_1[2] ** 2)
    length_2 = math.sqrt(r_2[0] ** 2 + r_2[1] ** 2 + r_2[2] ** 2)
    if area < 1e-14 * length_1 * length_2:
        return False
    across_1 /= area
    across_2 /= area
    left = limit * limit - (abs(across_1) + abs(across_2)) ** 2
    budget = math.sqrt(max(left, 0.0)) + 1e-9 * limit
    n_x /= area
    n_y /= area
    n_z /= area
    radial_1 = (v_1[0] * r_1[0] + v_1[1] * r_1[1] + v_1[2] * r_1[2]) / length_1
    radial_2 = (v_2[0] * r_2[0] + v_2[1] * r_2[1] + v_2[2] * r_2[2]) / length_2
    turn_1 = (
        v_1[0] * (n_y * r_1[2] - n_z * r_1[1])
        + v_1[1] * (n_z * r_1[0] - n_x * r_1[2])
        + v_1[2] * (n_x * r_1[1] - n_y * r_1[0])
    ) / length_1
    turn_2 = (
        v_2[0] * (n_y * r_2[2] - n_z * r_2[1])
        + v_2[1] * (n_z * r_2[0] - n_x * r_2[2])
        + v_2[2] * (n_x * r_2[1] - n_y * r_2[0])
    ) / length_2
    w_1 = math.sqrt(radial_1 * radial_1 + turn_1 * turn_1)
    w_2 = math.sqrt(radial_2 * radial_2 + turn_2 * turn_2)
    fewest, most = _revolutions(length_1, w_1, length_2, w_2, budget, mu, seconds)
    most = min(most, REVOLUTIONS)
    if most < fewest:
        return False
    chord = math.sqrt((r_2[0] - r_1[0]) ** 2 + (r_2[1] - r_1[1]) ** 2 + (r_2[2] - r_1[2]) ** 2)
    s = 0.5 * (length_1 + length_2 + chord)
    wanted = seconds * math.sqrt(2.0 * mu / s) / s
    size = math.sqrt(max(1.0 - chord / s, 0.0))
    gamma = math.sqrt(0.5 * mu * s)
    rho = (length_1 - length_2) / chord
    sigma = math.sqrt(max(1.0 - rho * rho, 0.0))
    for way in range(2):
        ratio, sign = (size, 1.0) if way == 0 else (-size, -1.0)
        if max(-sign * turn_1, 0.0) + max(-sign * turn_2, 0.0) > budget:
            continue
        for revolutions in range(fewest, min(int(wanted / math.pi), most) + 1):
            branches = 1
            if revolutions > 0:
                branches = 2
                middle = math.acos(ratio) + ratio * math.sqrt(1.0 - ratio * ratio)
                if wanted < middle + revolutions * math.pi:
                    least, _ = lambert.least_flight(ratio, revolutions)
                    if wanted < least:
                        break
            for branch in range(branches):
                if revolutions == 0:
                    x = lambert._guess_direct(wanted, ratio)
                else:
                    x = lambert._guess_round(wanted, revolutions, branch == 1)
                x = lambert.invert(wanted, ratio, revolutions, branch == 1, x)
                y = math.sqrt(1.0 - ratio * ratio * (1.0 - x * x))
                up_1 = gamma * ((ratio * y - x) - rho * (ratio * y + x)) / length_1
                up_2 = -gamma * ((ratio * y - x) + rho * (ratio * y + x)) / length_2
                round_1 = sign * gamma * sigma * (y + ratio * x) / length_1
                round_2 = sign * gamma * sigma * (y + ratio * x) / length_2
                one = (up_1 - radial_1) ** 2 + (round_1 - turn_1) ** 2 + across_1 * across_1
                other = (up_2 - radial_2) ** 2 + (round_2 - turn_2) ** 2 + across_2 * across_2
                if math.sqrt(one) + math.sqrt(other) <= limit:
                    return True
    return False


@kernel
def _departure_for(elements_i, elements_j, ready, about, wide, arrival, least, limit, ends):  # noqa: PLR0913
    """A departure near another one for which an arrival is within the limit; NaN if none is."""
    r_1, v_1, r_2, v_2 = ends
    kepler.state(elements_j, arrival, r_2, v_2)
    for place in range(2 * NEAR + 1):
        departure = about + wide * (place - NEAR) / NEAR
        if ready <= departure <= arrival - least:
            kepler.state(elements_i, departure, r_1, v_1)
            if within(r_1, v_1, r_2, v_2, arrival - departure, limit):
                return departure
    return math.nan


@kernel
def earliest_from(elements_i, elements_j, ready, step, least, until, limit):
    """The earliest arrival of who is ready at a time, in continuous time.

    The first arrival of a grid that is within the limit, whenever one leaves, and then as early as
    it can be made by departures nearby.

    Parameters
    ----------
    elements_i, elements_j : (6,) float64
    ready, step, least, until : float
        When one is ready, the step of the grid, the shortest flight and the last arrival [s].
    limit : float
        [m/s].

    Returns
    -------
    departure, arrival : float
        [s]; infinite if there is none.
    """
    count = max(int((until - ready - least) / step) + 1, 0)
    r_1, v_1 = np.empty((count, 3)), np.empty((count, 3))
    ends = np.empty(3), np.empty(3), np.empty(3), np.empty(3)
    r_2, v_2 = ends[2], ends[3]
    found = -1
    arrival, departure = math.inf, math.inf
    for m in range(count):
        kepler.state(elements_i, ready + m * step, r_1[m], v_1[m])
        arrival = ready + least + m * step
        kepler.state(elements_j, arrival, r_2, v_2)
        for k in range(m + 1):
            if within(r_1[k], v_1[k], r_2, v_2, arrival - ready - k * step, limit):
                found = k
                break
        if found >= 0:
            break
    if found < 0:
        return math.inf, math.inf
    departure = ready + found * step
    wide = step
    for _ in range(ZOOMS):
        good, bad = arrival, max(arrival - 2.0 * wide, ready + least)
        for _ in range(HALVINGS):
            middle = 0.5 * (good + bad)
            leaves = _departure_for(
                elements_i, elements_j, ready, departure, wide, middle, least, limit, ends
            )
            if leaves == leaves:
                good, departure = middle, leaves
            else:
                bad = middle
        arrival = good
        wide *= 0.2
    return departure, arrival
