"""Windows of low thrust, and the cost of eccentricities, stated once more for the judge.

That of :mod:`adr_opt.kernels.legs.low_thrust_windows` and
:mod:`adr_opt.kernels.legs.low_thrust_windows`, with the circle summed up piece by piece.
"""

from __future__ import annotations

import math
from itertools import pairwise
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from ...common.constants import DAY_S, EARTH_RADIUS_M
from ...kernels.core.compile import kernel
from .drift_ends import Ends

FloatArray = npt.NDArray[np.float64]

Vector = tuple[float, float]

PIECES = 2000
"""Number of pieces of a window for a mean over it."""


class Shape(NamedTuple):
    """Demand of the eccentricity vectors on both arcs.

    Attributes
    ----------
    still : (float, float)
        What is left of it on arrival without thrust [m/s].
    pumped : ((float, float), (float, float))
        By each m/s of speed that either arc takes off.
    room : ((float, float), (float, float))
        S.
    power : float
        Of the norm in which that and changes of size add up.
    """

    still: Vector
    pumped: tuple[Vector, Vector]
    room: tuple[Vector, Vector]
    power: float


def sun_at(since_j2000: float) -> FloatArray:
    """Unit vector to the Sun, in the frame of the equator."""
    days = since_j2000 / DAY_S
    anomaly = math.radians(357.528 + 0.9856003 * days)
    longitude = 280.460 + 0.9856474 * days
    longitude += 1.915 * math.sin(anomaly) + 0.020 * math.sin(2.0 * anomaly)
    along, tilt = math.radians(longitude), math.radians(23.439)
    return np.array(
        [math.cos(along), math.cos(tilt) * math.sin(along), math.sin(tilt) * math.sin(along)]
    )


def shadow_of(
    radius: float, inclination: float, node: float, since_j2000: float
) -> tuple[float, float]:
    """Argument of latitude of the shadow's middle, and half its width [rad]."""
    sun = sun_at(since_j2000)
    toward = np.array([math.cos(node), math.sin(node), 0.0])
    beyond = np.array(
        [
            -math.sin(node) * math.cos(inclination),
            math.cos(node) * math.cos(inclination),
            math.sin(inclination),
        ]
    )
    x, y = float(sun @ toward), float(sun @ beyond)
    # In shadow where the Sun is behind and the distance to its axis is below the Earth's radius.
    least = math.sqrt(max(1.0 - (EARTH_RADIUS_M / radius) ** 2, 0.0)) / math.hypot(x, y)
    return math.atan2(-y, -x), math.acos(least) if least < 1.0 else 0.0


class LitWindows(NamedTuple):
    """Means over windows of thrust in sunlight.

    Attributes
    ----------
    turn, share : float
        κ, and the share of a revolution.
    single, double : (float, float)
        Of the cosine and sine of the argument of latitude, and of its double.
    """

    turn: float
    share: float
    single: Vector
    double: Vector


def windows_of(window: float, place: float, middle: float, half: float) -> LitWindows:
    """Windows about a place and its opposite, without the shadow.

    The circle is cut where a window or the shadow begins or ends, and summed up piece by piece.
    """
    cuts = {0.0, 2.0 * math.pi}
    for centre, width in ((place, window), (place + math.pi, window), (middle, half)):
        for edge in (centre - width, centre + width):
            cuts.add(edge % (2.0 * math.pi))
    share = mean = 0.0
    sums = np.zeros((2, 2))
    edges = sorted(cuts)
    for low, high in pairwise(edges):
        inside = 0.5 * (low + high)
        away = abs(math.remainder(inside - place, math.pi))
        dark = abs(math.remainder(inside - middle, 2.0 * math.pi)) < half
        if away < window and not dark:
            share += high - low
            mean += abs(math.sin(high - place) - math.sin(low - place))
            for times in (1, 2):
                sums[times - 1] += (
                    (math.sin(times * high) - math.sin(times * low)) / times,
                    (math.cos(times * low) - math.cos(times * high)) / times,
                )
    single, double = sums / share
    return LitWindows(
        share / mean,
        share / (2.0 * math.pi),
        (float(single[0]), float(single[1])),
        (float(double[0]), float(double[1])),
    )


def steered_in(
    window: float, leg: Ends, places: FloatArray, part: float, shadows: tuple[Vector, Vector]
) -> tuple[float, Vector, Shape]:
    """κ of a leg, thrusting shares of its windows, and the demand of eccentricities.

    Parameters
    ----------
    window : float
        Half of its width [rad].
    places : (2,) float64
        Arguments of latitude [rad].
    part : float
        The first arc's, of what both turn the plane.
    shadows : ((float, float), (float, float))
        As :func:`shadow_of` has them.
    """
    given = leg.eccentricities
    drifting = 0.5 * (given.rates[0] + given.rates[1])
    sixteenth = leg.span / 16.0
    angles = 15.0 * sixteenth * drifting, sixteenth * given.rates[1]
    ways, pumped, room = [], [], np.zeros((2, 2))
    for place, shadow, angle, weight in zip(
        places, shadows, angles, (part, 1.0 - part), strict=True
    ):
        turned = _turned(angle)
        way = windows_of(window, float(place), *shadow)
        ways.append(way)
        pumped.append(tuple(float(x) for x in 2.0 * turned @ way.single))
        sunlit = windows_of(0.5 * math.pi, 0.0, *shadow)
        c, s = sunlit.double
        level = 2.5 * np.eye(2) + 1.5 * np.array([[c, s], [s, -c]])
        level -= 4.0 * np.outer(sunlit.single, sunlit.single)
        room += weight * turned @ level @ turned.T
    # On the way the perigee turns at the mean of both rates.
    begun = _turned((drifting - given.rates[0]) * leg.span) @ given.i
    still = leg.speed * (np.array(given.j) - begun)
    turn = part * ways[0].turn + (1.0 - part) * ways[1].turn
    power = 2.0
    if leg.free:
        middles = (np.arange(PIECES) + 0.5) * (window / PIECES)
        longest = np.hypot(2.0 * np.cos(middles), np.sin(middles)).mean()
        room, power = room * longest**2 / 2.5, math.pi / window
    (a, b), (c, d) = room
    shape = Shape(
        (float(still[0]), float(still[1])),
        ((pumped[0][0], pumped[0][1]), (pumped[1][0], pumped[1][1])),
        ((float(a), float(b)), (float(c), float(d))),
        power,
    )
    return turn, (ways[0].share, ways[1].share), shape


def _turned(angle: float) -> FloatArray:
    c, s = math.cos(angle), math.sin(angle)
    return np.array([[c, -s], [s, c]])


@kernel
def with_shape(form: float, shape: Shape, first: float, second: float) -> float:
    """ΔV including eccentricities, from the arcs' reductions of speed [m/s]."""
    (x_1, y_1), (x_2, y_2) = shape.pumped
    x = shape.still[0] - x_1 * first - x_2 * second
    y = shape.still[1] - y_1 * first - y_2 * second
    (xx, xy), (yx, yy) = shape.room
    square = (yy * x * x - (xy + yx) * x * y + xx * y * y) / (xx * yy - xy * yx)
    if shape.power == 2.0:
        return math.sqrt(form * form + square)
    size = abs(first) + abs(second)
    together = (size**shape.power + square ** (0.5 * shape.power)) ** (1.0 / shape.power)
    return math.sqrt(max(form * form - size * size, 0.0) + together * together)
