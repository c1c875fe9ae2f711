"""The columns of a body: elements at t = 0, and their secular rates.

Known in this room alone: others ask :mod:`.ephemeris` for the elements of a body at a time, or
:mod:`.elements` for those of many. Rows are made by :func:`.ephemeris.body_row` and changed by
:mod:`.body_rows`.
"""

ORBIT_COLUMNS = (
    "radius", "inclination", "raan", "argument_of_latitude", "raan_rate", "latitude_rate",
    "eccentricity", "perigee", "perigee_rate",
)  # fmt: skip
(
    RADIUS, INCLINATION, RAAN, ARGUMENT_OF_LATITUDE, RAAN_RATE, LATITUDE_RATE,
    ECCENTRICITY, PERIGEE, PERIGEE_RATE,
) = range(9)  # fmt: skip

COASTING_RAAN_RATE = len(ORBIT_COLUMNS)
"""One column more in rows of bodies as they are left: how fast the node of the chaser moves after
that, where it leaves from another orbit than the body's; see :mod:`adr_opt.plan.tows` [rad/s]."""
