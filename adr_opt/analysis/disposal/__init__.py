"""Disposal: fates of a plan's objects and chasers, and compliance with licence rules."""

from .casualties import Debris, casualty_area_m2, density_per_km2
from .fates import Fate, fates
from .reentry import Reentry

__all__ = ["Debris", "Fate", "Reentry", "casualty_area_m2", "density_per_km2", "fates"]
