"""Screening: approaches of the objects of a catalogue to the arcs of a refined plan."""

from .approaches import Approach, approaches_csv, screen

__all__ = ["Approach", "approaches_csv", "screen"]
