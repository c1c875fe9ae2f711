"""The constants of the model (MODEL, preamble): values as in EGM-96 and WGS-84."""

MU_M3_S2 = 3.986004418e14
"""Gravitational parameter of the Earth [m³/s²]."""

EARTH_RADIUS_M = 6378137.0
"""Equatorial radius of the Earth [m]; altitudes are radii minus this."""

J2 = 1.08262668e-3
"""Second zonal harmonic of the Earth; the model does not use it, its warnings do."""

STATION = 0
"""Index of the refuelling station among the bodies."""
