"""Timetables: which legs leave when, compiled."""
