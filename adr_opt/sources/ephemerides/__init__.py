"""Ephemerides beside an instance: true states of bodies (docs/ephemerides.md).

:func:`ephemeris_of` gives that of a body, an object with ``state(times_s)``: position and velocity
in the inertial frame of the instance, vectorised over times. Behind it are element sets run by
SGP4, or CCSDS Orbit Ephemeris Messages, interpolated as they say.
"""

from .ephemeris import Ephemeris
from .of_instance import Ephemerides, ephemerides_of, ephemeris_of

__all__ = ["Ephemerides", "Ephemeris", "ephemerides_of", "ephemeris_of"]
