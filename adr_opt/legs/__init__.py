"""Legs between bodies: connections and timetables."""
