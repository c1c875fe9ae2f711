"""Families of legs, a module for each, and their registry."""

from . import registry
from .drift import DriftLegs
from .given import GivenLegs
from .launch import Launches
from .low_thrust import LowThrustLegs
from .short import ShortLegs

# In the order of their numbers, which is that in which they find connections.
registry.bring_along(ShortLegs(), DriftLegs(), Launches(), GivenLegs(), LowThrustLegs())
