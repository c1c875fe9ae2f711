"""Screening: approaches of the objects of a catalogue to the arcs of a refined plan."""

from .approaches import CloseApproach, approaches_csv, screen

__all__ = ["CloseApproach", "approaches_csv", "screen"]
