"""The cheapest low-thrust leg between two times, by searches that share nothing with the kernels.

Golden sections search, and the times of thrust are repeated until they stay. ``verify`` asks.
"""

from __future__ import annotations

import math

import numpy as np
import numpy.typing as npt

from ...common.constants import DAY_S, MU_M3_S2
from ...kernels.core.compile import kernel
from ...kernels.legs.co_elliptic import TransferRule
from ...problem.drives import Drive, since_j2000_s
from ...problem.instance import Instance
from .drift_ends import GOLDEN, Ends, ends_of
from .low_thrust_form import (
    WINDOWS_DEG,
    Steered,
    arc_costs,
    laps_at,
    places_of,
    settled,
    shadows_of,
)
from .low_thrust_windows import steered_in

FloatArray = npt.NDArray[np.float64]

LONGER_S = 150.0 * DAY_S
"""Duration above which a leg may turn the node by one more or one less whole turn [s]."""

ROUNDS, FURTHER = 400, 8
"""Maximum number of rounds in which times of thrust settle, and number of laps beyond the two about
the optimum of free phase that are tried."""

ROUNDED_M_S = 0.02
"""Smoothing of the tips of both arcs' parts in the free-phase optimum: where many splits cost the
same, the optimum is in their middle [m/s]."""

SPEEDS, TILTS = 40, 24
"""Number of intervals of speeds and of inclinations that are searched for the optimum."""


@kernel
def least_tilt(
    ends: Ends, steered: Steered, times: tuple[float, float], speed: float, about: float, far: float
) -> float:
    """The best change of inclination by the first arc: samples, then golden section."""
    step, best, least = 2.0 * far / TILTS, 0, math.inf
    for number in range(TILTS + 1):
        found = arc_costs(ends, steered, times, speed, about - far + number * step)[0]
        if found < least:
            best, least = number, found
    low, high = about - far + (best - 1) * step, about - far + (best + 1) * step
    one, other = high - GOLDEN * (high - low), low + GOLDEN * (high - low)
    at_one = arc_costs(ends, steered, times, speed, one)[0]
    at_other = arc_costs(ends, steered, times, speed, other)[0]
    while high - low > 1e-4:
        if at_one < at_other:
            high, other, at_other = other, one, at_one
            one = high - GOLDEN * (high - low)
            at_one = arc_costs(ends, steered, times, speed, one)[0]
        else:
            low, one, at_one = one, other, at_other
            other = low + GOLDEN * (high - low)
            at_other = arc_costs(ends, steered, times, speed, other)[0]
    return 0.5 * (low + high)


@kernel
def best_speed(
    ends: Ends,
    steered: Steered,
    times: tuple[float, float],
    low: float,
    high: float,
    about: float,
    far: float,
) -> tuple[float, float]:
    """Speed and change of inclination of the cheapest drift orbit with a free phase [m/s]."""
    step, best, least = (high - low) / SPEEDS, 0, math.inf
    for number in range(SPEEDS + 1):
        speed = low + number * step
        tilt = least_tilt(ends, steered, times, speed, about, far)
        found = arc_costs(ends, steered, times, speed, tilt)[0]
        if found < least:
            best, least = number, found
    low, high = max(low, low + (best - 1) * step), min(high, low + (best + 1) * step)
    while high - low > 1e-3:
        one, other = high - GOLDEN * (high - low), low + GOLDEN * (high - low)
        at_one = least_tilt(ends, steered, times, one, about, far)
        at_other = least_tilt(ends, steered, times, other, about, far)
        if (
            arc_costs(ends, steered, times, one, at_one)[0]
            < arc_costs(ends, steered, times, other, at_other)[0]
        ):
            high = other
        else:
            low = one
    speed = 0.5 * (low + high)
    return speed, least_tilt(ends, steered, times, speed, about, far)


@kernel
def cost_of(ends: Ends, steered: Steered, sharp: Steered, slowest: float, fastest: float) -> float:
    """ΔV of the leg with given places of thrust; infinite if there is no time for it [m/s].

    Parameters
    ----------
    steered, sharp : Steered
        With rounded tips and without.
    slowest, fastest : float
        Circular speeds at the altitude limits [m/s].
    """
    room, end = ends.span - ends.approach, math.sqrt(MU_M3_S2 / ends.radius_j)
    close = 1e-6 * ends.span
    times, speed, tilt = (0.0, 0.0), end, 0.0
    far, low, high = 0.5 * ends.speed, slowest, fastest
    for _ in range(ROUNDS):
        speed, tilt = best_speed(ends, steered, times, low, high, tilt, far)
        _, first, second = arc_costs(ends, steered, times, speed, tilt)
        times, change = settled(times, steered, first, second)
        if times[0] + times[1] > room:
            return math.inf
        if change < 10.0 * close:
            break
        # From here on it is near.
        far = 100.0
        low, high = max(slowest, speed - 60.0), min(fastest, speed + 60.0)
    least = math.inf
    about = math.floor(laps_at(ends, times, speed))
    for laps in range(about - FURTHER, about + FURTHER + 2):
        these, there = times, tilt
        for _ in range(ROUNDS):
            below, above = slowest, fastest
            if not laps_at(ends, these, below) <= laps <= laps_at(ends, these, above):
                break
            while above - below > 1e-8:
                middle = 0.5 * (below + above)
                if laps_at(ends, these, middle) > laps:
                    above = middle
                else:
                    below = middle
            there = least_tilt(ends, sharp, these, below, there, 100.0)
            _, first, second = arc_costs(ends, sharp, these, below, there)
            these, change = settled(these, sharp, first, second)
            if these[0] + these[1] > room:
                break
            if change < close:
                least = min(least, first + second)
                break
    return least


def low_thrust_cost(
    ends: tuple[FloatArray, FloatArray],
    rule: TransferRule,
    since_j2000: float,
    thrust: tuple[float, float],
    departure: float,
    arrival: float,
) -> float:
    """ΔV of a low-thrust leg between two times, by the best of its windows [m/s].

    Parameters
    ----------
    ends : (columns + 1,) float64, (columns,) float64
        The origin as it is left, with the rate of its node after that, and the destination.
    since_j2000 : float
        The epoch [s].
    thrust : (float, float)
        Acceleration at departure [m/s²] and exhaust speed [m/s].
    """
    nearer = ends_of(*ends, rule, departure, arrival)
    slowest, fastest = (
        math.sqrt(MU_M3_S2 / radius) for radius in (rule.max_radius, rule.min_radius)
    )
    shadows, rates = shadows_of(ends, nearer, since_j2000, departure, arrival)
    least = math.inf
    turns = (0.0, -1.0, 1.0) if arrival - departure > LONGER_S else (0.0,)
    for turn in turns:
        more = 2.0 * math.pi * turn
        leg = nearer._replace(node=nearer.node + more, ahead=nearer.ahead + nearer.cosine * more)
        places, part = places_of(leg, rates, (rule.min_radius, rule.max_radius))
        for window in WINDOWS_DEG:
            found_in = steered_in(math.radians(window), leg, places, part, shadows)
            steered = Steered(*found_in, *thrust, ROUNDED_M_S)
            sharp = steered._replace(rounded=0.0)
            found = float(cost_of(leg, steered, sharp, slowest, fastest))
            if found == math.inf:  # there may be an optimum on either side, and no leg with one
                there = math.sqrt(MU_M3_S2 / leg.radius_i)
                found = min(
                    float(cost_of(leg, steered, sharp, slowest, there)),
                    float(cost_of(leg, steered, sharp, there, fastest)),
                )
            least = min(least, found)
    return least


def cost_between(
    instance: Instance,
    ends: tuple[FloatArray, FloatArray],
    rule: TransferRule,
    drive: Drive,
    departure: float,
    arrival: float,
    mass_kg: float | None = None,
) -> float:
    """ΔV of a low-thrust leg between two times, of the heaviest chaser or one of a mass [m/s]."""
    mass_kg = drive.heaviest_kg if mass_kg is None else mass_kg
    return low_thrust_cost(
        ends,
        rule,
        since_j2000_s(instance.epoch),
        (drive.thrust_n / mass_kg, drive.exhaust_m_s),
        departure,
        arrival,
    )
