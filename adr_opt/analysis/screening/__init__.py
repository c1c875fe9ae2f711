"""Screening: approaches of the objects of a catalogue to the arcs of a refined plan."""

from .approaches import CloseApproach, approaches_csv, avoiding, screen
from .messages import conjunction_message
from .position_errors import PositionErrors, read_errors
from .probability import collision_probability

__all__ = [
    "CloseApproach",
    "PositionErrors",
    "approaches_csv",
    "avoiding",
    "collision_probability",
    "conjunction_message",
    "read_errors",
    "screen",
]
