"""Check of drift legs: their cost by the closed form, and burns that meet the target.

The form of :mod:`adr_opt.kernels.legs.drift`, written once more and solved in another way: searches
by golden section, one within the other, in place of Newton steps, and bisection for whole laps.
"""

from __future__ import annotations

import math
from collections.abc import Generator

import numpy as np
import numpy.typing as npt

from ...common.constants import MU_M3_S2
from ...common.errors import InputError
from ...kernels.core.compile import kernel
from ...kernels.legs.co_elliptic import TransferRule
from ...kernels.orbits import ephemeris
from ...legs.families import drift_burns
from ...plan.plan import Leg
from ...problem.instance import Instance
from .drift_ends import GOLDEN, Ends, ends_of
from .figures import check_burns, check_costs, check_times
from .violation import DRIFT_TOLERANCE_M_S, Violation

FloatArray = npt.NDArray[np.float64]

RADII = 50
"""Number of radius intervals between the altitude limits that are searched for the optimum."""

MOST_TILT, TILTS = 0.5, 20
"""Largest change of inclination by the first burn, as a share of speed, and the number of intervals
that are searched for the optimum."""


@kernel
def half_turn(ends: Ends, axis: float) -> float:
    """Time of half a turn on an orbit with a semi-major axis [s]."""
    inclination = math.acos(ends.cosine)
    return float(math.pi / ephemeris.latitude_rate(axis, inclination, ends.oblateness))


@kernel
def arcs_of(ends: Ends, radius: float) -> FloatArray:
    """Arcs of a leg with a given radius of the drift orbit: semi-major axes [m] and times [s].

    Out, drift, back to the co-elliptic orbit, and to the stand-off; (4, 2) float64.
    """
    co_elliptic = radius + ends.fraction * (ends.radius_j - radius)
    arcs = np.empty((4, 2))
    arcs[0, 0], arcs[1, 0] = 0.5 * (ends.radius_i + radius), radius
    arcs[2, 0], arcs[3, 0] = 0.5 * (radius + co_elliptic), 0.5 * (co_elliptic + ends.radius_j)
    arcs[1, 1] = ends.span - ends.approach
    for arc in (0, 2, 3):
        arcs[arc, 1] = half_turn(ends, arcs[arc, 0])
        arcs[1, 1] -= arcs[arc, 1]
    return arcs


@kernel
def laps_of(ends: Ends, radius: float) -> float:
    """Laps gained relative to the target: an integer where the chaser meets it."""
    arcs = arcs_of(ends, radius)
    inclination = math.acos(ends.cosine)
    gained = 3.0 * math.pi
    for arc in range(4):
        rate = ephemeris.node_rate(arcs[arc, 0], inclination, ends.oblateness)
        gained += ends.cosine * rate * arcs[arc, 1]
    gained += ephemeris.latitude_rate(radius, inclination, ends.oblateness) * arcs[1, 1]
    return float((gained - ends.ahead) / (2.0 * math.pi))


@kernel
def parts_with(ends: Ends, radius: float, tilt: float) -> tuple[float, float, float, float, float]:
    """Differences that a drift orbit of some radius [m] and excess inclination [m/s] leaves over.

    The node, and in and across the plane at either end [m/s].
    """
    arcs, turned = arcs_of(ends, radius), tilt / ends.speed
    after = ends.inclination_i + turned
    inclinations = (
        ends.inclination_i + 0.5 * turned,
        after,
        0.5 * (after + ends.inclination_j),
        ends.inclination_j,
    )
    node = ends.node - ends.target_rate * ends.approach
    for arc in range(4):
        rate = ephemeris.node_rate(arcs[arc, 0], inclinations[arc], ends.oblateness)
        node -= rate * arcs[arc, 1]
    speed = math.sqrt(MU_M3_S2 / radius)
    climb = math.sqrt(MU_M3_S2 / ends.radius_i) - speed
    rest = speed - math.sqrt(MU_M3_S2 / ends.radius_j)
    left = ends.speed * (ends.inclination_j - ends.inclination_i) - tilt
    if ends.free:
        lacking = max(0.0, 2.0 * ends.shape - abs(climb) - abs(rest))
        one, other = abs(climb) + 0.5 * lacking, abs(rest) + 0.5 * lacking
    else:
        one, other = math.hypot(climb, ends.shape), math.hypot(rest, ends.shape)
    return ends.speed * ends.sine * node, one, other, tilt, left


@kernel
def cost_with(ends: Ends, radius: float, tilt: float) -> float:
    """ΔV to minimise, with a drift orbit of some radius [m] and excess inclination [m/s]."""
    node, one, other, tilt, left = parts_with(ends, radius, tilt)
    return math.hypot(node, math.hypot(one, tilt) + math.hypot(other, left))


@kernel
def price_with(ends: Ends, radius: float, tilt: float) -> float:
    """ΔV that is charged: by free burns including the part of Δe across the line of the turn."""
    node, one, other, tilt, left = parts_with(ends, radius, tilt)
    whole = cost_with(ends, radius, tilt)
    if not ends.free or ends.shape == 0.0:
        return float(whole)
    place = math.atan2(node, tilt + left)
    x = ends.eccentricities.j[0] - ends.eccentricities.i[0]
    y = ends.eccentricities.j[1] - ends.eccentricities.i[1]
    across = abs(y * math.cos(place) - x * math.sin(place)) * ends.speed
    turn = math.sqrt(max(whole**2 - (one + other) ** 2, 0.0))
    shared = math.hypot(across, turn)
    if across > turn / math.sqrt(3.0):
        shared = math.sin(math.pi / 6.0) * across + math.cos(math.pi / 6.0) * turn
    ridden = shared**2 - (0.5 * across) ** 2 - turn**2
    return math.sqrt(whole**2 + 0.5 * across / (one + other) * ridden)


@kernel
def least_tilted(ends: Ends, radius: float) -> tuple[float, float]:
    """Least ΔV for a radius of the drift orbit and its inclination, by golden section [m/s].

    Between the neighbours of the best of some inclinations.
    """
    low, high = -MOST_TILT * ends.speed, MOST_TILT * ends.speed
    step, best = (high - low) / TILTS, 0
    for number in range(1, TILTS + 1):
        found = cost_with(ends, radius, low + number * step)
        if found < cost_with(ends, radius, low + best * step):
            best = number
    low, high = low + (best - 1) * step, low + (best + 1) * step
    one, other = high - GOLDEN * (high - low), low + GOLDEN * (high - low)
    at_one, at_other = cost_with(ends, radius, one), cost_with(ends, radius, other)
    while high - low > (1e-6 if ends.free else 1e-4):
        if at_one < at_other:
            high, other, at_other = other, one, at_one
            one = high - GOLDEN * (high - low)
            at_one = cost_with(ends, radius, one)
        else:
            low, one, at_one = one, other, at_other
            other = low + GOLDEN * (high - low)
            at_other = cost_with(ends, radius, other)
    return float(min(at_one, at_other)), 0.5 * (low + high)


@kernel
def least_of_all(ends: Ends, low: float, high: float) -> float:
    """Radius of the cheapest drift orbit with a free phase [m].

    The best of some radii, and golden section between its neighbours.
    """
    step, best = (high - low) / RADII, 0
    for number in range(1, RADII + 1):
        if least_tilted(ends, low + number * step)[0] < least_tilted(ends, low + best * step)[0]:
            best = number
    low, high = max(low, low + (best - 1) * step), min(high, low + (best + 1) * step)
    one, other = high - GOLDEN * (high - low), low + GOLDEN * (high - low)
    at_one, at_other = least_tilted(ends, one)[0], least_tilted(ends, other)[0]
    while high - low > 0.1:
        if at_one < at_other:
            high, other, at_other = other, one, at_one
            one = high - GOLDEN * (high - low)
            at_one = least_tilted(ends, one)[0]
        else:
            low, one, at_one = one, other, at_other
            other = low + GOLDEN * (high - low)
            at_other = least_tilted(ends, other)[0]
    return 0.5 * (low + high)


@kernel
def freest(ends: Ends, low: float, high: float) -> float:
    """Radius of the cheapest drift orbit where changes of size absorb eccentricity [m].

    Those drift orbits are looked at apart: they may be few, and where inclinations move the node
    for months there is more than one valley.
    """
    best = least_of_all(ends, low, high)
    first, second = math.sqrt(MU_M3_S2 / ends.radius_i), math.sqrt(MU_M3_S2 / ends.radius_j)
    if not ends.free or abs(first - second) >= 2.0 * ends.shape:
        return float(best)
    middle = 0.5 * (first + second)
    inner = MU_M3_S2 / (middle + ends.shape) ** 2
    outer = MU_M3_S2 / (middle - ends.shape) ** 2
    if outer <= low or inner >= high:
        return float(best)
    other = least_of_all(ends, max(inner, low), min(outer, high))
    return float(other if least_tilted(ends, other)[0] < least_tilted(ends, best)[0] else best)


@kernel
def least_with_laps(ends: Ends, low: float, high: float) -> float:
    """ΔV of the leg: the cheaper of the radii around the optimum that meet the target [m/s].

    Parameters
    ----------
    ends : Ends
    low, high : float
        Altitude limits, as radii of the drift orbit [m].

    Returns
    -------
    float
        Infinite if the target is met with no radius, or there is no time to drift.
    """
    if arcs_of(ends, high)[1, 1] <= 0.0 and arcs_of(ends, low)[1, 1] <= 0.0:
        return math.inf
    least = price = math.inf
    about = math.floor(laps_of(ends, freest(ends, low, high)))
    for laps in (about, about + 1):
        if not laps_of(ends, high) <= laps <= laps_of(ends, low):
            continue
        below, above = low, high
        while above - below > 1e-4:
            middle = 0.5 * (below + above)
            if laps_of(ends, middle) > laps:
                below = middle
            else:
                above = middle
        if arcs_of(ends, below)[1, 1] > 0.0:
            found, tilt = least_tilted(ends, below)
            if found < least:
                least, price = found, price_with(ends, below, tilt)
    return price


def drift_cost(
    origin: FloatArray,
    destination: FloatArray,
    rule: TransferRule,
    departure: float,
    arrival: float,
) -> tuple[float, float]:
    """ΔV of a drift leg, and its part due to eccentricity [m/s].

    Parameters
    ----------
    origin : (columns + 1,) float64
        As it is left, with the rate of its node after that in a last column.
    destination : (columns,) float64
    departure, arrival : float
        [s].
    """
    ends = ends_of(origin, destination, rule, departure, arrival)
    limits = rule.min_radius, rule.max_radius
    if rule.free:  # of the apsides of an orbit half way between both eccentricity vectors
        sizes = [math.hypot(*ends.eccentricities.i), math.hypot(*ends.eccentricities.j)]
        low = limits[0] / (1.0 - 0.5 * sum(sizes))
        limits = low, max(low, limits[1] / (1.0 + 0.5 * sum(sizes)))
    whole = float(least_with_laps(ends, *limits))
    if ends.shape == 0.0:
        return whole, 0.0
    circles = ends._replace(shape=0.0)
    return whole, max(0.0, whole - float(least_with_laps(circles, *limits)))


def check_drift(
    instance: Instance,
    ends: tuple[FloatArray, FloatArray],
    rule: TransferRule,
    number: int,
    leg: Leg,
    free: float,
) -> Generator[Violation, None, tuple[float, float]]:
    """Check that a drift leg has the cost of the closed form, and that its burns meet the target.

    Parameters
    ----------
    ends : (columns + 1,) float64, (columns,) float64
        The origin as it is left, with the rate of its node after that, and the destination.
    """
    as_stated = leg.arrival_s, leg.delta_v_m_s
    if not (yield from check_times(instance, number, leg, free)):
        return as_stated
    delta_v, shape = drift_cost(*ends, rule, leg.departure_s, leg.arrival_s)
    yield from check_costs(delta_v, shape, number, leg, DRIFT_TOLERANCE_M_S)
    try:
        flight = drift_burns.flown(*ends, rule, leg.departure_s, leg.arrival_s)
    except InputError as error:
        yield Violation(number, "burns", str(error))
        return as_stated
    phases = drift_burns.phases(rule)
    yield from check_burns(number, leg, flight.times, flight.vectors, phases)
    return as_stated
