"""Flights of plans for other programs: OEM, OPM, CZML, GMAT.

:func:`write_plan` writes the flight of a plan as CCSDS OEM or OPM, as CZML for Cesium, or as a GMAT
script. The files have kilometres where their formats demand them.
"""

from .czml import to_czml
from .gmat import to_gmat
from .oem import to_oem
from .opm import to_opm
from .write import FORMATS, FRAMES, FlightFile, write_plan

__all__ = [
    "FORMATS",
    "FRAMES",
    "FlightFile",
    "to_czml",
    "to_gmat",
    "to_oem",
    "to_opm",
    "write_plan",
]
