"""The flown plan as states over time.

:func:`sample` flies a plan arc by arc in the dynamics of its instance; :func:`body_states` says
where the station and the targets are meanwhile; :mod:`adr_opt.export.flights` writes both. Only
NumPy is needed: states come in closed form, from Kepler's equation and, where nodes drift, from
secular rates.

Metres, metres per second, and seconds since the epoch of the instance, in the inertial frame of
its elements.
"""

from ...plan.phases import PHASES
from .bodies import body_positions, body_states
from .kepler import propagate
from .sampling import Arc, LegPath, Trajectory, sample

__all__ = [
    "PHASES",
    "Arc",
    "LegPath",
    "Trajectory",
    "body_positions",
    "body_states",
    "propagate",
    "sample",
]
