"""Families of legs, and their registry."""

from . import registry
from .impulsive import DriftLegs, ShortLegs
from .low_thrust import LowThrustLegs
from .unflown import GivenLegs, Launches

# In the order of their numbers, which is that in which they find connections.
registry.bring_along(ShortLegs(), DriftLegs(), Launches(), GivenLegs(), LowThrustLegs())
