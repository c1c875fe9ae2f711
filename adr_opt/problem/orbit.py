"""Orbits: Keplerian elements at the epoch of an instance, the planning circle, numbers of a fit."""

from __future__ import annotations

import math
from typing import Annotated, Self

import numpy as np
import numpy.typing as npt
from pydantic import Field, model_validator

from ..common.constants import EARTH_RADIUS_M
from ..common.records import Angle, Length, Record
from ..kernels.orbits.ephemeris import body_row

LARGEST_DECAY_M_PER_DAY = 1e5

Decay = Annotated[float, Field(ge=-LARGEST_DECAY_M_PER_DAY, le=LARGEST_DECAY_M_PER_DAY)]
"""Daily decrease of a semi-major axis [m]; negative for an increase."""

Offset = Annotated[tuple[float, float], Field(strict=False)]
"""Components towards the ascending node and towards a quarter of a revolution after it."""


class Fit(Record):
    """Fitted numbers of a body.

    ``eccentricity_offset``: constant part of the mean eccentricity vector, towards the ascending
    node and a quarter of a revolution later, to which that of the orbit is added; it is the work of
    odd zonal harmonics, above all J3.
    """

    eccentricity_offset: Offset = (0.0, 0.0)


class Orbit(Record):
    """Keplerian elements in the inertial frame at the epoch of the instance.

    Attributes
    ----------
    semi_major_axis_m : float
        [m]; the perigee is above the ground.
    eccentricity : float
        Less than 1.
    inclination_deg, raan_deg, argument_of_perigee_deg, true_anomaly_deg : float
        [deg]; on a circle the last two add up to the argument of latitude.
    """

    semi_major_axis_m: Length
    eccentricity: Annotated[float, Field(ge=0.0, lt=1.0)]
    inclination_deg: Annotated[float, Field(ge=0.0, le=180.0)]
    raan_deg: Angle
    argument_of_perigee_deg: Angle
    true_anomaly_deg: Angle

    @model_validator(mode="after")
    def _above_the_ground(self) -> Self:
        perigee = self.semi_major_axis_m * (1.0 - self.eccentricity)
        if perigee <= EARTH_RADIUS_M:
            raise ValueError(
                f"the perigee radius of {perigee:.0f} m is under the ground "
                f"({EARTH_RADIUS_M:.0f} m); raise semi_major_axis_m or lower eccentricity"
            )
        return self

    def circular_elements(self) -> tuple[float, float, float, float]:
        """The planning circle: radius, inclination, RAAN, argument of latitude.

        r = a and u = argument of perigee + mean anomaly (docs/model.md section 1) [m, rad].
        """
        e = self.eccentricity
        true = math.radians(self.true_anomaly_deg)
        eccentric = true - 2.0 * math.atan2(
            # atan(β sin ν / (1 + β cos ν)) form of E: no loss of digits, no branch at ν = π
            (e / (1.0 + math.sqrt(1.0 - e * e))) * math.sin(true),
            1.0 + (e / (1.0 + math.sqrt(1.0 - e * e))) * math.cos(true),
        )
        mean = eccentric - e * math.sin(eccentric)
        latitude = math.radians(self.argument_of_perigee_deg) + mean
        return (
            self.semi_major_axis_m,
            math.radians(self.inclination_deg),
            math.radians(self.raan_deg),
            latitude,
        )

    def row(self, oblateness_m2: float, decay_m_per_day: float = 0.0) -> tuple[float, ...]:
        """Kernel row: the circle, its rates, and the shape of the orbit.

        Parameters
        ----------
        oblateness_m2 : float
            J2 R², 0 for two bodies.
        decay_m_per_day : float
            By what the semi-major axis shrinks.

        Returns
        -------
        (columns,) float
            :data:`adr_opt.kernels.orbits.ephemeris.ORBIT_COLUMNS`.
        """
        return body_row(
            *self.circular_elements(),
            eccentricity=self.eccentricity,
            perigee=math.radians(self.argument_of_perigee_deg),
            oblateness_m2=oblateness_m2,
            decay_m_per_day=decay_m_per_day,
        )

    def eccentricity_vector(self) -> npt.NDArray[np.float64]:
        """Inertial eccentricity vector, shape (3,)."""
        i, o, w = (
            math.radians(x)
            for x in (self.inclination_deg, self.raan_deg, self.argument_of_perigee_deg)
        )
        node = np.array([math.cos(o), math.sin(o), 0.0])
        ahead = np.array(
            [-math.sin(o) * math.cos(i), math.cos(o) * math.cos(i), math.sin(i)], dtype=float
        )
        return self.eccentricity * (math.cos(w) * node + math.sin(w) * ahead)
