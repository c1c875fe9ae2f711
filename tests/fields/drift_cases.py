"""Pairs of bodies whose planes drift, and flights of what is planned between them."""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import NamedTuple

import numpy as np
from rows import FloatArray

from adr_opt.common.constants import EARTH_RADIUS_M, MU_M3_S2, OBLATENESS_M2
from adr_opt.fly.flight.mean_flight import MeanDynamics
from adr_opt.problem.orbit import Orbit

FAMILIES_DEG = (96.0, 71.0, 30.0, 120.0, 98.0, 2.0)
"""Inclinations about which pairs are drawn."""


class Pair(NamedTuple):
    """Two orbits, and the same as rows of the kernels."""

    orbit_i: Orbit
    orbit_j: Orbit
    i: FloatArray
    j: FloatArray


def pair_of(orbit_i: Orbit, orbit_j: Orbit, oblateness: float = OBLATENESS_M2) -> Pair:
    """A pair with its rows."""
    return Pair(
        orbit_i, orbit_j, np.array(orbit_i.row(oblateness)), np.array(orbit_j.row(oblateness))
    )


def drawn(
    rng: np.random.Generator,
    inclination_deg: float,
    raan_deg: float,
    eccentric: bool = False,
    altitudes_m: tuple[float, float] = (650e3, 900e3),
) -> Orbit:
    """An orbit at an altitude between two."""
    return Orbit(
        semi_major_axis_m=EARTH_RADIUS_M + rng.uniform(*altitudes_m),
        eccentricity=rng.uniform(0.0, 0.01) if eccentric else 0.0,
        inclination_deg=inclination_deg,
        raan_deg=raan_deg,
        argument_of_perigee_deg=rng.uniform(0.0, 360.0),
        true_anomaly_deg=rng.uniform(0.0, 360.0),
    )


def pairs(
    seed: int, number: int, spread_deg: float = 1.0, oblateness: float = OBLATENESS_M2
) -> Iterator[Pair]:
    """Neighbouring planes of several families, a third of the orbits eccentric."""
    rng = np.random.default_rng(seed)
    for case in range(number):
        inclination = FAMILIES_DEG[case % len(FAMILIES_DEG)]
        raan = rng.uniform(0.0, 360.0)
        yield pair_of(
            *(
                drawn(
                    rng,
                    inclination + rng.normal(0.0, 0.5),
                    raan + rng.normal(0.0, spread_deg),
                    case % 3 == 0,
                )
                for _ in range(2)
            ),
            oblateness,
        )


class Met(NamedTuple):
    """End of a flight: misses [m] and angle to the plane of the target [rad].

    Attributes
    ----------
    behind : float
        Miss at the stand-off.
    tilted : float
        Angle between the chaser's plane and the target's, once it stands there.
    arrival : float
        Miss at the target.
    highest, lowest : float
        Of the radii of apsides of all arcs [m].
    """

    behind: float
    tilted: float
    arrival: float
    highest: float
    lowest: float


def fly(
    truth: MeanDynamics, pair: Pair, times: FloatArray, vectors: FloatArray, standoff: float
) -> Met:
    """Fly burns, of which the last two are those of the approach, in the mean dynamics."""
    now = float(times[0])
    position, velocity = truth.body(pair.orbit_i, now)
    behind = tilted = math.nan
    highest, lowest = 0.0, math.inf
    for number, (time, vector) in enumerate(zip(times, vectors, strict=True)):
        if time > now:
            low, high = apsides(position, velocity)
            highest, lowest = max(highest, high), min(lowest, low)
            position, velocity = truth.coast((position, velocity), float(time) - now)
            now = float(time)
        if number == len(times) - 2:
            lag = math.degrees(standoff / pair.orbit_j.semi_major_axis_m)
            circle = pair.orbit_j.argument_of_perigee_deg - lag
            goal, along = truth.body(pair.orbit_j.replace(argument_of_perigee_deg=circle), now)
            behind = math.dist(position, goal)
            normals = np.cross(position, velocity), np.cross(goal, along)
            tilted = math.atan2(
                float(np.linalg.norm(np.cross(*normals))), float(normals[0] @ normals[1])
            )
        velocity = velocity + vector
    return Met(
        behind, tilted, math.dist(position, truth.body(pair.orbit_j, now)[0]), highest, lowest
    )


def apsides(position: FloatArray, velocity: FloatArray) -> tuple[float, float]:
    """Least and greatest radius of an arc's orbit [m]."""
    momentum = np.cross(position, velocity)
    vector = np.cross(velocity, momentum) / MU_M3_S2 - position / np.linalg.norm(position)
    eccentricity = float(np.linalg.norm(vector))
    parameter = float(momentum @ momentum) / MU_M3_S2
    return parameter / (1.0 + eccentricity), parameter / (1.0 - eccentricity)
