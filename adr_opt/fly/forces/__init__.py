"""Refined plans flown with all forces, in the integrator of a library.

What a refined plan leaves out is shown here: each leg is flown from its departure with its own
burns, with gravity to degree and order 20, atmospheric drag, the Sun, the Moon and radiation
pressure, by brahe (extra ``[forces]``). Nothing of :mod:`adr_opt` integrates. How far off a leg
arrives uncorrected is told twice: from where its plan has the body, and from that body under the
same forces since the departure; with each what a correction from a revolution before takes.
"""

from .flown import fly_forced
from .forced_flight import ForcedFlight, ForcedLeg, Off
from .settings import Forces

__all__ = ["ForcedFlight", "ForcedLeg", "Forces", "Off", "fly_forced"]
