"""Columns of a body: elements at t = 0, their secular rates, and what drag adds to the phase.

Known in this room alone: others ask :mod:`.ephemeris` for the elements of a body at a time, or
:mod:`.elements` for those of many. Rows are made by :func:`.ephemeris.body_row` and changed by
:mod:`.body_rows`.
"""

ORBIT_COLUMNS = (
    "radius",
    "inclination",
    "raan",
    "argument_of_latitude",
    "raan_rate",
    "latitude_rate",
    "eccentricity",
    "perigee",
    "perigee_rate",
    "latitude_acceleration",
)
(
    RADIUS,
    INCLINATION,
    RAAN,
    ARGUMENT_OF_LATITUDE,
    RAAN_RATE,
    LATITUDE_RATE,
    ECCENTRICITY,
    PERIGEE,
    PERIGEE_RATE,
    LATITUDE_ACCELERATION,
) = range(10)

COASTING_RAAN_RATE = len(ORBIT_COLUMNS)
"""Extra column in rows of bodies at departure: node rate of the chaser afterwards, if it leaves
from another orbit than the body's; see :mod:`adr_opt.plan.tows` [rad/s]."""
