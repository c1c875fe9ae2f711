"""Orbits rounded to the digits of the file, including near-circular ones with uniform elements."""

from __future__ import annotations

from ...common.constants import EARTH_RADIUS_M
from ...problem.orbit import Orbit
from .stream import Uniform

Range = tuple[float, float]


def rounded(
    semi_major_axis_m: float,
    eccentricity: float,
    inclination_deg: float,
    raan_deg: float,
    argument_of_perigee_deg: float,
    true_anomaly_deg: float,
) -> Orbit:
    """An orbit, rounded to the digits of the file."""
    return Orbit(
        semi_major_axis_m=round(semi_major_axis_m, 3),
        eccentricity=round(eccentricity, 7),
        inclination_deg=round(inclination_deg, 6),
        raan_deg=round(raan_deg, 6),
        argument_of_perigee_deg=round(argument_of_perigee_deg, 6),
        true_anomaly_deg=round(true_anomaly_deg, 6),
    )


def draw_ellipse(
    uniform: Uniform,
    altitude_km: Range,
    inclination_deg: Range,
    eccentricity: Range,
    raan_deg: Range,
) -> Orbit:
    """An orbit drawn from ranges of elements.

    Perigee and anomaly go all around. The altitude is that of the semi-major axis.
    """
    altitude, inclination = uniform(*altitude_km), uniform(*inclination_deg)
    return rounded(
        EARTH_RADIUS_M + 1e3 * altitude,
        uniform(*eccentricity),
        inclination,
        uniform(*raan_deg),
        uniform(0.0, 360.0),
        uniform(0.0, 360.0),
    )
