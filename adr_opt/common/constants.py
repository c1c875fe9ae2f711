"""Constants of the model: units of time, the Earth (EGM-96, WGS-84), the slack of limits."""

import math

HOUR_S = 3600.0
DAY_S = 24.0 * HOUR_S

MU_M3_S2 = 3.986004418e14
"""Gravitational parameter of the Earth [m³/s²]."""

EARTH_RADIUS_M = 6378137.0
"""Equatorial radius of the Earth [m]; altitudes are radii minus this."""

J2 = 1.08262668e-3
"""Second zonal harmonic of the Earth."""

OBLATENESS_M2 = J2 * EARTH_RADIUS_M**2
"""Factor common to all secular rates due to J2 [m²]."""

STANDARD_GRAVITY_M_S2 = 9.80665
"""Standard gravity, which turns a specific impulse in seconds into an exhaust speed."""

STATION = 0
"""Index of the refuelling station among the bodies."""

TURN_RAD = 2.0 * math.pi
"""A full turn [rad]."""

SLACK_S = 2.0**-20
SLACK_M_S = 2.0**-20
SLACK_M = 2.0**-10
"""Slack of the model: times [s], ΔV [m/s] or radii [m] that differ by less than this are equal.

Far above what rounding does to the figures of a mission, far below what can be flown. A chaser
that is ready a slack after a departure event still takes it; a tank and a mission may be overdrawn
by a slack in all; of sequences whose costs are equal the first counts; phasing radii and zones are
closed with a slack. Without it, rounding would decide wherever a chaser is ready exactly when an
event is, and planners, proofs and `check` would be told different things. Powers of two, so that
adding one and taking it away gives the same number again."""
