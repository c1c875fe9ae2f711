"""The flown plan as states over time, and as files that other programs read.

:func:`sample` flies a plan arc by arc in the dynamics of its instance; :func:`body_states` says
where the station and the targets are meanwhile; :func:`write_plan` writes the flight as CCSDS OEM
or OPM, as CZML for Cesium, or as a GMAT script. Only NumPy is needed: states come in closed form,
from Kepler's equation and, where nodes drift, from secular rates.

Metres, metres per second, and seconds since the epoch of the instance, in the inertial frame of
its elements; the written files have kilometres where their formats demand them.
"""

from .bodies import body_positions, body_states
from .czml import to_czml
from .gmat import to_gmat
from .kepler import propagate
from .oem import to_oem
from .opm import to_opm
from .sampling import PHASES, Arc, LegPath, Trajectory, sample
from .write import FORMATS, FRAMES, write_plan

__all__ = [
    "FORMATS",
    "FRAMES",
    "PHASES",
    "Arc",
    "LegPath",
    "Trajectory",
    "body_positions",
    "body_states",
    "propagate",
    "sample",
    "to_czml",
    "to_gmat",
    "to_oem",
    "to_opm",
    "write_plan",
]
