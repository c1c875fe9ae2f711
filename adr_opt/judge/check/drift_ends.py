"""Ends of a leg that drifts, as the judge recomputes them from its bodies."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from ...common.constants import MU_M3_S2
from ...kernels.legs.co_elliptic import TransferRule
from ...kernels.orbits import ephemeris

FloatArray = npt.NDArray[np.float64]

GOLDEN = 0.5 * (math.sqrt(5.0) - 1.0)
"""Share of an interval that golden section keeps."""


class Eccentricities(NamedTuple):
    """Eccentricity vectors of both ends of a leg on arrival, if there is no burn.

    Attributes
    ----------
    i, j : (float, float)
        Along the node and ahead of it.
    rates : (float, float)
        Of both perigees [rad/s].
    """

    i: tuple[float, float]
    j: tuple[float, float]
    rates: tuple[float, float]


class Ends(NamedTuple):
    """A drift leg between two times, as recomputed by the judge.

    Attributes
    ----------
    radius_i, inclination_i, radius_j, inclination_j : float
        [m], [rad].
    speed, sine, cosine : float
        V̄ [m/s], sin ī and cos ī.
    span, approach : float
        T, and the part of it that the approach takes [s].
    node : float
        What the chaser has to gain on the node of the origin until the end of the leg [rad].
    target_rate : float
        Of the target's node [rad/s].
    ahead : float
        What it has to gain on its own argument of latitude until the stand-off, but for turns, and
        with cos ī times its node [rad].
    shape : float
        E [m/s].
    fraction, oblateness : float
        f; J2 R² [m²].
    eccentricities : Eccentricities
    free : bool
        Whether the leg has the price of free burns.
    """

    radius_i: float
    inclination_i: float
    radius_j: float
    inclination_j: float
    speed: float
    sine: float
    cosine: float
    span: float
    approach: float
    node: float
    target_rate: float
    ahead: float
    shape: float
    fraction: float
    oblateness: float
    eccentricities: Eccentricities
    free: bool


def ends_of(
    origin: FloatArray,
    destination: FloatArray,
    rule: TransferRule,
    departure: float,
    arrival: float,
) -> Ends:
    """The leg between two times [s].

    Parameters
    ----------
    origin : (columns + 1,) float64
        As it is left, with the rate of its node after that in a last column.
    destination : (columns,) float64
    """
    rate_i = float(ephemeris.coasting_node_rate_at(origin, departure))
    rate_j = float(ephemeris.node_rate_at(destination, arrival))
    radius_i = float(ephemeris.radius_at(origin, departure))
    radius_j = float(ephemeris.radius_at(destination, arrival))
    inclination_i = float(ephemeris.inclination_at(origin, departure))
    inclination_j = float(ephemeris.inclination_at(destination, arrival))
    span = arrival - departure
    radius, inclination = 0.5 * (radius_i + radius_j), 0.5 * (inclination_i + inclination_j)
    speed, sine = math.sqrt(MU_M3_S2 / radius), math.sin(inclination)
    node = ephemeris.node_at(destination, arrival) - ephemeris.node_at(origin, departure)
    if sine > 0.0:
        # By the nearer way if half of the size and of the inclination is changed at either end.
        change = radius_j - radius_i, inclination_j - inclination_i
        lags = _half_drift(radius, inclination, change, 0.5 * (rate_i + rate_j), rule.oblateness)
        halfway = rate_i * span - lags * span
        node = halfway + math.remainder(node - halfway, 2.0 * math.pi)
    approach = rule.approach_revolutions * ephemeris.revolution_at(destination, ephemeris.EPOCH_S)
    met = arrival - approach
    ahead = ephemeris.latitude_at(destination, met) - ephemeris.latitude_at(origin, departure)
    ahead += math.cos(inclination) * (node - rate_j * approach)
    ahead -= rule.standoff / radius_j
    vectors = [
        float(ephemeris.eccentricity_at(orbit, arrival))
        * np.array([math.cos(perigee), math.sin(perigee)])
        for orbit in (origin, destination)
        for perigee in [float(ephemeris.perigee_at(orbit, arrival))]
    ]
    return Ends(
        radius_i,
        inclination_i,
        radius_j,
        inclination_j,
        speed,
        sine,
        math.cos(inclination),
        span,
        float(approach),
        float(node),
        rate_j,
        float(ahead),
        0.25 * speed * float(np.linalg.norm(vectors[1] - vectors[0])),
        rule.first_leg_fraction,
        rule.oblateness,
        Eccentricities(
            (float(vectors[0][0]), float(vectors[0][1])),
            (float(vectors[1][0]), float(vectors[1][1])),
            (
                float(ephemeris.perigee_rate_at(origin, departure)),
                float(ephemeris.perigee_rate_at(destination, arrival)),
            ),
        ),
        rule.free,
    )


def _half_drift(
    radius: float, inclination: float, change: tuple[float, float], rate: float, oblateness: float
) -> float:
    """Extra node lag halfway between both orbits, to first order [rad/s].

    Parameters
    ----------
    radius, inclination, rate : float
        Means of both orbits; the rate is that of the node [m], [rad], [rad/s].
    change : (float, float)
        From the origin to the destination of radius and inclination [m], [rad].
    oblateness : float
        J2 R² [m²].
    """
    by_inclination = rate * math.tan(inclination)
    if abs(math.cos(inclination)) <= POLAR:
        speed = math.sqrt(MU_M3_S2 / radius)
        by_inclination = -1.5 * oblateness * speed / radius**3 * math.sin(inclination)
    climb = 0.5 * change[0] / radius
    return 0.5 * (7.0 * rate * climb + by_inclination * change[1])


POLAR = 1e-3
"""Cosine of the mean inclination below which rate · tan ī is replaced by its limit."""
