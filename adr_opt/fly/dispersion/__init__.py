"""Dispersion of a flight: the tank and time a refined plan needs with burn and navigation errors.

A Monte Carlo analysis of dispersions. Each flight draws errors of every burn and of where the
chaser is when a leg begins (:mod:`.errors`); what a burn has left wrong is corrected at the burns
that are left of the leg, by linear feedback with the state-transition matrices of the refined
trajectory (:mod:`.feedback`). A few of the flights are flown again without linearisation
(:mod:`.flown_leg`).
"""

from .errors import FlightErrors
from .sample import sample_flights, usable_tank
from .spread import Dispersion, LegDispersion, Quantile, TankDispersion

__all__ = [
    "Dispersion",
    "FlightErrors",
    "LegDispersion",
    "Quantile",
    "TankDispersion",
    "sample_flights",
    "usable_tank",
]
