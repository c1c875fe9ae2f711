"""Altitude against time of a leg, from its burns alone.

Two-body motion by Kepler's equation, from the state in which the chaser leaves its origin, burn by
burn; nothing here comes from the kernels. The safety ellipse of the approach is flown within a
quarter of the stand-off of the target's orbit, and the model takes that orbit for it.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Sequence
from itertools import pairwise

import numpy as np
import numpy.typing as npt

from adr_opt.problem.orbit import Orbit
from adr_opt.problem.settings import KeepOutZone

MU = 3.986004418e14
EARTH_RADIUS_M = 6378137.0

Array = npt.NDArray[np.float64]
Burns = Sequence[tuple[float, Sequence[float], str]]
"""Time [s], inertial impulse [m/s] and phase of each burn."""


def on_circle(orbit: Orbit, time_s: float) -> tuple[Array, Array]:
    """Position and velocity of a body on its mean circle."""
    radius, inclination, raan, latitude = orbit.circular_elements()
    u = latitude + math.sqrt(MU / radius**3) * time_s
    node = np.array([math.cos(raan), math.sin(raan), 0.0])
    tilt = math.cos(inclination)
    square = np.array([-math.sin(raan) * tilt, math.cos(raan) * tilt, math.sin(inclination)])
    speed = math.sqrt(MU / radius)
    return (
        radius * (math.cos(u) * node + math.sin(u) * square),
        speed * (-math.sin(u) * node + math.cos(u) * square),
    )


class Coast:
    """A stretch of two-body motion from a state at a time until the next burn."""

    def __init__(self, position: Array, velocity: Array, start_s: float, end_s: float) -> None:
        self.position, self.velocity = position, velocity
        self.start_s, self.end_s = start_s, end_s
        self.radius_m = float(np.linalg.norm(position))
        self.a = 1.0 / (2.0 / self.radius_m - float(velocity @ velocity) / MU)
        self.rate = math.sqrt(MU / self.a**3)
        self.e_cos = 1.0 - self.radius_m / self.a
        self.e_sin = float(position @ velocity) / math.sqrt(MU * self.a)

    def anomaly(self, times_s: Array) -> Array:
        """Eccentric anomaly since the start, by Newton's method on Kepler's equation."""
        mean = self.rate * (times_s - self.start_s)
        x = mean.copy()
        for _ in range(6):  # converges quadratically; eccentricities of legs are below 0.1
            value = x - self.e_cos * np.sin(x) + self.e_sin * (1.0 - np.cos(x)) - mean
            x = x - value / (1.0 - self.e_cos * np.cos(x) + self.e_sin * np.sin(x))
        return x

    def radii(self, times_s: Array) -> Array:
        """Distance from the centre of the Earth [m]."""
        x = self.anomaly(times_s)
        return self.a * (1.0 - self.e_cos * np.cos(x) + self.e_sin * np.sin(x))

    def state(self, time_s: float) -> tuple[Array, Array]:
        """Position and velocity."""
        x = float(self.anomaly(np.array([time_s]))[0])
        gone = time_s - self.start_s
        r = float(self.radii(np.array([time_s]))[0])
        f = 1.0 - self.a / self.radius_m * (1.0 - math.cos(x))
        g = gone - (x - math.sin(x)) / self.rate
        f_dot = -math.sqrt(MU * self.a) / (r * self.radius_m) * math.sin(x)
        g_dot = 1.0 - self.a / r * (1.0 - math.cos(x))
        return (
            f * self.position + g * self.velocity,
            f_dot * self.position + g_dot * self.velocity,
        )


def coasts(origin: Orbit, burns: Burns) -> Iterator[Coast]:
    """The stretches between the burns, up to the approach."""
    position, velocity = on_circle(origin, burns[0][0])
    for (time, impulse, phase), (following, _, _) in pairwise(burns):
        if phase == "approach":
            return
        coast = Coast(position, velocity + np.array(impulse), time, following)
        yield coast
        position, velocity = coast.state(following)


def profile(
    origin: Orbit, destination: Orbit, burns: Burns, samples: int = 200
) -> tuple[Array, Array]:
    """Times [s] and altitudes [m] from departure to arrival."""
    times, altitudes = [], []
    for coast in coasts(origin, burns):
        moments = np.linspace(coast.start_s, coast.end_s, samples)
        times.append(moments)
        altitudes.append(coast.radii(moments) - EARTH_RADIUS_M)
    approach = np.array([burns[-2][0], burns[-1][0]])
    times.append(approach)
    altitudes.append(np.full(2, destination.semi_major_axis_m - EARTH_RADIUS_M))
    return np.concatenate(times), np.concatenate(altitudes)


def crosses(
    origin: Orbit,
    destination: Orbit,
    burns: Burns,
    zones: Iterable[KeepOutZone],
    margin_m: float = 0.0,
    margin_s: float = 0.0,
    samples: int = 40,
) -> bool:
    """Whether a leg is inside a zone at some moment; margins make the zones larger.

    While a window is open the altitude changes without jumps: it meets the band if it is not all
    above or all below. So samples of a stretch only have to find its extremes.
    """
    path = list(coasts(origin, burns))
    arrival = destination.semi_major_axis_m
    for zone in zones:
        low = zone.min_altitude_m - margin_m + EARTH_RADIUS_M
        high = zone.max_altitude_m + margin_m + EARTH_RADIUS_M
        start, end = zone.start_s - margin_s, zone.end_s + margin_s
        for coast in path:
            first, last = max(coast.start_s, start), min(coast.end_s, end)
            if first <= last:
                radii = coast.radii(np.linspace(first, last, samples))
                if radii.min() <= high and radii.max() >= low:
                    return True
        if burns[-2][0] <= end and burns[-1][0] >= start and low <= arrival <= high:
            return True
    return False
