"""Disposal: what becomes of the objects and the chasers of a plan, as a licence asks."""

from .casualties import Debris, casualty_area_m2, density_per_km2
from .fates import Fate, fates
from .reentry import Reentry

__all__ = ["Debris", "Fate", "Reentry", "casualty_area_m2", "density_per_km2", "fates"]
