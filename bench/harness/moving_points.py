"""Encounter rates by Monte Carlo that only moves points on orbits.

Knows nothing of the closed form. Points are uniform in mean anomaly and argument of perigee. With
random nodes longitudes are uniform, so that two points whose radii and latitudes agree stand for
encounters of known probability; their relative speed is that of their velocities there. To waste no
points, mean anomalies are drawn from the arcs whose radii both orbits reach, and weighed by them.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from scipy.spatial import cKDTree

from adr_opt.common.constants import MU_M3_S2

NEAR_RAD, NEAR_SHARE = 0.004, 0.005
"""Arguments of latitude that count as equal, and radii, as a share of those that both reach."""


@dataclass(frozen=True)
class MovingOrbit:
    """An orbit of random node and perigee.

    Attributes
    ----------
    perigee, apogee : float
        Radii [m].
    tilt : float
        Inclination [rad].
    """

    perigee: float
    apogee: float
    tilt: float


@dataclass(frozen=True)
class Points:
    """Points on an orbit: radii [m], latitudes [rad], velocities up, east, north [m/s], weights."""

    radii: np.ndarray
    latitudes: np.ndarray
    velocities: np.ndarray
    weights: np.ndarray

    def within(self, reach: float) -> Points:
        """The points whose latitude has a sine of at most ``reach``."""
        here = np.abs(np.sin(self.latitudes)) <= reach * (1.0 + 1e-12)
        return Points(
            self.radii[here], self.latitudes[here], self.velocities[here], self.weights[here]
        )


def moving_rate(
    one: MovingOrbit,
    other: MovingOrbit,
    count: int,
    blur_m: float,
    random: np.random.Generator,
    near: float = NEAR_RAD,
) -> tuple[float, float]:
    """Rate of encounters within a distance of 1 m, and its standard error [1/s].

    Parameters
    ----------
    one, other : MovingOrbit
    count : int
        Number of points on each orbit.
    blur_m : float
        Width over which each perigee and apogee is drawn anew for every point [m].
    random : Generator
    near : float
        Arguments of latitude that count as equal [rad]; fewer where the rate depends on them.
    """
    low, high = max(one.perigee, other.perigee), min(one.apogee, other.apogee)
    if low >= high:
        return 0.0, 0.0
    # A margin, so that points at the end of one shell find those of the other beyond it.
    margin = max(blur_m, 2.0 * NEAR_SHARE * (high - low))
    low, high = low - margin, high + margin
    batches = [_rate(one, other, count // 8, blur_m, (low, high), random, near) for _ in range(8)]
    return float(np.mean(batches)), float(np.std(batches, ddof=1) / math.sqrt(8))


def _rate(
    one: MovingOrbit,
    other: MovingOrbit,
    count: int,
    blur_m: float,
    radii: tuple[float, float],
    random: np.random.Generator,
    near: float,
) -> float:
    first = _points(one, count, blur_m, radii, random)
    second = _points(other, count, blur_m, radii, random)
    reach = math.sin(min(one.tilt, math.pi - one.tilt, other.tilt, math.pi - other.tilt))
    first, second = (each.within(reach) for each in (first, second))
    places = [np.arcsin(np.clip(np.sin(each.latitudes) / reach, -1, 1)) for each in (first, second)]
    near_radius = NEAR_SHARE * (radii[1] - radii[0])
    trees = [
        cKDTree(np.column_stack((each.radii / near_radius, place / near)))
        for each, place in zip((first, second), places, strict=True)
    ]
    pairs = trees[0].sparse_distance_matrix(trees[1], 1.0, p=np.inf, output_type="ndarray")
    i, j = pairs["i"], pairs["j"]
    speeds = np.linalg.norm(first.velocities[i] - second.velocities[j], axis=1)
    radius = 0.5 * (first.radii[i] + second.radii[j])
    place = np.cos(0.5 * (places[0][i] + places[1][j]))
    volume = 4.0 * near_radius * near * 2.0 * math.pi * radius**2 * reach * place
    weights = first.weights[i] * second.weights[j]
    return float(math.pi * np.sum(weights * speeds / volume) / count**2)


def _points(
    orbit: MovingOrbit,
    count: int,
    blur_m: float,
    radii: tuple[float, float],
    random: np.random.Generator,
) -> Points:
    ends = np.sort(
        np.array([[orbit.perigee], [orbit.apogee]])
        + blur_m * (random.uniform(size=(2, count)) - 0.5),
        axis=0,
    )
    axes = 0.5 * (ends[0] + ends[1])
    eccentricities = 0.5 * (ends[1] - ends[0]) / axes
    bounds = np.array(
        [np.arccos(np.clip((1.0 - r / axes) / eccentricities, -1.0, 1.0)) for r in radii]
    )
    means = bounds - eccentricities * np.sin(bounds)
    weights = (means[1] - means[0]) / math.pi
    mean = means[0] + (means[1] - means[0]) * random.uniform(size=count)
    mean *= np.where(random.uniform(size=count) < 0.5, -1.0, 1.0)
    anomaly = mean.copy()
    for _ in range(30):
        anomaly -= (anomaly - eccentricities * np.sin(anomaly) - mean) / (
            1.0 - eccentricities * np.cos(anomaly)
        )
    true = 2.0 * np.arctan2(
        np.sqrt(1.0 + eccentricities) * np.sin(0.5 * anomaly),
        np.sqrt(1.0 - eccentricities) * np.cos(0.5 * anomaly),
    )
    along = true + random.uniform(0.0, 2.0 * math.pi, count)
    latitudes = np.arcsin(np.sin(orbit.tilt) * np.sin(along))
    semi_latus = axes * (1.0 - eccentricities**2)
    unit = np.sqrt(MU_M3_S2 / semi_latus)
    across = unit * (1.0 + eccentricities * np.cos(true))
    east = np.cos(orbit.tilt) / np.cos(latitudes)
    north = np.sin(orbit.tilt) * np.cos(along) / np.cos(latitudes)
    velocities = np.column_stack(
        (unit * eccentricities * np.sin(true), across * east, across * north)
    )
    return Points(axes * (1.0 - eccentricities * np.cos(anomaly)), latitudes, velocities, weights)
