"""Orbital planes, turns between them and arcs within them, in the mean dynamics.

See docs/model.md section 2.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from ..common.constants import MU_M3_S2
from ..kernels.orbits import ephemeris

FloatArray = npt.NDArray[np.float64]

CLOSE_M = 1e-7
"""Step of the radius below which the iteration ends [m]."""


class Plane(NamedTuple):
    """An orbital plane at a time: inclination and RAAN [rad]."""

    inclination: float
    raan: float

    def carried(self, angle: float) -> Plane:
        """The plane after a shift of its node."""
        return Plane(self.inclination, self.raan + angle)


class Turn(NamedTuple):
    """A change of plane in two halves, half a revolution apart on one line of nodes.

    Attributes
    ----------
    before, after : float
        Argument of latitude of the line in the plane that is left and in the one that is taken.
    angle : float
        [rad].
    middle : Plane
        Between the two burns.
    """

    before: float
    after: float
    angle: float
    middle: Plane


def turn_between(first: Plane, second: Plane) -> Turn:
    """The change from one plane to another, as if both were fixed meanwhile."""
    before, after, angle = ephemeris.relative_node(*first, *second)
    return Turn(before, after, angle, between(first, second, angle, 0.5))


def between(first: Plane, second: Plane, angle: float, share: float) -> Plane:
    """The plane after a share of a turn with a given total angle [rad]."""
    rest = 1.0 - share
    if angle > 0.0:
        rest, share = math.sin(rest * angle), math.sin(share * angle)
    # In numbers and not in arrays: this is most of what drifts take to be flown.
    one, other = normal_of(first), normal_of(second)
    x, y, z = (rest * a + share * b for a, b in zip(one, other, strict=True))
    return Plane(math.atan2(math.hypot(x, y), z), math.atan2(x, -y))


def normal_of(plane: Plane) -> tuple[float, float, float]:
    """Unit normal of a plane, as in :func:`adr_opt.kernels.orbits.ephemeris.frame`."""
    sine = math.sin(plane.inclination)
    return (sine * math.sin(plane.raan), -sine * math.cos(plane.raan), math.cos(plane.inclination))


class Arcs:
    """Times and node shifts of half ellipses and circles in the mean dynamics."""

    def __init__(self, oblateness: float) -> None:
        self._oblateness = oblateness

    def half(self, r1: float, r2: float, inclination: float) -> tuple[float, float]:
        """Half a revolution between two apsides: its duration [s] and node shift [rad]."""
        a = 0.5 * (r1 + r2)
        time = math.pi / self.latitude_rate(a, inclination)
        return time, time * self.node_rate(a, inclination)

    def node_rate(self, radius: float, inclination: float) -> float:
        """Node rate of a circle [rad/s]."""
        return float(ephemeris.node_rate(radius, inclination, self._oblateness))

    def latitude_rate(self, radius: float, inclination: float) -> float:
        """Rate of the argument of latitude on a circle [rad/s]."""
        return float(ephemeris.latitude_rate(radius, inclination, self._oblateness))

    def radius_of(self, rate: float, inclination: float) -> float:
        """Radius of the circle with a given rate of the argument of latitude."""
        r = float((MU_M3_S2 / rate**2) ** (1.0 / 3.0))
        for _ in range(20):
            step = (self.latitude_rate(r, inclination) - rate) * r / (1.5 * rate)
            r += step
            if abs(step) < CLOSE_M:
                break
        return r


def outward(plane: Plane, latitude: float) -> FloatArray:
    """Unit vector from the Earth towards an argument of latitude in a plane, shape (3,)."""
    ascending, beyond, _ = ephemeris.frame(*plane)
    vector: FloatArray = math.cos(latitude) * ascending + math.sin(latitude) * beyond
    return vector


def ahead(plane: Plane, position: FloatArray) -> FloatArray:
    """Unit vector along the motion at a position in a plane, shape (3,)."""
    (a, b, c), (x, y, z) = normal_of(plane), position.tolist()
    vector: FloatArray = np.array([b * z - c * y, c * x - a * z, a * y - b * x])
    return vector / np.linalg.norm(vector)


def turned(vector: FloatArray, angle: float) -> FloatArray:
    """A vector rotated about the axis of the Earth, shape (3,)."""
    copy = vector.copy()
    ephemeris.turn(copy, angle)
    return copy
