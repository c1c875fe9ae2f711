"""Timetables: legs by departure event, compiled."""
