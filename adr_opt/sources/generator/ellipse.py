"""Nearly circular orbits whose elements are independent and uniform."""

from __future__ import annotations

from ...common.constants import EARTH_RADIUS_M
from ...problem.orbit import Orbit
from .stream import Uniform

Range = tuple[float, float]


def draw_ellipse(
    uniform: Uniform,
    altitude_km: Range,
    inclination_deg: Range,
    eccentricity: Range,
    raan_deg: Range,
) -> Orbit:
    """An orbit from ranges of its elements, rounded to the digits of the file.

    Perigee and anomaly go all around. The altitude is that of the semi-major axis.
    """
    altitude, inclination = uniform(*altitude_km), uniform(*inclination_deg)
    return Orbit(
        semi_major_axis_m=round(EARTH_RADIUS_M + 1e3 * altitude, 3),
        eccentricity=round(uniform(*eccentricity), 7),
        inclination_deg=round(inclination, 6),
        raan_deg=round(uniform(*raan_deg), 6),
        argument_of_perigee_deg=round(uniform(0.0, 360.0), 6),
        true_anomaly_deg=round(uniform(0.0, 360.0), 6),
    )
